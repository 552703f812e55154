#include <algorithm>
#include <numbers>

#include "tests/random_scenes/generator/draft.hpp"

namespace stillframe::random_scenes {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Principal moments of a brick of these half sides (m), turned anyhow: a legal inertia.
Matrix3d brick_inertia(double mass, const Vector3d& half, const Matrix3d& turn) {
  const Vector3d squares = half.cwiseAbs2();
  const Vector3d moments = mass / 3 * (Vector3d::Constant(squares.sum()) - squares);
  const Matrix3d J = turn * moments.asDiagonal() * turn.transpose();
  return 0.5 * (J + J.transpose());
}

}  // namespace

void add_frame(Draft& draft) {
  Draws& draws = draft.draws;
  Body& frame = draft.frame;
  frame.node = "frame";
  frame.size = draws.scale(0.1, 2);
  frame.mass = draws.scale(0.3, 3000);
  frame.at = draws.chance(0.5) ? Vector3d::Zero() : Vector3d(2 * draws.point(draft.planar));
  draft.node("frame", frame.at);
  draft.points = {"frame"};
  // Sagging under its weight by less than a tenth of its size keeps it on its legs.
  const double lowest =
      draft.gravity ? std::sqrt(9.81 / (0.02 * frame.size)) / (2 * std::numbers::pi) : 0;
  draft.frequency_hz = std::max(draws.scale(1, 60), lowest);
  draft.damping_ratio = draws.chance(0.3) ? 0 : draws.between(0, 0.05);

  const bool point = draws.chance(0.15), guided = !point && draws.chance(0.1);
  frame.turns = !point && !guided;
  std::string mass = "{node: frame, mass: " + Draft::number(frame.mass);
  if (!point) {
    const Vector3d half =
        frame.size * Vector3d(draws.between(0.3, 1), draws.between(0.3, 1), draws.between(0.3, 1));
    const Matrix3d J = brick_inertia(frame.mass, half, draws.rotation(draft.planar));
    if (draft.planar) {
      mass += ", inertia: " + Draft::number(J(2, 2));
    } else {
      mass += ", inertia: [";
      for (int i = 0; i < 3; ++i) mass += (i ? ", " : "") + draft.vector(J.row(i));
      mass += "]";
    }
    draft.turning.push_back("frame");
  }
  draft.masses.push_back(mass + "}");
  if (guided) {
    draft.supports.push_back(draft.planar ? "{nodes: [frame], fix: [x, rotation]}"
                                          : "{nodes: [frame], fix: [x, y, rotation]}");
  }
}

}  // namespace stillframe::random_scenes

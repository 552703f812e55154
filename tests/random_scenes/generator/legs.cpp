#include <Eigen/SVD>
#include <algorithm>
#include <numbers>

#include "tests/random_scenes/generator/draft.hpp"

namespace stillframe::random_scenes {

using Eigen::MatrixXd;
using Eigen::Vector3d;

namespace {

/// Where a strut ends at the frame and which way it goes.
struct Line {
  Vector3d at, along;
};

/// What moves freely: rows x, y, z, and rotations about them times the size of the frame.
std::vector<int> free_coordinates(const Draft& draft, bool guided) {
  if (guided) return {draft.planar ? 1 : 2};
  if (draft.planar) return draft.frame.turns ? std::vector{0, 1, 5} : std::vector{0, 1};
  return draft.frame.turns ? std::vector{0, 1, 2, 3, 4, 5} : std::vector{0, 1, 2};
}

/// How badly lines hold the free coordinates: largest over smallest singular value.
double looseness(const std::vector<Line>& lines, const Body& frame, const std::vector<int>& free) {
  MatrixXd wrenches(6, lines.size());
  for (size_t i = 0; i < lines.size(); ++i) {
    const auto c = static_cast<Eigen::Index>(i);
    wrenches.col(c).head<3>() = lines[i].along;
    wrenches.col(c).tail<3>() = (lines[i].at - frame.at).cross(lines[i].along) / frame.size;
  }
  MatrixXd rows(free.size(), lines.size());
  for (size_t i = 0; i < free.size(); ++i) {
    rows.row(static_cast<Eigen::Index>(i)) = wrenches.row(free[i]);
  }
  const auto values = Eigen::JacobiSVD<MatrixXd>(rows).singularValues();
  return values(0) / std::max(values(values.size() - 1), 1e-300);
}

/// Lines that hold the frame, about the best of a few.
std::vector<Line> holding_lines(Draft& draft, size_t n, const std::vector<int>& free) {
  std::vector<Line> best;
  double least = 1e300;
  for (int trial = 0; trial < 200 && least > 8; ++trial) {
    std::vector<Line> lines;
    for (size_t i = 0; i < n; ++i) {
      const Vector3d at =
          draft.frame.at + (draft.frame.turns
                                ? Vector3d(draft.frame.size * draft.draws.point(draft.planar))
                                : Vector3d(Vector3d::Zero()));
      lines.push_back({at, draft.draws.direction(draft.planar)});
    }
    const double found = looseness(lines, draft.frame, free);
    if (found < least) {
      least = found;
      best = lines;
    }
  }
  return best;
}

void add_strut(Draft& draft, const std::string& name, const Line& line, bool is_leg) {
  Draws& draws = draft.draws;
  const Body& frame = draft.frame;
  const double omega = 2 * std::numbers::pi * draft.frequency_hz;
  Strut strut;
  strut.name = name;
  strut.floor = "floor_" + name;
  strut.along = line.along;
  strut.length = frame.size * draws.between(0.2, 1);
  strut.stiffness = frame.mass * omega * omega * draws.between(0.3, 1.2);
  strut.mount = draft.mount(frame, "mount_" + name, line.at);
  draft.node(strut.floor, line.at - strut.length * line.along);
  const double damping = 2 * draft.damping_ratio * strut.stiffness / omega;
  std::string text = name + ": {type: truss, nodes: [" + strut.floor + ", " + strut.mount +
                     "], stiffness: " + Draft::number(strut.stiffness);
  if (damping > 0) text += ", damping: " + Draft::number(damping);
  // A hundredth of its length bends the frame's equilibrium visibly and turns nothing over.
  if (draws.chance(0.2)) {
    text +=
        ", preload: " + Draft::number(strut.stiffness * 0.01 * strut.length * draws.between(-1, 1));
  }
  draft.elements.push_back(text + "}");
  strut.on_floor = is_leg || draws.chance(0.5);
  if (strut.on_floor) {
    draft.shakers.push_back(strut.floor);
  } else {
    draft.supports.push_back("{nodes: [" + strut.floor +
                             (draft.planar ? "], fix: [x, y]}" : "], fix: [x, y, z]}"));
  }
  if (is_leg) draft.legs.push_back(strut);
}

/// The elongations of the legs, where they are as many as the coordinates, or these.
void add_frame_dofs(Draft& draft, const std::vector<int>& free, bool by_legs) {
  static const std::vector<std::string> axes = {"x", "y", "z"};
  for (size_t i = 0; i < free.size(); ++i) {
    const auto axis = static_cast<size_t>(free[i]);
    draft.dofs.push_back(by_legs    ? "{element: leg_" + std::to_string(i + 1) + "}"
                         : axis < 3 ? "{node: frame, along: " + axes[axis] + "}"
                         : draft.planar
                             ? "{node: frame, rotation: true}"
                             : "{node: frame, euler_parameter: " + std::to_string(axis - 2) + "}");
  }
}

}  // namespace

void add_legs(Draft& draft) {
  Draws& draws = draft.draws;
  const bool guided = !draft.supports.empty();
  const std::vector<int> free = free_coordinates(draft, guided);
  const int n_free = static_cast<int>(free.size());
  const int most = n_free == 1 ? 3 : 2 * n_free;
  // As many legs as coordinates half of the time, else anything from one to 12.
  const int n_legs = draws.chance(0.5) ? n_free : draws.whole(1, most);
  const int n = std::max(n_legs, n_free) + (draws.chance(0.3) ? draws.whole(1, 2) : 0);
  const std::vector<Line> lines = holding_lines(draft, static_cast<size_t>(n), free);
  for (int i = 0; i < n; ++i) {
    const bool is_leg = i < n_legs;
    add_strut(draft, (is_leg ? "leg_" : "spring_") + std::to_string(i + 1),
              lines[static_cast<size_t>(i)], is_leg);
  }
  add_frame_dofs(draft, free, n_legs == n_free && draws.chance(0.5));
}

}  // namespace stillframe::random_scenes

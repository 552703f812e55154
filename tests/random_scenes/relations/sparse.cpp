#include <algorithm>
#include <limits>
#include <numbers>

#include "core/mechanics/modes.hpp"
#include "core/mechanics/node_moves.hpp"
#include "core/mechanics/partition/free_model.hpp"
#include "core/mechanics/sparse/damped_modes.hpp"
#include "core/mechanics/sparse/sparse_equilibrium.hpp"
#include "core/mechanics/sparse/sparse_response.hpp"
#include "tests/random_scenes/answers.hpp"

// The way of large models, displacements and stresses both unknown and no dofs, on small ones.
namespace stillframe::random_scenes {

namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// v^T D v / (2 omega) of a mode without damping.
double damping_ratio(const MixedModel& mixed, const MixedState& state, const VectorXd& v,
                     double omega) {
  const VectorXd e = mixed.strain_rows(state.x) * v;
  const double d = v.dot(mixed.damping(state.x) * v) +
                   e.cwiseAbs2().cwiseProduct(mixed.damping_time()).dot(mixed.stiffness());
  return d / (2 * omega);
}

/// How far the nearest of some values is from one.
double distance_to_nearest(const Eigen::VectorXcd& values, std::complex<double> value) {
  return (values.array() - value).abs().minCoeff();
}

/// At damped places, where the dense response says what rounding may do to it.
void compare_responses(Case& scene, const MixedModel& mixed, const MixedState& state, double eps,
                       Finding& finding) {
  const Answers& own = own_answers(scene);
  const auto at = places(scene);
  SparseResponse response(mixed, state,
                          mixed_signals(mixed, state, scene.scene().inputs, scene.scene().outputs));
  for (size_t i = 0; i < std::min(at.size(), own.responses.size()); ++i) {
    const Response& dense = own.responses[i];
    const Eigen::MatrixXcd G = response(at[i]);
    for (Index j = 0; j < G.rows(); ++j) {
      for (Index k = 0; k < G.cols(); ++k) {
        // Where motions of one output cancel, those of its other inputs are what is rounded.
        const double rounding = eps * dense.rounding.row(j).maxCoeff(),
                     largest = dense.G.row(j).cwiseAbs().maxCoeff();
        // Dense or sparse, a matrix that is singular to rounding has no response.
        if (rounding > largest) continue;
        finding.take(std::abs(G(j, k) - dense.G(j, k)), rounding + 20 * own.misplaced * largest,
                     "sparse response", std::abs(dense.G(j, k)));
      }
    }
  }
}

/// What supports and drives of a scene hold: forces along their directions.
std::vector<SceneSignal> held_directions(const Scene& scene) {
  std::vector<SceneSignal> held;
  for (const auto* constraints : {&scene.supports, &scene.prescribed}) {
    for (const SceneConstraint& constraint : *constraints) {
      if (constraint.node.empty()) continue;
      for (const Eigen::Vector3d& direction : constraint.directions) {
        SceneSignal& signal = held.emplace_back();
        signal.node = constraint.node;
        signal.place = constraint.place;
        signal.quantity = Quantity::reaction;
        signal.direction = direction;
      }
    }
  }
  return held;
}

/// What `equilibrium` prints: deformations, stress resultants and reactions. Both are as far from
/// the truth as their positions, which a stiff element makes forces of, and stresses as the largest
/// that they balance.
void compare_equilibria(Case& scene, const MixedModel& mixed, const MixedState& state, double eps,
                        Finding& finding) {
  const auto held = held_directions(scene.scene());
  Lineariser dense(scene.model(), {}, held, {.mass = false, .damping = false, .stiffness = false});
  const VectorXd y_0 = dense.about(scene.operating_point()).y_0,
                 reactions = reactions_at_rest(mixed, state, held);
  const Data& data = dense.data();
  const double moved = own_answers(scene).misplaced * shortest_element(scene.scene()) +
                       eps * scene_size(scene.model());
  double stiffest = 0;
  for (const ModelElement& item : mixed.model().elements) {
    if (item.S.size() > 0) stiffest = std::max(stiffest, item.S.cwiseAbs().maxCoeff());
  }
  const double largest = std::max(data.sigma.size() > 0 ? data.sigma.cwiseAbs().maxCoeff() : 0.0,
                                  y_0.size() > 0 ? y_0.cwiseAbs().maxCoeff() : 0.0);
  const double known =
      20 * (stiffest * moved + own_answers(scene).misplaced * largest) + std::sqrt(eps) * largest;
  for (const SceneElement& element : scene.scene().elements) {
    const auto k = static_cast<size_t>(mixed.model().element_index(element.name)),
               own = static_cast<size_t>(scene.model().element_index(element.name));
    const LocalDeformation e = mixed.deformations(k, state.x), sigma = mixed.stresses(k, state);
    for (Index i = 0; i < e.size(); ++i) {
      const Index row = scene.model().elements[own].row[static_cast<size_t>(i)];
      finding.take(std::abs(e(i) - data.e(row)), 20 * moved, "deformation of " + element.name,
                   std::abs(data.e(row)));
      finding.take(std::abs(sigma(i) - data.sigma(row)), known, "stress of " + element.name,
                   largest);
    }
  }
  for (Index i = 0; i < y_0.size(); ++i) {
    finding.take(std::abs(reactions(i) - y_0(i)), known, "reaction at a support", largest);
  }
}

}  // namespace

std::optional<Finding> check_sparse(Case& scene, std::uint64_t) {
  if (!scene.at_rest() || scene.scene().operating_point != OperatingPoint::equilibrium) {
    return std::nullopt;
  }
  if (scene.scene().modal_damping) return std::nullopt;  // it couples all, and goes the dense way
  const Model model = free_model(scene.scene());
  const Modes minimal = modes(scene.linear());
  if (!model.turning_loads.empty() || minimal.natural_frequencies_hz.size() == 0) {
    return std::nullopt;
  }
  const Index n_d = minimal.natural_frequencies_hz.size();
  const MixedModel mixed(model);
  const MixedState state = sparse_equilibrium(mixed).state;
  // What nothing resists may be anywhere under loads, and the others' frequencies depend on where.
  const Answers& own = own_answers(scene);
  const double eps = 10 * static_cast<double>(model.n_c) * std::numeric_limits<double>::epsilon();
  if (own.squares(0) <= eps * own.squares_rounding(0) && !state.x.isZero(0)) return std::nullopt;
  const Modes sparse = sparse_modes(mixed, state, n_d);
  Finding finding;
  if (sparse.natural_frequencies_hz.size() != n_d) {
    finding.take(1, 0, "number of natural frequencies");
    return finding;
  }
  const double misplaced = 20 * own.misplaced * own.squares.maxCoeff();
  const VectorXd omega = 2 * std::numbers::pi * sparse.natural_frequencies_hz;
  VectorXd bounds(n_d);
  for (Index i = 0; i < n_d; ++i) {
    const double known_to = 2 * sparse.known_to(2 * i) * (omega(i) + sparse.known_to(2 * i));
    bounds(i) = eps * own.squares_rounding(i) + known_to + misplaced;
    finding.take(std::abs(omega(i) * omega(i) - own.squares(i)), bounds(i),
                 "natural frequency " + std::to_string(i + 1), own.squares(i));
  }
  // Of all modes, and of the lower half, which damping mixes with those that are left out.
  Index n_not_found = 0;
  for (const Modes& found : {sparse, sparse_modes(mixed, state, std::max<Index>(1, n_d / 2))}) {
    // A pair about to part, or to meet another, moves by the root of what its matrix does.
    const double largest = minimal.eigenvalues.cwiseAbs().maxCoeff();
    Index n_ringing = 0;
    for (Index i = 0; i < found.eigenvalues.size(); ++i) {
      const std::complex<double> value = found.eigenvalues(i);
      const double size = std::abs(value);
      if (std::isnan(size)) continue;
      n_ringing += value.imag() != 0 || size <= found.known_to(i) ? 1 : 0;
      finding.take(distance_to_nearest(minimal.eigenvalues, value),
                   std::sqrt(eps) * size + eps * largest + std::sqrt(bounds.minCoeff()),
                   "eigenvalue with damping", size);
    }
    // What damping keeps from ringing lies close together, and may be left out.
    for (Index i = 0; i < found.shapes.cols(); ++i) {
      if (damping_ratio(mixed, state, found.shapes.col(i), omega(i)) < 0.5) n_ringing -= 2;
    }
    n_not_found += std::max<Index>(0, -n_ringing);
  }
  compare_responses(scene, mixed, state, eps, finding);
  compare_equilibria(scene, mixed, state, eps, finding);
  finding.take(static_cast<double>(n_not_found), 0, "values that were not found");
  return finding;
}

}  // namespace stillframe::random_scenes

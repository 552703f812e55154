#pragma once

#include <functional>

#include "core/control/design/control_loop.hpp"
#include "core/mechanics/modes.hpp"
#include "core/mechanics/sparse/sparse_scene.hpp"
#include "core/mechanics/unstable.hpp"
#include "tools/json.hpp"

namespace stillframe::tools {

/// What a shape moves most: "table x 1, table ry 0.2 (m and rad over the largest)". Of the dofs of
/// a model (n_d), and of the free coordinates (n_c) of one without dofs, at x.
std::string what_moves(const Model& model, const LinearModel& linear, const Eigen::VectorXd& shape);
std::string what_moves(const Model& model, const Eigen::VectorXd& x, const Eigen::VectorXd& shape);

/// For the verbs that answer about an operating point whether or not it is one that a scene stays
/// at: a line of warning to stderr where it is not stable, with what moves. Answers what the key
/// "stable" of their JSON is: true, false, or null where it is not known.
Json warn_unless_stable(const Model& model, const LinearModel& linear);
/// Likewise where modes(), of a mixed model at a state, throws Unstable or does not.
Json warn_unless_stable(const MixedModel& mixed, const MixedState& state,
                        const std::function<void()>& modes);

/// Errors: those of solve(), of Unstable with what_of(shape), which moves.
template <class Solve, class WhatOf>
auto with_what_moves(const Solve& solve, const WhatOf& what_of) {
  try {
    return solve();
  } catch (const Unstable& error) {
    throw Refusal(std::string(error.what()) + ", which moves " + what_of(error.shape()));
  }
}

/// The reduced model of a scene with `reduce`, with these inputs and outputs. Errors: as
/// reduced_model, of Unstable with what moves.
ReducedModel stable_reduced_model(const Scene& scene, const LoopSignals& signals);

/// That of its loop; bounds are those of the passive scene, w to y.
ReducedModel stable_reduced_loop(const Scene& scene);

}  // namespace stillframe::tools

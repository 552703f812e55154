#pragma once

#include "core/mechanics/linearisation/linearisation.hpp"

namespace stillframe {

/// Critical multiples of the reference load: (K + lambda G) v = 0, with K of the unloaded scene
/// with its prescribed values (and the G of what these strain) and G at the stresses that the
/// scene's loads, gravity and preloads cause to first order. Source: deck, section 9.
struct Buckling {
  std::vector<std::string> q_names;
  Eigen::VectorXd load_multipliers;  ///< the positive ones, smallest first
  Eigen::MatrixXd shapes;            ///< n_d x as many, largest entry 1
};

/// What both ways to them share: the refusals of a scene without a load and of one whose K is not
/// positive definite (for a coordinate that nothing resists, or empty), and the scale of shapes.
[[noreturn]] void refuse_without_load();
[[noreturn]] void refuse_free_to_move(const std::string& coordinate);
void scale_to_largest(Eigen::MatrixXd& shapes);

/// Errors: Refusal if the scene has no load, if a prescribed motion has a rate or an acceleration,
/// if K is not positive definite (the unloaded scene can move freely), or if G is not symmetric (a
/// load that follows a node, or a torque in space that does not, may cause flutter, which has no
/// multiplier of this kind).
Buckling buckling(const Model& model);

}  // namespace stillframe

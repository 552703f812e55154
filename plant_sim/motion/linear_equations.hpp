#pragma once

#include "core/scene/rigid_bodies.hpp"
#include "plant_sim/motion/frame_points.hpp"
#include "plant_sim/motion/minimal_equations.hpp"

namespace stillframe {

/// MinimalEquations linearised about their equilibrium, in the same state y (n),
///   dy/dt = A y + B_p q^r + B_v q'^r + B_a q''^r + B_u sigma_a + B_f f,
///   sigma_e = S_y y + S_p q^r + S_v q'^r,   v = V_y y + V_r q'^r,
/// with sigma_a of the legs (n_legs, N), nodal forces f (n_x, N), velocities v of points of the
/// frame. Set-up. Source: deck, sections 5 to 8; THEORY section 2.
struct LinearEquations {
  Eigen::MatrixXd A, B_p, B_v, B_a, B_u, B_f;
  Eigen::MatrixXd S_y, S_p, S_v, V_y, V_r;

  /// Errors: Refusal if M is not positive definite.
  LinearEquations(const MinimalEquations& equations, const Scene& scene, const Equilibrium& rest,
                  const FramePoints& points);
};

}  // namespace stillframe

#pragma once

#include "plant_sim/motion/frame_points.hpp"
#include "plant_sim/motion/minimal_equations.hpp"

namespace stillframe {

/// MinimalEquations linearised about their operating point, in the same state y (n),
///   dy/dt = A y + B_p w + B_v w' + B_a w'' + B_u sigma_a + B_f f,
///   sigma_e = S_y y + S_p w + S_v w',   v = V_y y + V_r w',
/// with the floor's part w of the prescribed motion (n_r), sigma_a of the legs (n_legs, N), nodal
/// forces f (n_x, N), velocities v of points of the frame. Set-up. Source: deck, sections 5 to 8;
/// THEORY section 2.
struct LinearEquations {
  Eigen::MatrixXd A, B_p, B_v, B_a, B_u, B_f;
  Eigen::MatrixXd S_y, S_p, S_v, V_y, V_r;

  /// Errors: Refusal if M is not positive definite.
  LinearEquations(const MinimalEquations& equations, const NominalMotion& nominal,
                  const FramePoints& points);
};

}  // namespace stillframe

#pragma once

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "core/systems/state_space_model.hpp"

namespace stillframe::test {

inline constexpr double frame_leg_stiffness = 3.95e6;

/// Mass matrix of the metrology frame in the elongations of its legs, E^-T diag(m, m, m, I) E^-1.
/// Data: THEORY section 3.
inline Eigen::MatrixXd frame_mass_matrix() {
  Eigen::Matrix<double, 6, 6> E;
  for (int mount = 0; mount < 3; ++mount) {
    const double angle = 2 * std::numbers::pi * mount / 3, c = std::cos(angle), s = std::sin(angle);
    const Eigen::Vector3d arm(0.6 * c, 0.6 * s, -0.1), tangential(-s, c, 0), vertical(0, 0, 1);
    E.row(2 * mount) << tangential.transpose(), arm.cross(tangential).transpose();
    E.row(2 * mount + 1) << vertical.transpose(), arm.cross(vertical).transpose();
  }
  const Eigen::Matrix<double, 6, 6> inverse = E.inverse();
  const Eigen::Vector<double, 6> mass(750, 750, 750, 57, 57, 45);
  return inverse.transpose() * mass.asDiagonal() * inverse;
}

enum class FrameOutputs { accelerations_and_stresses, accelerations_and_elongations };

/// The undamped frame on its legs: q their elongations, M q'' + k q = -M w'' - sigma_a, 12 states.
/// Inputs: w'' (six motions, three columns each) and sigma_a; outputs: q'' + w'', and sigma = k q +
/// sigma_a or q. As M (q'' + w'') = -sigma, the first choice of outputs has rank 6 at every
/// frequency; the second has rank 12 and very small singular values.
inline StateSpace frame_state_space(FrameOutputs outputs) {
  using Kind = InputColumns::Kind;
  const Eigen::MatrixXd I = Eigen::MatrixXd::Identity(6, 6),
                        M_inverse = frame_mass_matrix().inverse();
  StateSpace out{.A = Eigen::MatrixXd::Zero(12, 12),
                 .B = Eigen::MatrixXd::Zero(12, 24),
                 .C = Eigen::MatrixXd::Zero(12, 12),
                 .D = Eigen::MatrixXd::Zero(12, 24),
                 .columns = {},
                 .inputs = {},
                 .outputs = {},
                 .states = {},
                 .x0 = {},
                 .u0 = {},
                 .y0 = {}};
  out.A.topRightCorner(6, 6) = I;
  out.A.bottomLeftCorner(6, 6) = -frame_leg_stiffness * M_inverse;
  for (Eigen::Index leg = 0; leg < 6; ++leg) {
    out.columns.push_back({Kind::acceleration, 3 * leg});
    out.B(6 + leg, 3 * leg) = -1;
  }
  for (Eigen::Index leg = 0; leg < 6; ++leg) out.columns.push_back({Kind::direct, 18 + leg});
  out.B.bottomRightCorner(6, 6) = -M_inverse;
  out.C.topLeftCorner(6, 6) = -frame_leg_stiffness * M_inverse;
  out.D.topRightCorner(6, 6) = -M_inverse;
  const bool stresses = outputs == FrameOutputs::accelerations_and_stresses;
  out.C.bottomLeftCorner(6, 6) = (stresses ? frame_leg_stiffness : 1.0) * I;
  if (stresses) out.D.bottomRightCorner(6, 6) = I;
  return out;
}

}  // namespace stillframe::test

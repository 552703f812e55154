#pragma once

#include <Eigen/Core>

namespace stillframe {

/// Consistent mass of a beam whose axis is the cubic r = N_1 x_p + N_2 l_0 t_p + N_3 x_q + N_4 l_0
/// t_q with the unit end tangents t: kinetic energy v^T M v / 2 of the rates of (x_p, t_p, x_q,
/// t_q), each axis of space alone. 4 x 4, from the mass per length, kg/m, and the length, m.
inline Eigen::Matrix4d hermite_mass(double mass_per_length, double l_0) {
  const double l = l_0;
  Eigen::Matrix4d M;
  M << 156, 22 * l, 54, -13 * l,              //
      22 * l, 4 * l * l, 13 * l, -3 * l * l,  //
      54, 13 * l, 156, -22 * l,               //
      -13 * l, -3 * l * l, -22 * l, 4 * l * l;
  return mass_per_length * l_0 / 420 * M;
}

/// The four vectors that the mass multiplies, as columns.
using HermiteVectors = Eigen::Matrix<double, 3, 4>;

}  // namespace stillframe

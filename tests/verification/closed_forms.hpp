#pragma once

#include <Eigen/Core>
#include <vector>

namespace stillframe::verification {

/// Roots a of cos a cosh a = sign, the k-th from 1 (a = 0 left out): -1 cantilever, +1 clamped or
/// free at both ends. Natural frequencies are a^2 sqrt(EI / (mu L^4)).
double beam_root(int k, int sign);

/// The first root of tan a = a: a column clamped at one end and pinned at the other.
double clamped_pinned_root();

/// A cantilever of unit length, mass and EI that rotates at gamma about its root, by Ritz's method
/// with polynomials x^2 P_k(2 x - 1) up to degree 17, which leaves an error below 1e-12:
///   w'''' - (T w')' = omega^2 w, T = gamma^2 (1 - x^2) / 2.
struct RotatingBeam {
  double flap = 0, lag = 0;  ///< lag^2 = flap^2 - gamma^2
  double fourth = 0;         ///< integral of w''''^2 over integral of w^2
  double tension = 0;        ///< integral of T w''^2 over integral of w^2
  /// -integral of 6 gamma^2 x w'' w''' over integral of w^2: the centrifugal work on what a cubic
  /// between the nodes leaves out of the shortening u of a deflection that is cubic there,
  /// u' = -w'^2 / 2.
  double shortening = 0;
};
RotatingBeam rotating_beam(double gamma);

/// Lateral buckling load of a narrow cantilever of unit length, EI and GJ:
///   v'' + P (1 - x) a = 0, a'' - P (1 - x) v'' = 0, whose first root is 4.012599 (Bessel function
///   J_-1/4(P / 2) = 0 by its power series).
double lateral_buckling_load();
/// The same by Ritz's method with n elements of cubic v and linear twist a.
double lateral_buckling_by_ritz(int n);

}  // namespace stillframe::verification

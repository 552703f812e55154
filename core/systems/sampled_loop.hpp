#pragma once

#include <Eigen/Core>
#include <complex>

#include "core/systems/sampled_plant.hpp"

namespace stillframe {

/// Plant and law as one linear discrete system in balanced states (of no unit of their own), v[k]
/// the noise of the force sensors (m, N) in sample k:
///   xi[k+1] = A xi[k] + B w[k] + B_v v[k],   y[k+1] = C xi[k] + D w[k] + D_v v[k].
/// y[k+1] and the w[k] held up to it travel in the same measurement; the transfer function between
/// those two is C (z I - A)^-1 B + D.
struct SampledLoop {
  Eigen::MatrixXd A, B, B_v, C, D, D_v;
  Eigen::Index n_exogenous = 0;  ///< leading states that w alone drives
  double sample_time = 0;        ///< s
};

/// The same system without feedback (zero commands), for the passive prediction.
SampledLoop open_loop(const SampledPlant& plant);

/// A closed loop must have a spectral radius below this to be called stable.
/// Without a leak the pure integrator cancels the static spring and leaves poles at exactly 1
/// (THEORY section 4, fact 2). After balancing, those come out within 1e-13 of 1; the bound leaves
/// four decades for larger models. It refuses nothing of use: at 10 kHz it stands for a decay over
/// 100 000 s, and a leak of as little as 1 mHz decays at 1e-7 a sample.
inline constexpr double largest_stable_radius = 1.0 - 1e-9;

/// Largest modulus of the eigenvalues of the feedback part of A (floor integrators left out);
/// infinite where they are not known.
double spectral_radius(const SampledLoop& loop);

/// T(e^{j omega T_s}), y from w: n_y x p. omega in rad/s.
Eigen::MatrixXcd transfer(const SampledLoop& loop, double omega);

/// y from the noise of the force sensors, at e^{j omega T_s}: n_y x m, m/s^2 per N.
Eigen::MatrixXcd noise_transfer(const SampledLoop& loop, double omega);

}  // namespace stillframe

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/systems/linear_system.hpp"

namespace stillframe {

/// Noise of one channel, of the channel's unit, xi white of variance 1:
///   v[k+1] = kept v[k] + fresh xi[k],   v[0] of deviation `first`;   kept from 0 to 1.
struct NoiseProcess {
  double kept = 0, fresh = 0, first = 0;

  /// White of this deviation in every sample.
  static NoiseProcess white(double deviation) {
    return {.kept = 0, .fresh = deviation, .first = deviation};
  }
  /// Of this variance from the first sample on.
  static NoiseProcess stationary(double kept, double variance);

  /// One-sided, unit^2/Hz: 2 T_s fresh^2 / |z - kept|^2. sample_time: T_s, s.
  double density(double hz, double sample_time) const;
};

/// Noise of one kind, alike in all channels of a system and independent from channel to channel:
/// the sum of independent processes.
using NoiseKind = std::vector<NoiseProcess>;

/// What each output of a sampled system y = C x + D v is expected to have in the mean square over
/// n samples, the first of which is y[0], from x[0] = 0: the mean of the diagonal of
/// (C D) P_k (C D)^T, P_k the covariance of (x, v)[k], summed by doubling. Of a stable system and a
/// stationary process it tends to what Lyapunov's equation says. Set-up, about 10 N^3 log2 n
/// multiplications of N states. Source: docs/decisions/0032-error-budget.md.
Eigen::VectorXd mean_square_over(const LinearSystem& system, const NoiseProcess& process,
                                 std::int64_t n);

/// How noise of one kind is spread over frequency behind a system, outputs x cells.
struct NoisePower {
  Eigen::MatrixXd power;       ///< unit^2, the integral of the density over each cell
  Eigen::MatrixXd integrated;  ///< unit^2 s^2, the same of the density over (2 pi f)^2; 0 from 0 Hz
};

/// The power of every kind in the cells between edges_hz (ascending, from 0 to half the rate), of a
/// stable system: sum over the channels of |G(e^{j omega T_s})|^2 times the density, integrated
/// adaptively (Gauss and Kronrod) from the angles of the poles outwards, so that no resonance is
/// between two points, to 1e-6 of each part. Set-up. Errors: as FrequencySweep.
std::vector<NoisePower> noise_power(const LinearSystem& system, const std::vector<NoiseKind>& kinds,
                                    double sample_time, const Eigen::VectorXd& edges_hz);

}  // namespace stillframe

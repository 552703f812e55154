#pragma once

#include <Eigen/Core>
#include <array>

namespace stillframe::floor {

/// Causal fourth-order Butterworth high-pass: two biquads, zero initial state.
///   H(s) = s^4 / ((s^2 + 2 cos(pi/8) w_c s + w_c^2) (s^2 + 2 cos(3 pi/8) w_c s + w_c^2)),
/// made discrete by the bilinear transform with the corner kept at its place. Its four zeros stand
/// exactly at z = 1, so that the second sum of what it lets through (a position) is bounded
/// wherever the input is. Source: the bilinear transform of the Butterworth polynomial, any text on
/// digital filters.
class HighPass {
 public:
  /// corner_hz: where the gain is -3 dB. Errors: std::invalid_argument unless
  /// 0 < corner_hz < sample_rate_hz / 2.
  HighPass(double corner_hz, double sample_rate_hz);

  /// Output for the next input sample. Hot: noexcept, no allocation.
  double step(double input) noexcept;
  /// Back to the zero state.
  void reset() noexcept;

 private:
  struct Section {
    double gain, a1, a2;        // gain (1 - z^-1)^2 / (1 + a1 z^-1 + a2 z^-2)
    double s1 = 0.0, s2 = 0.0;  // transposed direct form II
  };
  std::array<Section, 2> sections_;
};

/// Filters each row of `rows` (channels x samples) in place, each from the zero state.
void high_pass_rows(double corner_hz, double sample_rate_hz, Eigen::MatrixXd& rows);

/// The rms that white noise of unit rms has behind the filter, sqrt(sum h[k]^2), h its impulse
/// response.
double white_noise_gain(double corner_hz, double sample_rate_hz);

}  // namespace stillframe::floor

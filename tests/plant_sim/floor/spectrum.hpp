#pragma once

#include <Eigen/Core>
#include <cmath>
#include <complex>
#include <numbers>

namespace stillframe::floor::testing {

/// Four-term Blackman-Harris window of n samples, of mean 1: lines 4 or more bins apart do not mix,
/// to -92 dB.
inline Eigen::VectorXd blackman_harris(Eigen::Index n) {
  Eigen::VectorXd window(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const double x = 2.0 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(n);
    window(k) =
        1.0 - (0.48829 * std::cos(x) - 0.14128 * std::cos(2.0 * x) + 0.01168 * std::cos(3.0 * x)) /
                  0.35875;
  }
  return window;
}

/// The phasor of the line at f in x (row of samples at rate fs), windowed, time counted from
/// first_sample: x = Re(phasor exp(2 pi j f t)) gives the phasor. A plain sum, no FFT.
template <typename Row>
std::complex<double> line(const Row& x, double f, double fs, Eigen::Index first_sample = 0) {
  const Eigen::VectorXd window = blackman_harris(x.size());
  std::complex<double> sum = 0.0;
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    const double turns = f * static_cast<double>(k + first_sample) / fs;
    sum +=
        window(k) * x(k) * std::polar(1.0, -2.0 * std::numbers::pi * (turns - std::floor(turns)));
  }
  return 2.0 * sum / static_cast<double>(x.size());
}

}  // namespace stillframe::floor::testing

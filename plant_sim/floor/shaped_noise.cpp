#include "plant_sim/floor/shaped_noise.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <stdexcept>
#include <vector>

#include "core/numerics/smooth_step.hpp"
#include "kissfft/kissfft.hh"
#include "plant_sim/floor/held_acceleration.hpp"
#include "plant_sim/floor/resample.hpp"
#include "plant_sim/floor/white.hpp"

namespace stillframe::floor {

namespace {

using Complex = std::complex<double>;

/// Amplitude (half of a cosine's) of each line of a period, from 0 up to below half the rate.
std::vector<double> line_amplitudes(const NoiseShape& shape, std::int64_t n, bool positions) {
  const double spacing = shape.rate / static_cast<double>(n);
  std::vector<double> amplitudes(static_cast<std::size_t>((n + 1) / 2), 0.0);
  for (std::size_t b = 1; b < amplitudes.size(); ++b) {
    const double f = spacing * static_cast<double>(b);
    const double passed = 1.0 / (1.0 + std::pow(shape.high_pass_hz / f, 8));
    const double amplitude = std::sqrt(0.5 * density_at(shape.density, f) * passed * spacing);
    amplitudes[b] = positions ? amplitude / held_acceleration_gain(f, shape.rate) : amplitude;
  }
  return amplitudes;
}

}  // namespace

Eigen::MatrixXd periodic_noise(const NoiseShape& shape, const std::vector<Eigen::Index>& channels,
                               bool positions) {
  if (!(shape.rate > 0.0) || shape.period < 1) {
    throw std::invalid_argument("periodic_noise: expected a rate above 0 and a period, got " +
                                std::to_string(shape.rate) + " and " +
                                std::to_string(shape.period));
  }
  const std::int64_t n = next_quick_length(shape.period);
  const std::vector<double> amplitudes = line_amplitudes(shape, n, positions);
  const auto n_lines = static_cast<Eigen::Index>(amplitudes.size());
  const Eigen::MatrixXd gaussian = gaussian_noise(shape.seed, channels, 2 * n_lines);
  const kissfft<double> backward(static_cast<std::size_t>(n), true);
  std::vector<Complex> lines(static_cast<std::size_t>(n)), sum(lines.size());
  Eigen::MatrixXd noise(n, gaussian.rows());
  for (Eigen::Index i = 0; i < noise.cols(); ++i) {
    std::fill(lines.begin(), lines.end(), Complex(0.0, 0.0));
    for (std::size_t b = 1; b < amplitudes.size(); ++b) {
      const auto column = static_cast<Eigen::Index>(2 * b);
      const double phase = std::atan2(gaussian(i, column + 1), gaussian(i, column));
      lines[b] = std::polar(amplitudes[b], phase);
      lines[lines.size() - b] = std::conj(lines[b]);
    }
    backward.transform(lines.data(), sum.data());
    for (Eigen::Index k = 0; k < n; ++k) noise(k, i) = sum[static_cast<std::size_t>(k)].real();
  }
  return noise;
}

NoiseFloor::NoiseFloor(FloorChannels meaning, Eigen::MatrixXd patterns, Eigen::MatrixXd positions,
                       double rate, std::int64_t n_samples, std::int64_t fade)
    : meaning_(meaning),
      patterns_(std::move(patterns)),
      positions_(std::move(positions)),
      rate_(rate),
      n_samples_(n_samples),
      fade_(fade) {
  if (patterns_.cols() != positions_.cols() || positions_.rows() < 1 || n_samples < 1 || fade < 0 ||
      2 * fade > n_samples) {
    throw std::invalid_argument(
        "NoiseFloor: expected a pattern for each noise, samples, and fades that do not overlap");
  }
}

double NoiseFloor::weight(std::int64_t k) const noexcept {
  const std::int64_t from_end = n_samples_ - 1 - k;
  const std::int64_t inside = std::min(k, from_end);
  if (inside <= 0) return 0.0;
  return inside < fade_ ? smooth_step(static_cast<double>(inside) / static_cast<double>(fade_))
                        : 1.0;
}

void NoiseFloor::add(std::int64_t k, Eigen::Ref<Eigen::VectorXd> out) const noexcept {
  if (k < 0 || k >= n_samples_) return;
  const Eigen::Index n = positions_.rows();
  const Eigen::Index here = k % n, before = (k + n - 1) % n, after = (k + 1) % n;
  const double w_before = weight(k - 1), w_here = weight(k), w_after = weight(k + 1);
  for (Eigen::Index i = 0; i < positions_.cols(); ++i) {
    out += held_acceleration(w_before * positions_(before, i), w_here * positions_(here, i),
                             w_after * positions_(after, i), rate_) *
           patterns_.col(i);
  }
}

}  // namespace stillframe::floor

#include "plant_sim/floor/high_pass.hpp"

#include <cmath>
#include <cstdint>
#include <numbers>
#include <stdexcept>

namespace stillframe::floor {

HighPass::HighPass(double corner_hz, double sample_rate_hz) {
  if (!(corner_hz > 0.0) || !(corner_hz < 0.5 * sample_rate_hz)) {
    throw std::invalid_argument("HighPass: expected 0 < corner_hz < sample_rate_hz / 2, got " +
                                std::to_string(corner_hz) + " at " +
                                std::to_string(sample_rate_hz));
  }
  const double c = std::tan(std::numbers::pi * corner_hz / sample_rate_hz);
  for (std::size_t i = 0; i < sections_.size(); ++i) {
    const double twice_damping =
        2.0 * std::cos((2.0 * static_cast<double>(i) + 1.0) * std::numbers::pi / 8.0);
    const double denominator = 1.0 + twice_damping * c + c * c;
    sections_[i] = Section{.gain = 1.0 / denominator,
                           .a1 = 2.0 * (c * c - 1.0) / denominator,
                           .a2 = (1.0 - twice_damping * c + c * c) / denominator};
  }
}

double HighPass::step(double input) noexcept {
  double value = input;
  for (Section& s : sections_) {
    const double scaled = s.gain * value;
    const double output = scaled + s.s1;
    s.s1 = -2.0 * scaled - s.a1 * output + s.s2;
    s.s2 = scaled - s.a2 * output;
    value = output;
  }
  return value;
}

void HighPass::reset() noexcept {
  for (Section& s : sections_) s.s1 = s.s2 = 0.0;
}

void high_pass_rows(double corner_hz, double sample_rate_hz, Eigen::MatrixXd& rows) {
  HighPass filter(corner_hz, sample_rate_hz);
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    filter.reset();
    for (Eigen::Index k = 0; k < rows.cols(); ++k) rows(i, k) = filter.step(rows(i, k));
  }
}

double white_noise_gain(double corner_hz, double sample_rate_hz) {
  HighPass filter(corner_hz, sample_rate_hz);
  // The slowest pole decays as exp(-0.38 w_c t), so ten periods of the corner leave less than
  // 1e-10.
  const auto n = static_cast<std::int64_t>(10.0 * sample_rate_hz / corner_hz) + 1;
  double energy = 0.0;
  for (std::int64_t k = 0; k < n; ++k) {
    const double h = filter.step(k == 0 ? 1.0 : 0.0);
    energy += h * h;
  }
  return std::sqrt(energy);
}

}  // namespace stillframe::floor

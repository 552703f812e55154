#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "core/numerics/worst.hpp"
#include "plant_sim/floor/high_pass.hpp"

namespace stillframe::floor {
namespace {

std::vector<double> impulse_response(double corner, double fs, int n) {
  HighPass filter(corner, fs);
  std::vector<double> h;
  for (int k = 0; k < n; ++k) h.push_back(filter.step(k == 0 ? 1.0 : 0.0));
  return h;
}

TEST(HighPass, GainIsButterworthsOnTheWarpedFrequency) {
  const double fs = 1000.0, corner = 0.5;
  const auto h = impulse_response(corner, fs, 40000);  // 40 s: the slowest pole is down to exp(-48)
  const double warped_corner = std::tan(std::numbers::pi * corner / fs);
  for (const double f : {0.1, 0.3, 0.5, 1.0, 5.0, 80.0, 450.0}) {
    std::complex<double> gain = 0.0;
    for (std::size_t k = 0; k < h.size(); ++k) {
      gain += h[k] * std::polar(1.0, -2.0 * std::numbers::pi * f * static_cast<double>(k) / fs);
    }
    const double ratio = warped_corner / std::tan(std::numbers::pi * f / fs);
    // |H|^2 = 1 / (1 + (w_c / w)^8); the sum of 4e4 terms of size up to 1 rounds at 1e-12.
    EXPECT_NEAR(std::norm(gain), 1.0 / (1.0 + std::pow(ratio, 8)), 1e-11) << f << " Hz";
  }
}

TEST(HighPass, TheSecondSumOfAConstantVanishes) {
  // Four zeros at z = 1: even the third sum of the answer to a constant dies out. The second sum is
  // what a position is; a filter with one zero too few would leave it constant, with three too few
  // growing.
  HighPass filter(0.5, 4000.0);
  double velocity = 0.0, position = 0.0, largest = 0.0;
  for (int k = 0; k < 4000 * 60; ++k) {
    velocity += filter.step(1.0) / 4000.0;
    position += velocity / 4000.0;
    largest = worst_of(largest, std::abs(position));
  }
  // Of size 1 / w_c^2 = 0.1 m on the way, and after 60 s (poles down to exp(-72)) only rounding,
  // which two sums collect: 2.4e5 samples * 1e-16 * 60 s = 1e-9.
  EXPECT_GT(largest, 0.01);
  EXPECT_LT(std::abs(position), 1e-9);
}

TEST(HighPass, WhiteNoiseGainIsParsevals) {
  const double fs = 1000.0, corner = 20.0;
  double energy = 0.0;
  const int n = 20000;
  for (int i = 0; i < n; ++i) {
    const double f = (i + 0.5) / n * 0.5 * fs;
    const double ratio =
        std::tan(std::numbers::pi * corner / fs) / std::tan(std::numbers::pi * f / fs);
    energy += 1.0 / (1.0 + std::pow(ratio, 8)) / n;
  }
  // A midpoint sum of a smooth periodic function: exact to rounding; the impulse response is cut at
  // 1e-10.
  EXPECT_NEAR(white_noise_gain(corner, fs), std::sqrt(energy), 1e-9);
}

TEST(HighPass, ResetMeansTheZeroState) {
  HighPass filter(0.5, 1000.0);
  const double first = filter.step(1.0);
  const double second = filter.step(1.0);
  EXPECT_NE(first, second);
  filter.reset();
  EXPECT_EQ(filter.step(1.0), first);
  EXPECT_EQ(filter.step(1.0), second);
  Eigen::MatrixXd rows = Eigen::MatrixXd::Ones(2, 2);
  high_pass_rows(0.5, 1000.0, rows);
  EXPECT_EQ(rows(0, 0), first);
  EXPECT_EQ(rows(1, 0), first);
  EXPECT_EQ(rows(1, 1), second);
}

TEST(HighPass, CornerMustLieBelowNyquist) {
  EXPECT_THROW(HighPass(0.0, 1000.0), std::invalid_argument);
  EXPECT_THROW(HighPass(500.0, 1000.0), std::invalid_argument);
  EXPECT_THROW(HighPass(std::nan(""), 1000.0), std::invalid_argument);
}

}  // namespace
}  // namespace stillframe::floor

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "core/numerics/worst.hpp"
#include "plant_sim/floor/resample.hpp"

namespace stillframe::floor {
namespace {

constexpr double rate_in = 200.0;

/// A sum of sines of amplitude 1 at odd frequencies, so that nothing falls on a bin.
double closed_form(double t, const std::vector<double>& frequencies) {
  double sum = 0.0;
  for (const double f : frequencies) sum += std::sin(2.0 * std::numbers::pi * f * t + f);
  return sum;
}

Eigen::MatrixXd sampled(double rate, Eigen::Index n, const std::vector<double>& frequencies) {
  Eigen::MatrixXd x(1, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    x(0, k) = closed_form(static_cast<double>(k) / rate, frequencies);
  }
  return x;
}

class ResampleRates : public ::testing::TestWithParam<double> {};

TEST_P(ResampleRates, SumOfSinesMatchesItsClosedFormAwayFromTheTapers) {
  const double rate_out = GetParam();
  const std::vector<double> frequencies = {0.77, 7.123, 31.41, 64.9, 80.3};
  const Eigen::Index n = 6143;  // a prime: no length may be special
  Eigen::MatrixXd x = sampled(rate_in, n, frequencies);
  taper_ends(x, 200);
  const auto ratio = rational_ratio(rate_in, rate_out);
  ASSERT_TRUE(ratio);
  const Eigen::MatrixXd y = resample(x, *ratio);
  ASSERT_EQ(y.cols(), (n - 1) * ratio->up / ratio->down + 1);
  const double duration = static_cast<double>(n - 1) / rate_in;
  double worst = 0.0;
  for (Eigen::Index k = 0; k < y.cols(); ++k) {
    const double t = static_cast<double>(k) / rate_out;
    if (t < 3.0 || t > duration - 3.0) continue;
    worst = worst_of(worst, std::abs(y(0, k) - closed_form(t, frequencies)));
  }
  // A raised-cosine taper of 1 s jumps by pi^2 / 2 in its second derivative at each of its corners,
  // so a tapered sine spills pi^2 / 2 / (2 pi df)^3 at df from its line. Integrated over what lies
  // beyond the Nyquist rate (df = 19.7 Hz from the highest line), and seen t after the corner, that
  // is pi^2 / 2 / 124^3 / (2 pi t): 2.1e-7 for t = 2 s, 1.4e-7 for t = 3 s, the corners of a taper;
  // sampling folds it back, which doubles it to 7e-7. The other lines add a fifth of that and less.
  EXPECT_LT(worst, 1e-6);
}

TEST_P(ResampleRates, EnergyIsKept) {
  const auto ratio = *rational_ratio(rate_in, GetParam());
  Eigen::MatrixXd x = sampled(rate_in, 4000, {3.3, 41.7, 77.7});
  taper_ends(x, 200);
  const Eigen::MatrixXd y = resample(x, ratio);
  // Parseval holds to rounding for the padded length; what the cut at the end leaves out and what
  // lies beyond the Nyquist rate are below the taper's spill of the test above, squared.
  EXPECT_NEAR(y.squaredNorm() / GetParam(), x.squaredNorm() / rate_in,
              1e-9 * x.squaredNorm() / rate_in);
}

TEST_P(ResampleRates, OldSamplesStayWhatTheyWere) {
  const auto ratio = *rational_ratio(rate_in, GetParam());
  // White content up to and including the Nyquist rate, where a careless split of that line would
  // show.
  Eigen::MatrixXd x(1, 1500);
  for (Eigen::Index k = 0; k < x.cols(); ++k) {
    x(0, k) = std::sin(static_cast<double>(k * k % 9973)) + (k % 2 == 0 ? 1.0 : -1.0);
  }
  const Eigen::MatrixXd y = resample(x, ratio);
  for (Eigen::Index k = 0; k * ratio.down < x.cols(); ++k) {
    // Rounding of two transforms of 1e4 points of size 1.
    EXPECT_NEAR(y(0, k * ratio.up), x(0, k * ratio.down), 1e-12);
  }
}

INSTANTIATE_TEST_SUITE_P(Rates, ResampleRates,
                         ::testing::Values(200.0, 300.0, 1000.0 / 3.0, 512.0, 1000.0, 4000.0));

TEST(Resample, ALowerRateCutsTheSpectrumAtItsNyquistRate) {
  const double rate_out = 150.0;
  const auto ratio = *rational_ratio(rate_in, rate_out);
  Eigen::MatrixXd low = sampled(rate_in, 6000, {12.3, 40.1});
  Eigen::MatrixXd both = sampled(rate_in, 6000, {12.3, 40.1, 90.7});
  taper_ends(low, 200);
  taper_ends(both, 200);
  const Eigen::MatrixXd y_low = resample(low, ratio), y_both = resample(both, ratio);
  // Sampling every 4/3 without the cut would fold the line of amplitude 1 from 90.7 to 59.3 Hz.
  // With it nothing stays of it in the middle but the taper's spill below 75 Hz, 15.7 Hz away,
  // seen 6.5 and 7.5 s after its corners: pi^2 / 2 / 98.6^3 / (2 pi) (1 / 6.5 + 1 / 7.5) = 2.4e-7.
  const Eigen::Index quarter = y_low.cols() / 4;
  EXPECT_LT(worst_of((y_both - y_low).middleCols(quarter, 2 * quarter)), 3e-7);
  // The line at 40.1 Hz is 34.9 Hz from the cut: a factor (15.7 / 34.9)^3 less.
  for (Eigen::Index k = quarter; k < 3 * quarter; ++k) {
    EXPECT_NEAR(y_low(0, k), closed_form(static_cast<double>(k) / rate_out, {12.3, 40.1}), 1e-7);
  }
}

TEST(Resample, RatiosAreFoundInLowestTerms) {
  const auto expect = [](double in, double out, std::int64_t up, std::int64_t down) {
    const auto ratio = rational_ratio(in, out);
    ASSERT_TRUE(ratio) << in << " to " << out;
    EXPECT_EQ(ratio->up, up);
    EXPECT_EQ(ratio->down, down);
  };
  expect(200, 1000, 5, 1);
  expect(200, 300, 3, 2);
  expect(200, 150, 3, 4);
  expect(200, 200, 1, 1);
  expect(1000, 1, 1, 1000);
  expect(99.9, 1000, 10000, 999);
  expect(51.2, 4000, 625, 8);
  EXPECT_FALSE(rational_ratio(200, 200 * std::numbers::pi));
  EXPECT_FALSE(rational_ratio(200, 1e9));
  EXPECT_FALSE(rational_ratio(0, 100));
}

TEST(Resample, ShapesAreChecked) {
  Eigen::MatrixXd x = Eigen::MatrixXd::Ones(1, 10);
  EXPECT_THROW(taper_ends(x, 6), std::invalid_argument);
  EXPECT_THROW(resample(Eigen::MatrixXd(3, 0), {5, 1}), std::invalid_argument);
  taper_ends(x, 4);
  // (1 - cos(pi k / 4)) / 2 at k = 0, 2 and beyond the taper.
  EXPECT_EQ(x(0, 0), 0.0);
  EXPECT_DOUBLE_EQ(x(0, 2), 0.5);
  EXPECT_EQ(x(0, 5), 1.0);
  EXPECT_EQ(x(0, 9), 0.0);
}

}  // namespace
}  // namespace stillframe::floor

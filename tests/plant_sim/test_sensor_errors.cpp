#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <iostream>

#include "core/numerics/two_pi.hpp"
#include "core/numerics/worst.hpp"
#include "plant_sim/sensor_errors.hpp"

// What the sensors add, by its statistics: each bound is five standard deviations of the estimate.
namespace stillframe {
namespace {

using Eigen::Index;

constexpr double sample_time = 1e-3, density = 2e-3;  // s, N/sqrt(Hz)

/// The errors alone, legs x samples.
Eigen::MatrixXd drawn(const ForceSensorErrors& errors, Index n_legs, Index n_samples,
                      double filter_hz = 0) {
  ForceSensorNoise noise(n_legs, errors, sample_time, filter_hz);
  Eigen::MatrixXd values = Eigen::MatrixXd::Zero(n_legs, n_samples);
  for (Index k = 0; k < n_samples; ++k) {
    if (k > 0) noise.next();
    Eigen::VectorXd sigma = Eigen::VectorXd::Zero(n_legs);
    noise.apply(sigma);
    values.col(k) = sigma;
  }
  return values;
}

double variance(const Eigen::MatrixXd& values) { return values.squaredNorm() / values.size(); }

TEST(ForceSensorNoise, IsWhiteOfItsDensity) {
  const Eigen::MatrixXd v = drawn({.noise = density}, 6, 20'000);
  const double expected = density * density / 2 / sample_time;
  const double n = static_cast<double>(v.size());
  EXPECT_NEAR(variance(v), expected, 5 * std::sqrt(2 / n) * expected);
  EXPECT_NEAR(v.mean(), 0, 5 * std::sqrt(expected / n));
  // Of one sample with the next ones, and of one leg with another: products of independent numbers.
  for (Index lag = 1; lag < 4; ++lag) {
    const Index m = v.cols() - lag;
    const double covariance = v.leftCols(m).cwiseProduct(v.rightCols(m)).mean();
    EXPECT_NEAR(covariance, 0, 5 * expected / std::sqrt(6.0 * static_cast<double>(m)));
  }
  // Nor do squares know of each other; that of a Gaussian has the variance 2.
  const Eigen::MatrixXd s = (v.cwiseAbs2().array() / expected - 1).matrix();
  const Index m = v.cols() - 1;
  EXPECT_NEAR(s.leftCols(m).cwiseProduct(s.rightCols(m)).mean(), 0,
              5 * 2 / std::sqrt(6.0 * static_cast<double>(m)));
  EXPECT_NEAR(v.row(0).dot(v.row(1)) / 20'000, 0, 5 * expected / std::sqrt(20'000));
}

TEST(ForceSensorNoise, HasPassedTheFilter) {
  for (const double corner_hz : {30.0, 200.0, 1000.0}) {
    const Eigen::MatrixXd v = drawn({.noise = density}, 6, 20'000, corner_hz);
    // White noise of this density, held in steps of 1 ns, behind the exact low-pass.
    constexpr double fine = 1e-9;
    const double through = -std::expm1(-two_pi * corner_hz * fine);
    const double expected = density * density / (2 * fine) * through / (2 - through);
    // n samples of correlation a are worth n (1 - a^2) / (1 + a^2) for a variance.
    const double a = std::exp(-two_pi * corner_hz * sample_time);
    const double n = static_cast<double>(v.size()) * (1 - a * a) / (1 + a * a);
    EXPECT_NEAR(variance(v), expected, 5 * std::sqrt(2 / n) * expected) << corner_hz;
    // From the first sample on.
    EXPECT_NEAR(variance(drawn({.noise = density}, 4000, 1, corner_hz)), expected,
                5 * std::sqrt(2.0 / 4000) * expected);
    const Index m = v.cols() - 1;
    const double covariance = v.leftCols(m).cwiseProduct(v.rightCols(m)).mean();
    EXPECT_NEAR(covariance, a * expected, 5 * std::sqrt(2 / n) * expected) << corner_hz;
  }
}

/// One-sided density of the rows at a frequency (N^2/Hz), from pieces under a Hann window.
double density_at(const Eigen::MatrixXd& values, double hz, Index length) {
  Eigen::VectorXcd window(length);
  for (Index k = 0; k < length; ++k) {
    window(k) = (1 - std::cos(two_pi * (static_cast<double>(k) + 0.5) / length)) *
                std::polar(1.0, -two_pi * hz * sample_time * static_cast<double>(k));
  }
  double sum = 0;
  Index pieces = 0;
  for (Index begin = 0; begin + length <= values.cols(); begin += length) {
    sum += (values.middleCols(begin, length) * window).squaredNorm();
    pieces += values.rows();
  }
  // The mean square of the window is 3/2.
  return 2 * sample_time * sum / (1.5 * static_cast<double>(length * pieces));
}

TEST(ForceSensorNoise, RisesBelowItsCornerAsOneOverF) {
  constexpr double corner = 10;
  const Eigen::MatrixXd v = drawn({.noise = density, .flicker_below_hz = corner}, 256, 8192);
  for (const double hz : {1.0, 3.0, 10.0, 30.0, 100.0}) {
    // Pieces of eight periods or more: the window, two lines wide, does not see the slope.
    const auto length = static_cast<Index>(std::exp2(std::ceil(std::log2(16 / hz / sample_time))));
    const Index used = std::min<Index>(length, v.cols());
    const double is = density_at(v, hz, used) / (density * density);
    const double n = 256.0 * static_cast<double>(v.cols() / used);
    std::cout << hz << " Hz: " << is << ", " << 1 + corner / hz << "\n";
    // A density of n pieces errs by 1 / sqrt(n); 5 % is what poles above the highest one, at three
    // times or more of the frequencies where flicker counts, and the window leave open.
    EXPECT_NEAR(is / (1 + corner / hz), 1, 5 / std::sqrt(n) + 0.05) << hz;
  }
}

TEST(ForceSensorNoise, WalksAndDrifts) {
  constexpr Index n = 4000, legs = 400;
  const double rate = 0.3;
  const Eigen::MatrixXd w = drawn({.random_walk = rate}, legs, n + 1);
  EXPECT_TRUE((w.col(0).array() == 0).all());
  for (const Index k : {Index{100}, n}) {
    const double expected = rate * rate * static_cast<double>(k) * sample_time;
    EXPECT_NEAR(variance(w.col(k)), expected, 5 * std::sqrt(2.0 / legs) * expected) << k;
  }
  const Eigen::MatrixXd d = drawn({.offset = {1, 2, 3}, .drift = {-0.5}}, 3, 101);
  for (Index leg = 0; leg < 3; ++leg) {
    EXPECT_DOUBLE_EQ(d(leg, 100), static_cast<double>(leg) + 1 - 0.05);
  }
  EXPECT_THROW(drawn({.offset = {1, 2}}, 3, 1), std::invalid_argument);
}

TEST(ForceSensorNoise, IsTheSameWhateverElseIsOn) {
  const Eigen::MatrixXd alone = drawn({.noise = density, .seed = 5}, 3, 50);
  const ForceSensorErrors more{
      .noise = density, .flicker_below_hz = 20, .random_walk = 0.1, .offset = {1}, .seed = 5};
  ForceSensorErrors others = more;
  others.noise = 0;  // leaves offset and walk; the flicker goes with the noise
  ForceSensorErrors white_less = more;
  white_less.flicker_below_hz = 0;
  // The walk is there in both, so the white noise is the difference. Rounding of sums of some N.
  const Eigen::MatrixXd difference = drawn(white_less, 3, 50) - drawn(others, 3, 50);
  EXPECT_LT(worst_of(difference - alone), 1e-14);
  // More legs leave the first ones as they are; another seed is another noise.
  EXPECT_EQ(drawn({.noise = density, .seed = 5}, 6, 50).topRows(3), alone);
  EXPECT_NE(drawn({.noise = density, .seed = 6}, 3, 50), alone);
}

TEST(ForceSensorNoise, RoundsAndClips) {
  ForceSensorNoise noise(5, {.range = 1.0, .quantisation = 0.3}, sample_time, 0);
  Eigen::VectorXd sigma(5);
  sigma << 0.14, 0.16, -0.5, 5, -0.97;
  EXPECT_EQ(noise.apply(sigma), 1);                     // one of them is out of range
  const double expected[] = {0, 0.3, -0.6, 0.9, -0.9};  // 0.9 is the last step within the range
  for (int i = 0; i < 5; ++i) EXPECT_DOUBLE_EQ(sigma(i), expected[i]) << i;
  // Rounding of a signal over many steps is noise of variance q^2 / 12; by 1/2500 steps at a time
  // the sum differs from the integral by less than 1e-6 of it.
  Eigen::VectorXd ramp = Eigen::VectorXd::LinSpaced(50'001, -0.9 - 0.15, 0.9 + 0.15), before = ramp;
  ForceSensorNoise wide(ramp.size(), {.quantisation = 0.3}, sample_time, 0);
  EXPECT_EQ(wide.apply(ramp), 0);
  EXPECT_NEAR((ramp - before).squaredNorm() / ramp.size(), 0.3 * 0.3 / 12, 1e-4 * 0.3 * 0.3);
  ForceSensorNoise clip(5, {.range = 2.0}, sample_time, 0);
  sigma << 0.1, 2.1, -7, 2, -2;
  EXPECT_EQ(clip.apply(sigma), 2);
  EXPECT_EQ(sigma, (Eigen::VectorXd(5) << 0.1, 2, -2, 2, -2).finished());
}

TEST(FloorSensorNoise, IsWhiteAndOfItsOwn) {
  constexpr Index n = 20'000;
  const FloorSensorNoise noise(3, {.noise = density, .seed = 1}, sample_time);
  Eigen::MatrixXd v(3, n);
  for (Index k = 0; k < n; ++k) {
    Eigen::VectorXd a = Eigen::VectorXd::Constant(3, 1e-300);
    noise.apply(k, a);
    v.col(k) = a;
  }
  const double expected = density * density / 2 / sample_time;
  EXPECT_NEAR(variance(v), expected, 5 * std::sqrt(2.0 / (3 * n)) * expected);
  const Eigen::MatrixXd force = drawn({.noise = density, .seed = 1}, 3, n);
  EXPECT_NEAR(v.cwiseProduct(force).mean(), 0, 5 * expected / std::sqrt(3.0 * n));
}

}  // namespace
}  // namespace stillframe

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <stdexcept>

#include "core/numerics/smooth_step.hpp"
#include "core/numerics/worst.hpp"
#include "report/spectra/fourier.hpp"
#include "report/spectra/running_power.hpp"
#include "report/spectra/spectra.hpp"
#include "report/spectra/windows.hpp"
#include "tests/report/expect_error.hpp"

namespace stillframe::report {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double pi = std::numbers::pi;

double uniform(std::mt19937_64& random) {
  return std::ldexp(static_cast<double>(random() >> 11), -53);
}

/// Gaussian noise of a given rms (Box and Muller), the same on every library.
VectorXd noise(Index n, double rms, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  return VectorXd::NullaryExpr(n, [&](Index) {
    return rms * std::sqrt(-2 * std::log(1 - uniform(random))) * std::cos(2 * pi * uniform(random));
  });
}

VectorXd sine(Index n, double rate, double frequency, double amplitude) {
  return VectorXd::NullaryExpr(n, [=](Index k) {
    return amplitude * std::sin(2 * pi * frequency * static_cast<double>(k) / rate + 0.3);
  });
}

/// Welch's estimate as its definition reads: direct sums, no FFT, one frequency and segment after
/// another.
VectorXd direct_welch(const VectorXd& x, double rate, Index n) {
  VectorXd result = VectorXd::Zero(n / 2 + 1);
  int n_segments = 0;
  for (Index start = 0; start + n <= x.size(); start += (n + 1) / 2) ++n_segments;
  double window_power = 0;
  for (Index i = 0; i < n; ++i) window_power += std::pow(std::sin(pi * double(i) / double(n)), 4);
  for (int s = 0; s < n_segments; ++s) {
    const Index start = s * ((n + 1) / 2);
    // The sum of a Hann window is n / 2.
    double mean = 0;
    for (Index i = 0; i < n; ++i) {
      mean += 2 * std::pow(std::sin(pi * double(i) / double(n)), 2) * x(start + i) / double(n);
    }
    for (Index k = 0; k <= n / 2; ++k) {
      std::complex<double> sum = 0;
      for (Index i = 0; i < n; ++i) {
        const double w = std::pow(std::sin(pi * double(i) / double(n)), 2);
        sum += w * (x(start + i) - mean) * std::polar(1.0, -2 * pi * double(k * i % n) / double(n));
      }
      const bool two_sided = k == 0 || 2 * k == n;
      result(k) += (two_sided ? 1 : 2) * std::norm(sum) / (rate * window_power * n_segments);
    }
  }
  return result;
}

TEST(Welch, AgreesWithDirectSumsForEvenAndOddSegments) {
  const VectorXd x = noise(300, 1, 5).array() + 0.5;
  for (const Index n : {64, 63, 50, 7}) {
    const Psd psd = welch(x, 200, n);
    const VectorXd expected = direct_welch(x, 200, n);
    ASSERT_EQ(psd.density.size(), expected.size());
    // Sums of 64 terms in another order: rounding.
    EXPECT_LT(worst_of(psd.density - expected), 1e-13) << n;
    EXPECT_DOUBLE_EQ(psd.resolution_hz, 200.0 / static_cast<double>(n));
  }
}

TEST(Welch, ParsevalOfOneSegment) {
  // The integral of the estimate is sum (w (x - mean))^2 / sum w^2, exactly.
  for (const Index n : {128, 127}) {
    const VectorXd x = noise(n, 2, 9);
    const VectorXd hann =
        (Eigen::ArrayXd::LinSpaced(n, 0, double(n - 1)) * pi / double(n)).sin().square();
    const double mean = hann.dot(x) / hann.sum();
    double power = 0, window_power = 0;
    for (Index i = 0; i < n; ++i) {
      const double w = hann(i);
      power += std::pow(w * (x(i) - mean), 2);
      window_power += w * w;
    }
    const Psd psd = welch(x, 1000, n);
    // Rounding of 128 terms.
    EXPECT_NEAR(band_rms(psd, 0, 500), std::sqrt(power / window_power), 1e-12);
    EXPECT_NEAR(cumulative_rms(psd).tail(1)(0), std::sqrt(power / window_power), 1e-12);
  }
}

TEST(Welch, LevelOfWhiteNoise) {
  const double rate = 1000, rms = 3e-4;
  const Index n = 400000, segment = 4000;
  const Psd psd = welch(noise(n, rms, 1), rate, segment);
  const double level = rms * rms / (rate / 2);
  // 199 half-overlapping Hann segments: relative variance (1 + 2 (1/6)^2) / 199 a bin; neighbouring
  // bins correlate, which doubles the variance of the mean over 1999 of them: sqrt(1.056 / 199 * 2
  // / 1999) = 0.23 %, four times that.
  EXPECT_NEAR(psd.density.segment(1, 1999).mean() / level, 1, 0.0092);
  const double deviation =
      std::sqrt((psd.density.segment(2, 1996).array() / level - 1).square().mean());
  // The scatter itself, 7.3 %, known to about 1 / sqrt(2 * 1000) = 2.2 %; four times that.
  EXPECT_NEAR(deviation / std::sqrt(1.056 / 199), 1, 0.09);
}

TEST(Welch, RefusesSegmentsThatDoNotFit) {
  const VectorXd x = VectorXd::Zero(10);
  expect_error<std::invalid_argument>([&] { welch(x, 1, 11); }, "must be 2 to 10, got 11");
  expect_error<std::invalid_argument>([&] { welch(x, 1, 1); }, "got 1");
  expect_error<std::invalid_argument>([&] { welch(x, 0, 4); }, "rate");
  EXPECT_EQ(default_segment_length(10, 1), 10);
  EXPECT_EQ(default_segment_length(100000, 1000), 16000);
}

// Twelve seconds and seven samples, a prime number: its transform takes 0.4 s a channel.
TEST(Welch, OfAShortRunTakesALengthThatIsQuick) {
  EXPECT_EQ(default_segment_length(12007, 1000), 12000);
  EXPECT_EQ(default_segment_length(997, 1000), 997);
  const VectorXd x = noise(12007, 1e-3, 1);
  RunningWelch estimate(1000, 16000);
  estimate.add(x);
  EXPECT_EQ(estimate.finish().density, welch(x.head(12000), 1000, 12000).density);
}

/// The root of what a transform of the whole record has in a band, per sample.
double direct_band_rms(const VectorXd& x, double rate, double lower_hz, double upper_hz) {
  const Eigen::VectorXcd X = fourier(x);
  double power = 0;
  for (Index k = 0; k < X.size(); ++k) {
    const double f = rate * static_cast<double>(k) / static_cast<double>(x.size());
    if (f >= lower_hz && f < upper_hz) power += 2 * std::norm(X(k));
  }
  return std::sqrt(power) / static_cast<double>(x.size());
}

/// A second or two, less than a window, and records that are no whole number of its quarters.
TEST(Power, ItsIntegralIsTheMeanSquareOfTheSamples) {
  const double rate = 200;
  for (const Index n : {2, 300, 3199, 3200, 3201, 12345}) {
    VectorXd x = noise(n, 1, 5).array() + 0.5;
    x.head(n / 4) *= 7;
    const double mean = x.mean();
    const Psd power = power_of(x, rate);
    // Sums of some 10^4 terms in another order.
    EXPECT_NEAR(band_rms(power, 0, 100), std::sqrt((x.array() - mean).square().mean()),
                1e-11 * x.norm())
        << n;
    EXPECT_NEAR(cumulative_rms(power).tail(1)(0), band_rms(power, 0, 100), 1e-11 * x.norm());
  }
}

/// Ends that are livelier than the middle, offsets and slow motion: all that Welch's segments would
/// get wrong.
TEST(Power, BandsAreThoseOfATransformOfTheWholeRecord) {
  const double rate = 500;
  const Index n = 30000;
  VectorXd x = noise(n, 1, 3);
  for (Index k = 0; k < n; ++k) {
    const double t = static_cast<double>(k) / rate;
    x(k) *= 1 + 5 * std::exp(-t / 4) + 4 * std::exp((t - 60) / 2);
    x(k) += 3 * std::exp(-t / 10) * std::sin(2 * pi * 7.3 * t);
  }
  x.array() += 100;
  const double welch_rms = band_rms(welch(x, rate, 8000), 1, 80);
  const Psd power = power_of(x, rate);
  for (const auto& [lower, upper] : {std::pair(1.0, 80.0), {0.5, 5.0}, {5.0, 9.0}, {80.0, 200.0}}) {
    // An edge is known to three bins of 1/60 Hz: of white noise 1/20 Hz of the band's width each,
    // half of that in the rms, less as both sides blur; a factor of two is left.
    EXPECT_NEAR(band_rms(power, lower, upper) / direct_band_rms(x, rate, lower, upper), 1,
                0.05 / (upper - lower) + 1e-3)
        << lower;
  }
  EXPECT_LT(welch_rms, 0.95 * direct_band_rms(x, rate, 1, 80));
}

TEST(Power, PartsAreTheWholeAndMissingSamplesHoldNothing) {
  const double rate = 100;
  const VectorXd x = noise(20000, 1, 8);
  const Psd whole = power_of(x, rate);
  RunningPower parts(rate);
  for (Index begin = 0, n = 1; begin < x.size();
       begin += n, n = std::min(2 * n, x.size() - begin)) {
    parts.add(x.segment(begin, n));
  }
  EXPECT_EQ(parts.finish().density, whole.density);
  RunningPower gapped(rate);
  gapped.skip(10);
  gapped.add(x.head(1000));  // less than a window
  gapped.skip(3);
  gapped.add(x.segment(1003, 9000));
  gapped.skip(1'000'000'000'000);
  gapped.add(x.tail(5000));
  const double mean = x.head(1000).mean();
  const double sum = (x.head(1000).array() - mean).square().sum() +
                     (x.segment(1003, 9000).array() - mean).square().sum() +
                     (x.tail(5000).array() - mean).square().sum();
  EXPECT_NEAR(band_rms(gapped.finish(), 0, 50), std::sqrt(sum / 15000), 1e-11);
  EXPECT_EQ(power_of(x.head(1), rate).density.size(), 0);
  expect_error<std::invalid_argument>([] { RunningPower(std::nan("")); }, "sample rate");
}

// A slow wave that begins and ends at a height has nothing at 10 to 80 Hz but its two steps.
TEST(Power, WhatTheEndsLeaveInABandIsWhatTheirJumpsSay) {
  constexpr double rate = 500;
  for (const double phase : {0.3, 1.0, 2.0}) {
    VectorXd x(30'137);
    for (Index k = 0; k < x.size(); ++k) {
      x(k) = std::sin(2 * std::numbers::pi * 0.2 * static_cast<double>(k) / rate + phase);
    }
    const Psd whole = power_of(x, rate);
    // The steps' cross term is a cosine that goes round 60 s x 70 Hz times in the band, and the
    // slopes add (0.2 / 10)^2: a few per cent, and bins at the edges.
    EXPECT_NEAR(band_rms(whole, 10, 80) / jumps_in_band(whole, 10, 80), 1, 0.05) << phase;
    // A gap has two more.
    RunningPower power(rate);
    power.add(x.head(12'000));
    power.skip(500);
    power.add(x.tail(17'637));
    const Psd gapped = power.finish();
    EXPECT_NEAR(band_rms(gapped, 10, 80) / jumps_in_band(gapped, 10, 80), 1, 0.05) << phase;
    const auto square = [&](Index k) { return std::pow(x(k) - x.head(12'000).mean(), 2); };
    EXPECT_NEAR(gapped.jumps, square(0) + square(11'999) + square(12'500) + square(30'136), 1e-3);
  }
}

TEST(Windows, ShareOfAToneBeyondItsLobe) {
  // A window of 4000 samples in a record of 64 times its length: bins of 1/64.
  const Index n = 4000, fine = 64;
  VectorXd padded = VectorXd::Zero(n * fine);
  padded.head(n) = hann_squared(n);
  const VectorXd power = fourier(padded).cwiseAbs2();
  const double total = 2 * power.sum() - power(0);
  for (const int bins : {0, 1, 2, 3, 5, 11}) {
    double beyond = power.tail(power.size() - fine * bins - 1).sum() + 0.5 * power(fine * bins);
    // Sums and trapezoids of 1/64 of a bin; at 11 bins 2e-11 of the whole is left, which a sum of
    // 1e5 rounded squares shows to a few per cent.
    EXPECT_NEAR(beyond_lobe(bins) / (beyond / total), 1, bins > 5 ? 0.05 : 0.01) << bins;
  }
  // Windows a fifth apart weigh every sample alike.
  for (Index k = 0; k < n / 5; ++k) {
    double sum = 0;
    for (Index i = k; i < n; i += n / 5) sum += std::pow(hann_squared(n)(i), 2);
    ASSERT_NEAR(sum, 175.0 / 128, 1e-12);
    k += 37;
  }
}

/// Lively below 0.84 Hz and nearly still above, as a frame with a target of 1 Hz may be.
VectorXd beside_a_band(double rate, Index n, double fade_s, VectorXd& within) {
  within = VectorXd::Zero(n);
  VectorXd x(n);
  for (Index k = 0; k < n; ++k) {
    const double t = static_cast<double>(k) / rate, end = static_cast<double>(n) / rate;
    const double up = std::min({1.0, t / fade_s, (end - t) / fade_s});
    const double faded = fade_s > 0 ? smooth_step(up) : 1;
    x(k) = faded * (std::sin(2 * pi * 0.805 * t) + std::sin(2 * pi * 0.835 * t + 1));
    within(k) = 1e-3 * faded * (std::sin(2 * pi * 0.97 * t) + std::sin(2 * pi * 1.03 * t + 2));
  }
  x += within;
  return x;
}

// Windows of 16 s read 0.2 in the band of 1 Hz, for 0.001.
TEST(Power, WhatIsBesideABandStaysOutOfIt) {
  const double rate = 50;
  const auto band = third_octave_bands().front();
  VectorXd within;
  const VectorXd x = beside_a_band(rate, 15'000, 80, within);
  const Psd power = power_of(x, rate);
  const double exact = std::sqrt(within.squaredNorm() / 15'000);
  // 11 bins of 1/200 Hz from the edge: 2e-11 of the power of one, 5e-6 of the rms; the fades
  // broaden each line by 1/80 Hz, of which more reaches over.
  EXPECT_NEAR(band_rms(power, band.lower_hz, band.upper_hz), exact, 0.02 * exact);
  EXPECT_LT(leak_in_band(power, band.lower_hz, band.upper_hz), 0.2 * exact);
}

// A record that breaks off spreads its lines by 1 / distance: no window mends that, and the bound
// says so.
TEST(Power, LeakBoundsWhatIsBesideABand) {
  const double rate = 50;
  const auto band = third_octave_bands().front();
  for (const Index n : {15'000, 14'711, 6'000, 2'213}) {
    VectorXd within;
    const VectorXd x = beside_a_band(rate, n, 0, within);
    const Psd power = power_of(x, rate);
    const double level = band_rms(power, band.lower_hz, band.upper_hz);
    const double exact = std::sqrt(within.squaredNorm() / static_cast<double>(n));
    const double leak = leak_in_band(power, band.lower_hz, band.upper_hz) +
                        jumps_in_band(power, band.lower_hz, band.upper_hz);
    // The estimate of a sum of lines: within twice of what is there.
    EXPECT_LT(level * level - exact * exact, 2 * leak * leak) << n;
    EXPECT_GT(4 * level * level, leak * leak) << n;
  }
  // Of white noise an edge is known to one or two bins.
  const Psd white = power_of(noise(50'000, 1, 4), 500);
  const double bins = std::pow(leak_in_band(white, 10, 20), 2) /
                      (std::pow(band_rms(white, 10, 20), 2) * white.resolution_hz / 10);
  EXPECT_GT(bins, 0.2);
  EXPECT_LT(bins, 2);
  // Nothing is said of an estimate with other windows.
  EXPECT_EQ(leak_in_band(welch(noise(5000, 1, 4), 500, 1000), 10, 20), 0);
}

TEST(BandRms, CountsCutBinsInPart) {
  // 1 unit^2/Hz at 0, 1, ..., 8 Hz.
  const Psd psd{.sample_rate_hz = 16, .resolution_hz = 1, .density = VectorXd::Ones(9)};
  EXPECT_DOUBLE_EQ(band_rms(psd, 2.5, 5.5), std::sqrt(3.0));
  EXPECT_DOUBLE_EQ(band_rms(psd, 2.75, 5.0), std::sqrt(2.25));
  EXPECT_DOUBLE_EQ(band_rms(psd, 3.1, 3.2), std::sqrt(3.2 - 3.1));
  EXPECT_DOUBLE_EQ(band_rms(psd, 20, 30), 0);
  // Neighbouring bands leave nothing out and count nothing twice.
  const double parts = std::pow(band_rms(psd, 0, 3.3), 2) + std::pow(band_rms(psd, 3.3, 8), 2);
  EXPECT_NEAR(parts, 9, 1e-14);
}

TEST(ThirdOctaves, BandsTouchAndCarryTheirNames) {
  const auto bands = third_octave_bands();
  ASSERT_EQ(bands.size(), 20u);
  for (std::size_t i = 0; i < bands.size(); ++i) {
    // IEC 61260-1 rounds names to within 1.5 % of the exact centres.
    EXPECT_NEAR(bands[i].nominal_hz / bands[i].centre_hz, 1, 0.015);
    EXPECT_NEAR(bands[i].lower_hz * bands[i].upper_hz, std::pow(bands[i].centre_hz, 2), 1e-9);
    const double below = i == 0 ? std::pow(10, -0.05) : bands[i - 1].upper_hz;
    EXPECT_NEAR(bands[i].lower_hz, below, 1e-12 * below);
  }
  EXPECT_NEAR(bands.back().centre_hz, 79.43282347, 1e-8);
  EXPECT_NEAR(bands.back().upper_hz, 89.12509381, 1e-8);
}

TEST(ThirdOctaves, SineGivesItsVelocityInOneBand) {
  const double rate = 1000, amplitude = 2e-3;
  const auto bands = third_octave_bands();
  for (const std::size_t i : {3u, 9u, 14u, 19u}) {
    const double f = bands[i].centre_hz;
    const VectorXd x = sine(64000, rate, f, amplitude);
    const VectorXd velocity = third_octave_velocity(welch(x, rate, 16000));
    const double expected = amplitude / (2 * pi * f) / std::sqrt(2.0);
    // Dividing at bin centres widens the Hann lobe of +-2 bins of 1/16 Hz: second order, (0.1 Hz /
    // f)^2.
    EXPECT_NEAR(velocity(static_cast<Index>(i)) / expected, 1,
                std::max(1e-4, 2 * std::pow(0.1 / f, 2)))
        << f;
    for (std::size_t other = 0; other < bands.size(); ++other) {
      // Side lobes of the Hann window fall with the cube of the distance, and grow as 1 / f
      // downwards.
      if (other == i) continue;
      EXPECT_LT(velocity(static_cast<Index>(other)), 0.02 * expected) << f;
    }
  }
}

TEST(ThirdOctaves, WhiteAccelerationHasAClosedForm) {
  // S_a = 1: the velocity in a band is sqrt((1/f_1 - 1/f_2) / (2 pi)^2).
  Psd psd{.sample_rate_hz = 1000, .resolution_hz = 1.0 / 64, .density = VectorXd::Ones(32001)};
  const VectorXd velocity = third_octave_velocity(psd);
  const auto bands = third_octave_bands();
  for (std::size_t i = 0; i < bands.size(); ++i) {
    const double exact = std::sqrt(1 / bands[i].lower_hz - 1 / bands[i].upper_hz) / (2 * pi);
    // The midpoint rule over bins, relative (df / f)^2 / 4 inside and (df / f)^2 at the cut edges.
    EXPECT_NEAR(velocity(static_cast<Index>(i)) / exact, 1,
                std::pow(psd.resolution_hz / bands[i].lower_hz, 2) * 2);
  }
}

TEST(ThirdOctaves, BandsBeyondHalfTheRateAreNotKnown) {
  // 50 Hz: the band of 40 Hz ends at 44.7 Hz, that of 50 Hz at 56.2.
  const VectorXd velocity = third_octave_velocity(power_of(noise(5000, 1, 2), 100));
  for (Index i = 0; i < 20; ++i) EXPECT_EQ(std::isnan(velocity(i)), i > 16) << i;
}

TEST(Velocity, PsdIsDividedByOmegaSquared) {
  const Psd psd{.sample_rate_hz = 8, .resolution_hz = 1, .density = VectorXd::Constant(5, 3)};
  const Psd velocity = velocity_from_acceleration(psd);
  EXPECT_EQ(velocity.density(0), 0);
  EXPECT_DOUBLE_EQ(velocity.density(2), 3 / (16 * pi * pi));
}

}  // namespace
}  // namespace stillframe::report

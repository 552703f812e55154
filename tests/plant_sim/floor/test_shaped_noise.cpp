#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <fstream>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <string>

#include "core/numerics/worst.hpp"
#include "plant_sim/floor/floor_block.hpp"
#include "plant_sim/floor/resample.hpp"
#include "plant_sim/floor/shaped_noise.hpp"
#include "report/spectra/spectra.hpp"
#include "report/spectra/vibration_criteria.hpp"

namespace stillframe::floor {
namespace {

std::unique_ptr<FloorSource> from(const std::string& text, double rate, Eigen::Index inputs) {
  return make_floor_source(
      read_floor_block(YamlReader::from_text(text, "floor.yaml"), rate, inputs));
}

/// Samples first to first + n - 1 of every channel.
Eigen::MatrixXd samples(const FloorSource& source, std::int64_t first, Eigen::Index n) {
  Eigen::MatrixXd w(source.channels(), n);
  for (Eigen::Index k = 0; k < n; ++k) source.sample(first + k, w.col(k));
  return w;
}

TEST(Density, EveryBandOfACriterionHasItsLevel) {
  for (const auto& criterion : report::vibration_criteria()) {
    const char letter = criterion.name.back();
    EXPECT_EQ(criterion_velocity(letter), criterion.velocity);
    for (const auto& band : report::third_octave_bands()) {
      if (!criterion.applies(band.centre_hz)) continue;
      double square = 0.0;
      const int n = 2000;
      for (int i = 0; i < n; ++i) {
        const double f = band.lower_hz + (i + 0.5) / n * (band.upper_hz - band.lower_hz);
        square += density_at(VibrationCriterionDensity{letter}, f) /
                  std::pow(2 * std::numbers::pi * f, 2) * (band.upper_hz - band.lower_hz) / n;
      }
      // A midpoint sum of a power of f: off by (width / n / f)^2 / 12 = 1e-9 or so of it.
      const double limit = criterion.limit(band.centre_hz);
      EXPECT_NEAR(std::sqrt(square), limit, 1e-7 * limit) << criterion.name << band.nominal_hz;
    }
    EXPECT_EQ(density_at(VibrationCriterionDensity{letter}, 0.8), 0.0);
    EXPECT_EQ(density_at(VibrationCriterionDensity{letter}, 90.0), 0.0);
  }
}

TEST(Density, PetersonsModelsAreThoseOfTheTable) {
  std::ifstream file(STILLFRAME_SOURCE_DIR "/config/floors/nlnm_nhnm_peterson.csv");
  int rows = 0;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with('#') || line.starts_with("model")) continue;
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream cells(line);
    std::string model;
    double period, a, b, at_period;
    cells >> model >> period >> a >> b >> at_period;
    ASSERT_TRUE(cells) << line;
    ++rows;
    const PetersonDensity density{model == "NHNM"};
    const double later = 1.001 * period;  // within the row
    EXPECT_NEAR(10 * std::log10(density_at(density, 1 / later)), a + b * std::log10(later), 1e-10);
    // The table gives two digits; at the row's own period, and the models are continuous to that.
    EXPECT_NEAR(10 * std::log10(density_at(density, 1 / later)), at_period,
                0.01 + 5e-4 * std::abs(b));
    if (period > 0.1) {
      EXPECT_NEAR(10 * std::log10(density_at(density, 1 / (0.9999999 * period))), at_period, 0.02);
    }
  }
  EXPECT_EQ(rows, 32);
  for (const bool high : {false, true}) {
    EXPECT_EQ(density_at(PetersonDensity{high}, 10.01), 0.0);
    EXPECT_EQ(density_at(PetersonDensity{high}, 0.9e-5), 0.0);
    EXPECT_GT(density_at(PetersonDensity{high}, 1.1e-5), 0.0);
  }
}

TEST(Density, PointsAreJoinedByStraightLinesInLogarithms) {
  const PointsDensity line{{{1.0, 1e-6}, {10.0, 1e-8}, {40.0, 4e-8}}};
  EXPECT_NEAR(density_at(line, std::sqrt(10.0)), 1e-7, 1e-20);
  EXPECT_NEAR(density_at(line, 20.0), 2e-8, 1e-21);
  EXPECT_EQ(density_at(line, 1.0), 1e-6);
  EXPECT_EQ(density_at(line, 40.0), 4e-8);
  EXPECT_EQ(density_at(line, 0.999), 0.0);
  EXPECT_EQ(density_at(line, 40.001), 0.0);
}

/// |X_b| of a row over a whole number of periods, as the amplitude of a cosine. A plain sum.
double line_amplitude(const Eigen::MatrixXd& x, Eigen::Index row, Eigen::Index b) {
  const Eigen::Index n = x.cols();
  std::complex<double> sum = 0.0;
  for (Eigen::Index k = 0; k < n; ++k) {
    sum += x(row, k) * std::polar(1.0, -2 * std::numbers::pi * static_cast<double>(b * k % n) /
                                           static_cast<double>(n));
  }
  return 2.0 * std::abs(sum) / static_cast<double>(n);
}

TEST(ShapedNoise, EveryLineOfAPeriodHasTheDensityAsked) {
  const double rate = 500.0;
  const auto source = from(
      "noise: {psd: [[0.1, 1e-7], [2, 1e-9], [200, 1e-6]], high_pass_hz: 0.3, period_s: 20, "
      "duration_s: 200}",
      rate, 2);
  const Eigen::Index n = 10000;  // 20 s, a product of 2 and 5 alone
  ASSERT_EQ(next_quick_length(n), n);
  const Eigen::MatrixXd w = samples(*source, 40000, n);  // far from the fades of 6.7 s
  const PointsDensity target{{{0.1, 1e-7}, {2.0, 1e-9}, {200.0, 1e-6}}};
  for (const Eigen::Index b : {3, 6, 20, 41, 400, 1234, 3999}) {
    const double f = static_cast<double>(b) / 20.0;
    const double density = density_at(target, f) / (1.0 + std::pow(0.3 / f, 8));
    for (const Eigen::Index row : {0, 1}) {
      // Positions of 1e-5 m round by 1e-21, accelerations by 4e-16 m/s^2: of lines of 2e-5 1e-10.
      const double expected = std::sqrt(2 * density / 20.0);
      EXPECT_NEAR(line_amplitude(w, row, b), expected, 1e-9 * expected) << f;
    }
  }
  EXPECT_LT(line_amplitude(w, 0, 4100), 1e-14);  // 205 Hz, above the last point
  // Repeats exactly in position, hence up to rounding in acceleration; the inputs are independent.
  EXPECT_LT(worst_of(samples(*source, 40000 + n, n) - w), 1e-14);
  // A correlation of two noises of bandwidth B over T scatters by 1 / sqrt(2 B T) = 0.018, B about
  // 80 Hz; five standard deviations.
  EXPECT_LT(std::abs(w.row(0).dot(w.row(1))), 0.09 * w.row(0).norm() * w.row(1).norm());
}

TEST(ShapedNoise, IsOfTheCriterionsClassInEveryBand) {
  const double rate = 400.0, period = 1000.0;
  const auto source = from("noise: {vc: D, duration_s: 1200, axes: [z]}", rate, 6);
  ASSERT_EQ(source->meaning(), FloorChannels::rigid);
  const auto n = static_cast<Eigen::Index>(period * rate);
  const Eigen::MatrixXd w = samples(*source, static_cast<std::int64_t>(100 * rate), n);
  const auto psd =
      report::welch(w.row(2).transpose(), rate, report::default_segment_length(n, rate));
  const Eigen::VectorXd velocity = report::third_octave_velocity(psd);
  const auto bands = report::third_octave_bands();
  for (std::size_t i = 0; i < bands.size(); ++i) {
    // The power of a band of width B over T scatters by 1 / sqrt(B T) for Gaussian noise (less
    // here, where the lines have no scatter), the rms by half of that: 3.3 % at 1 Hz, 0.4 % at 80
    // Hz. Four standard deviations. Welch's window of 16 s smears the steps of the target at 0.89
    // and 89 Hz over 0.1 Hz: 3 % of the width of the first band, 1 % of its rms.
    const double scatter = 0.5 / std::sqrt((bands[i].upper_hz - bands[i].lower_hz) * period);
    const double smear = bands[i].nominal_hz < 1.1 ? 0.05 : 0.0;
    EXPECT_NEAR(velocity(static_cast<Eigen::Index>(i)), 6.25e-6, 6.25e-6 * (4 * scatter + smear))
        << bands[i].nominal_hz;
  }
  EXPECT_TRUE(w.row(0).isZero(0));
}

TEST(ShapedNoise, PetersonsHighModelComesOut) {
  const double rate = 100.0;
  const auto source =
      from("noise: {peterson: high, axes: [x], duration_s: 4000, high_pass_hz: 0.01}", rate, 1);
  const Eigen::MatrixXd w = samples(*source, static_cast<std::int64_t>(1000 * rate), 200000);
  const auto psd = report::welch(w.row(0).transpose(), rate, 20000);
  for (const double f : {0.05, 0.2, 1.0, 5.0}) {
    // Over a tenth of the frequency around it the power scatters by 1 / sqrt(0.1 f 2000 s): 32 % at
    // 0.05 Hz for Gaussian noise; four of that, and the target is curved by 10 % within the band.
    double target = 0.0;
    const double lower = 0.95 * f, upper = 1.05 * f;
    for (int i = 0; i < 1000; ++i) {
      target += density_at(PetersonDensity{true}, lower + (i + 0.5) / 1000 * 0.1 * f) * 1e-4 * f;
    }
    const double ratio = std::pow(report::band_rms(psd, lower, upper), 2) / target;
    EXPECT_NEAR(ratio, 1.0, 4.0 / std::sqrt(0.1 * f * 2000) * 0.5 + 0.1) << f;
  }
}

TEST(ShapedNoise, SeedsDifferAndRepeat) {
  const std::string block = "noise: {vc: E, duration_s: 10, seed: ";
  const auto w = samples(*from(block + "3}", 1000, 1), 0, 10000);
  EXPECT_EQ(w, samples(*from(block + "3}", 1000, 1), 0, 10000));
  EXPECT_NE(w, samples(*from(block + "4}", 1000, 1), 0, 10000));
}

TEST(ShapedNoise, ShapesAreChecked) {
  EXPECT_THROW(periodic_noise({.density = PetersonDensity{}, .rate = 0, .period = 10}, {0}, true),
               std::invalid_argument);
  EXPECT_THROW(NoiseFloor(FloorChannels::inputs, Eigen::MatrixXd::Identity(1, 1),
                          Eigen::MatrixXd::Zero(10, 1), 1.0, 10, 6),
               std::invalid_argument);
}

}  // namespace
}  // namespace stillframe::floor

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <functional>
#include <iomanip>
#include <iostream>
#include <numbers>

#include "core/numerics/singular_values.hpp"
#include "core/numerics/worst.hpp"
#include "tests/plant_sim/loop_experiment.hpp"
#include "tests/plant_sim/random_settings.hpp"

// Fifty random loops of the metrology frame, good and bad ones: what core/control/sampled_loop.hpp
// predicts of them, and what the nonlinear plant does under the law, sample by sample. Rate,
// target, delay (whole and in parts), leak, high-pass, lead, roll-off, actuator gain and lag,
// sensor filter, kind and age of the reported force all vary at once.
namespace stillframe {
namespace {

/// Of any singular value, either way.
constexpr double largest_error_db = 0.2;

constexpr int settings_in_a_test = 2;

const test::RandomSettings& fifty() {
  static const test::RandomSettings drawn = test::fifty_settings();
  return drawn;
}

double decibel(double ratio) { return 20 * std::log10(ratio); }

/// By how much a prediction of T is off.
struct Error {
  double singular_values_db = 0, at_hz = 0;
  /// 1 + norm of T_predicted^-1 (T - T_predicted): no direction is off by more, nor, hence, any
  /// singular value.
  double directions_db = 0;
};

Error error_of(const SampledLoop& predicted, const std::vector<double>& frequencies_hz,
               const std::vector<Eigen::MatrixXcd>& T) {
  Error worst;
  for (std::size_t i = 0; i < T.size(); ++i) {
    const auto should = transfer(predicted, 2 * std::numbers::pi * frequencies_hz[i]);
    const Eigen::VectorXd ratios = singular_values(T[i]).cwiseQuotient(singular_values(should));
    const Eigen::MatrixXcd off = should.partialPivLu().solve(T[i] - should);
    const double db = worst_of(ratios.unaryExpr(&decibel));
    EXPECT_TRUE(std::isfinite(db));
    if (db > worst.singular_values_db) {
      worst.singular_values_db = db;
      worst.at_hz = frequencies_hz[i];
    }
    worst.directions_db = worst_of(worst.directions_db, decibel(1 + singular_values(off)(0)));
  }
  return worst;
}

void expect_measured_is_predicted(const test::RandomSetting& setting) {
  const MultisinePlan plan = test::experiment_of(setting);
  EXPECT_GE(plan.frequencies_hz.size(), 18U);
  const report::FrequencyResponse measured = test::measure(setting, plan);
  const Error error = error_of(setting.closed, measured.frequencies_hz, measured.T);
  std::cout << std::setprecision(4) << std::setw(9) << error.singular_values_db << " dB at "
            << std::setprecision(0) << std::setw(3) << error.at_hz << " Hz" << std::setprecision(4)
            << std::setw(9) << error.directions_db << " dB";
  EXPECT_LT(error.singular_values_db, largest_error_db);
  EXPECT_LT(error.directions_db, largest_error_db);
}

class RandomSettingsTest : public testing::TestWithParam<int> {};

TEST_P(RandomSettingsTest, PlantDoesWhatIsPredicted) {
  test::print_head(std::cout);
  for (int i = 0; i < settings_in_a_test; ++i) {
    const int number = GetParam() * settings_in_a_test + i;
    SCOPED_TRACE("setting " + std::to_string(number));
    const test::RandomSetting& setting = fifty().settings[static_cast<std::size_t>(number)];
    test::print(std::cout, setting);
    const test::Ringing ringing = test::ring(setting, test::ringing_samples(setting));
    std::cout << (ringing.stable() ? "  stable " : "  unstable ") << std::scientific
              << std::setprecision(2) << ringing.growth << " (" << std::log(setting.radius)
              << ") in" << std::setw(6) << ringing.samples << std::fixed;
    EXPECT_EQ(ringing.stable(), setting.predicted_stable());
    if (ringing.stable()) {
      expect_measured_is_predicted(setting);
    } else {
      // It grows at the rate of its worst mode as far as that has left the others behind in the
      // second half of a growth by a million; two that are close together still beat.
      EXPECT_NEAR(ringing.growth / std::log(setting.radius), 1, 0.1);
    }
    std::cout << std::endl;
  }
}

INSTANTIATE_TEST_SUITE_P(Pairs, RandomSettingsTest, testing::Range(0, 50 / settings_in_a_test));

TEST(RandomSettings, AreOfAllKinds) {
  int stable = 0;
  for (const test::RandomSetting& setting : fifty().settings) stable += setting.predicted_stable();
  std::cout << stable << " of " << fifty().settings.size() << " stable, of " << fifty().n_drawn
            << " drawn " << fifty().passed_over << " too near to a radius of one\n";
  EXPECT_EQ(fifty().settings.size(), 50U);
  EXPECT_EQ(stable, 22);
  // Hardly any verdict is evaded because it would take too long.
  EXPECT_LE(fifty().passed_over, fifty().n_drawn / 10);
}

/// A prediction that leaves something out.
struct Mistake {
  const char* name;
  std::function<bool(const Sampling&)> possible;
  std::function<void(Sampling&)> make;
};

/// True if the plant would prove a prediction wrong: other verdict, or T off by more than the plant
/// may be off from the right one and the wrong one together.
bool shows(const test::RandomSetting& setting, const SampledLoop& wrong) {
  const bool stable = spectral_radius(wrong) < largest_stable_radius;
  if (stable != setting.predicted_stable()) return true;
  if (!stable) return false;
  const std::vector<double> frequencies_hz = test::experiment_of(setting).frequencies_hz;
  std::vector<Eigen::MatrixXcd> right;
  for (const double f : frequencies_hz) {
    right.push_back(transfer(setting.closed, 2 * std::numbers::pi * f));
  }
  return error_of(wrong, frequencies_hz, right).singular_values_db > 2 * largest_error_db;
}

class MistakeTest : public testing::TestWithParam<Mistake> {};

TEST_P(MistakeTest, WouldShow) {
  int stable_ones = 0, shown = 0, unstable_ones = 0, other_verdicts = 0;
  for (const test::RandomSetting& setting : fifty().settings) {
    Sampling sampling = setting.gains.sampling();
    if (!GetParam().possible(sampling)) continue;
    GetParam().make(sampling);
    const bool differs = shows(setting, test::predict(setting, sampling));
    (setting.predicted_stable() ? stable_ones : unstable_ones) += 1;
    (setting.predicted_stable() ? shown : other_verdicts) += differs;
  }
  std::cout << GetParam().name << " shows in " << shown << " of " << stable_ones << " stable and "
            << other_verdicts << " of " << unstable_ones << " unstable settings\n";
  // One would do to make the test fail; where half of the settings show it, it is no accident.
  EXPECT_GE(2 * (shown + other_verdicts), stable_ones);
  EXPECT_GE(shown + other_verdicts, 2);
}

INSTANTIATE_TEST_SUITE_P(
    Mistakes, MistakeTest,
    testing::Values(
        Mistake{"fraction_of_delay",
                [](const Sampling& s) { return s.delay_samples != std::floor(s.delay_samples); },
                [](Sampling& s) { s.delay_samples = std::floor(s.delay_samples); }},
        Mistake{"whole_delay", [](const Sampling& s) { return s.delay_samples >= 1; },
                [](Sampling& s) { s.delay_samples -= 1; }},
        Mistake{"gain", [](const Sampling&) { return true; },
                [](Sampling& s) { s.instruments.actuator_gain = 1; }},
        Mistake{"lag", [](const Sampling& s) { return s.instruments.actuator_lag_hz > 0; },
                [](Sampling& s) { s.instruments.actuator_lag_hz = 0; }},
        Mistake{"sensor_filter",
                [](const Sampling& s) { return s.instruments.sensor_filter_hz > 0; },
                [](Sampling& s) { s.instruments.sensor_filter_hz = 0; }},
        Mistake{"kind_of_report",
                [](const Sampling& s) {
                  return s.instruments.actuator_lag_hz > 0 &&
                         s.instruments.report == Instruments::Report::commanded;
                },
                [](Sampling& s) { s.instruments.report = Instruments::Report::measured; }},
        Mistake{"age_of_report",
                [](const Sampling& s) { return s.instruments.report_age_samples > 0; },
                [](Sampling& s) { s.instruments.report_age_samples = 0; }}),
    [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace stillframe

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <random>
#include <stdexcept>

#include "report/identification/comparison.hpp"
#include "tests/report/expect_error.hpp"
#include "tests/report/toy_frame.hpp"

namespace stillframe::report {
namespace {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

double factor(double db) { return std::pow(10, db / 20); }

class Comparison : public ::testing::Test {
 protected:
  static constexpr double sample_time = 2.5e-4;
  toy::Frame frame_;
  SampledPlant plant_ = sample_and_hold(frame_.plant(), toy::sampled_at(sample_time));
  SampledLoop open_ = open_loop(plant_);
  SampledLoop closed_ =
      close_loop(plant_, frame_.law(2 * toy::pi * 5, 0.7, 2 * toy::pi * 0.05, sample_time));
  std::vector<double> frequencies_ = {1, 4, 12, 20, 29, 50, 100, 400};

  /// What a faultless measurement of a loop would give.
  FrequencyResponse exact(const SampledLoop& loop) const {
    FrequencyResponse response;
    response.frequencies_hz = frequencies_;
    for (const double f : frequencies_) response.T.push_back(transfer(loop, 2 * toy::pi * f));
    response.singular_values = singular_values(response.T);
    response.dof = VectorXd::Constant(response.n_frequencies(), 12);
    return response;
  }
  MatrixXd predicted(const SampledLoop& loop) const {
    return predicted_singular_values(loop, frequencies_);
  }
  /// Bands of so many dB to either side.
  static Bands bands(const FrequencyResponse& response, double db) {
    return {response.singular_values / factor(db), response.singular_values * factor(db)};
  }
  static PredictionError compared(const FrequencyResponse& measured, const MatrixXd& predicted) {
    return compare(measured, bands(measured, 0), predicted);
  }
};

TEST_F(Comparison, OpenLoopSingularValuesAreThoseOfTheModes) {
  // By hand: the mean acceleration of a mode under a held input, see closed_form in
  // test_identification.cpp.
  const MatrixXd predicted = predicted_singular_values(open_, frequencies_);
  for (std::size_t l = 0; l < frequencies_.size(); ++l) {
    const std::complex<double> z = std::polar(1.0, 2 * toy::pi * frequencies_[l] * sample_time);
    std::vector<double> expected;
    for (const double mode : frame_.modes_hz) {
      const double angle = 2 * toy::pi * mode * sample_time;
      expected.push_back(std::abs(1.0 - std::sin(angle) / angle * (z - 1.0) * (z - 1.0) /
                                            (z * z - 2.0 * std::cos(angle) * z + 1.0)));
    }
    std::sort(expected.rbegin(), expected.rend());
    for (Index i = 0; i < 3; ++i) {
      // The denominator of 0.01 loses four digits to cancellation on both ways.
      EXPECT_NEAR(predicted(static_cast<Index>(l), i) / expected[static_cast<std::size_t>(i)], 1,
                  1e-9);
    }
  }
}

// Of 24 values two are a tenth.
TEST_F(Comparison, BroadlyIsMoreThanAFewFrequencies) {
  FrequencyResponse measured = exact(closed_);
  const MatrixXd right = predicted(closed_);
  measured.singular_values(2, 0) *= factor(17.5);
  EXPECT_EQ(broadly_beyond_db(compared(measured, right)), 0);
  measured.singular_values(5, 1) *= factor(4);
  EXPECT_NEAR(broadly_beyond_db(compared(measured, right)), 4, 1e-9);
  // Fewer than ten: the largest. What is not compared does not count.
  measured.singular_values.bottomRows(6).setConstant(std::nan(""));
  EXPECT_EQ(compared(measured, right).n_compared, 6);
  measured.singular_values(0, 0) *= factor(-7);
  EXPECT_NEAR(broadly_beyond_db(compared(measured, right)), 7, 1e-9);
}

// Noise of the inputs is not shared among the values as chance is.
TEST_F(Comparison, WhatNoiseOfTheInputsMayTakeOffIsAllowedOnce) {
  FrequencyResponse measured = exact(closed_);
  Bands bands = Comparison::bands(measured, 0);
  bands.bias = (factor(0.5) - 1) * measured.singular_values;
  bands.lower -= bands.bias;
  bands.upper += bands.bias;
  const MatrixXd right = predicted(closed_);
  EXPECT_EQ(compare(measured, bands, right * factor(0.4)).beyond_db, 0);
  EXPECT_NEAR(compare(measured, bands, right * factor(0.9)).beyond_db, 0.4, 1e-9);
}

TEST_F(Comparison, FaultlessMeasurementDiffersByNothing) {
  const PredictionError error = compared(exact(closed_), predicted(closed_));
  EXPECT_EQ(error.largest_db, 0);
  EXPECT_EQ(error.beyond_db, 0);
  EXPECT_EQ(error.n_compared, 24);
  EXPECT_TRUE(error.agrees());
}

TEST_F(Comparison, FindsTheLargestDeviationAndItsSign) {
  FrequencyResponse measured = exact(open_);
  measured.singular_values(2, 1) *= factor(0.15);
  measured.singular_values(5, 2) *= factor(-0.31);
  const PredictionError error = compared(measured, predicted(open_));
  EXPECT_NEAR(error.largest_db, 0.31, 1e-12);
  EXPECT_EQ(error.at_frequency_hz, 50);
  EXPECT_NEAR(error.difference_db(2, 1), 0.15, 1e-12);
  EXPECT_NEAR(error.difference_db(5, 2), -0.31, 1e-12);
  EXPECT_NEAR(error.beyond_db, 0.31, 1e-12);
  EXPECT_EQ(error.beyond_at_hz, 50);
  EXPECT_FALSE(error.agrees());
}

TEST_F(Comparison, WhatLiesWithinItsBandAgrees) {
  FrequencyResponse measured = exact(open_);
  measured.singular_values(2, 1) *= factor(0.5);
  const PredictionError known = compare(measured, bands(measured, 0.6), predicted(open_));
  EXPECT_NEAR(known.largest_db, 0.5, 1e-12);
  EXPECT_EQ(known.beyond_db, 0);
  EXPECT_TRUE(known.agrees());
  // All 24 bands together: Student's quantile of 1 - 0.05 / 24 over that of 0.95.
  const PredictionError beyond = compare(measured, bands(measured, 0.25), predicted(open_));
  const double ratio = student_quantile(1 - 0.05 / 24, 24) / student_quantile(0.95, 24);
  const double wider = 1 - ratio * (1 - 1 / factor(0.25));
  EXPECT_NEAR(beyond.beyond_db, 0.5 + 20 * std::log10(wider), 1e-9);
  EXPECT_TRUE(beyond.agrees());
  // A tolerance is the user's.
  EXPECT_FALSE(
      compare(measured, bands(measured, 0.25), predicted(open_), {.tolerance_db = 0.05}).agrees());
}

TEST_F(Comparison, WideBandsAreNotCompared) {
  FrequencyResponse measured = exact(open_);
  measured.singular_values(7, 2) *= 10;
  Bands wide = bands(measured, 0);
  wide.upper(7, 2) *= factor(1.1);
  const PredictionError error = compare(measured, wide, predicted(open_));
  EXPECT_TRUE(std::isnan(error.difference_db(7, 2)));
  EXPECT_EQ(error.largest_db, 0);
  EXPECT_EQ(error.n_compared, 23);
  EXPECT_EQ(error.n_left_out, 1);
  EXPECT_NEAR(compare(measured, wide, predicted(open_), {.widest_db = 2}).largest_db, 20, 1e-12);
  wide.lower.setZero();
  const PredictionError none = compare(measured, wide, predicted(open_));
  EXPECT_EQ(none.n_compared, 0);
  EXPECT_FALSE(none.agrees());
}

TEST_F(Comparison, ValuesBeyondTheRankOfTheLoopAreNotCompared) {
  // Six outputs of three dofs: three singular values are zero, but for rounding, and a measurement
  // has distortion there.
  FrequencyResponse measured = exact(closed_);
  MatrixXcd six(6, 6);
  for (MatrixXcd& T : measured.T) {
    six << T, T, T, T;
    T = six;
  }
  measured.singular_values = singular_values(measured.T);
  const MatrixXd predicted = measured.singular_values;
  measured.singular_values.rightCols(3).setConstant(1e-4);
  const PredictionError error = compared(measured, predicted);
  EXPECT_EQ(error.n_compared, 24);
  EXPECT_TRUE(error.agrees());
}

TEST_F(Comparison, WhatIsNoNumberNeverAgrees) {
  const FrequencyResponse measured = exact(open_);
  MatrixXd wrong = predicted(open_);
  wrong(3, 1) = std::nan("");
  EXPECT_FALSE(compared(measured, wrong).agrees());
  EXPECT_TRUE(std::isinf(compared(measured, wrong).largest_db));
  FrequencyResponse nothing = measured;
  nothing.singular_values.setConstant(std::nan(""));
  EXPECT_FALSE(compared(nothing, predicted(open_)).agrees());
  EXPECT_EQ(compared(nothing, predicted(open_)).n_compared, 0);
  FrequencyResponse zero = measured;
  zero.singular_values(0, 0) = 0;
  EXPECT_FALSE(compared(zero, predicted(open_)).agrees());
}

TEST_F(Comparison, ReductionIsJudgedAboveTheLimitOnly) {
  const MatrixXd open_values = predicted(open_), closed_values = predicted(closed_);
  FrequencyResponse closed = exact(closed_);
  const PredictionError open = compared(exact(open_), open_values);
  closed.singular_values(1, 0) *= 100;
  const auto check = [&](double above_hz) {
    return check_reduction(frequencies_, open, compared(closed, closed_values), open_values,
                           closed_values, above_hz);
  };
  EXPECT_EQ(check(10).n_frequencies, 6);
  EXPECT_EQ(check(10).largest_error_db, 0);
  EXPECT_EQ(check(10).n_compared, 18);
  EXPECT_EQ(check(10).n_below, 6);
  EXPECT_EQ(check(10).n_unknown, 0);
  closed.singular_values(3, 1) *= factor(0.25);
  EXPECT_NEAR(check(10).largest_error_db, 0.25, 1e-12);
  EXPECT_EQ(check(10).at_frequency_hz, 20);
  // One pair of one frequency.
  closed.singular_values(4, 2) = 1.01 * open_values(4, 2);
  EXPECT_EQ(check(10).n_below, 5);
  EXPECT_NEAR(check(10).least_reduction_db, -20 * std::log10(1.01), 1e-12);
  EXPECT_EQ(check(1000).n_frequencies, 0);
}

// Noise above all values of the closed loop leaves its reduction unknown, not absent.
TEST_F(Comparison, AReductionThatNothingShowsIsCounted) {
  const MatrixXd open_values = predicted(open_), closed_values = predicted(closed_);
  FrequencyResponse closed = exact(closed_);
  closed.singular_values.bottomRows(7).setConstant(std::nan(""));
  const auto check = [&](const MatrixXd& predicted) {
    return check_reduction(frequencies_, compared(exact(open_), open_values),
                           compared(closed, closed_values), open_values, predicted, 10);
  };
  EXPECT_EQ(check(closed_values).n_frequencies, 0);
  EXPECT_EQ(check(closed_values).n_unknown, 6);
  EXPECT_EQ(check(2 * open_values).n_unknown, 0);  // predicted to be above
}

TEST_F(Comparison, RefusesWhatDoesNotBelongTogether) {
  FrequencyResponse open = exact(open_);
  open.singular_values.conservativeResize(Eigen::NoChange, 2);
  expect_error<std::invalid_argument>([&] { compared(open, predicted(open_)); },
                                      "the loop has 3 singular values");
  const PredictionError error = compared(exact(open_), predicted(open_));
  expect_error<std::invalid_argument>(
      [&] {
        check_reduction({1, 2}, error, error, predicted(open_), predicted(open_), 10);
      },
      "8 frequencies");
}

/// Frames with modes of their own, noise from little to as much as the motion: a true prediction
/// fails as often as all bands together say, one that is 0.5 dB off is found where noise is low.
TEST(ComparisonOfRandomLoops, TruePredictionsAgreeAndWrongOnesDoNot) {
  std::mt19937_64 random(31);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  const MultisinePlan plan = toy::plan();
  const MatrixXd w = toy::multisine(plan, 1e-3);
  constexpr int n = 200;
  int n_disagree = 0, n_found = 0, n_judged = 0;
  for (int run = 0; run < n; ++run) {
    toy::Frame frame;
    // Off the lines by 1 Hz, as the plan wants it.
    for (double& mode : frame.modes_hz) mode += 0.4 * (uniform(random) - 0.5);
    const SampledLoop loop =
        close_loop(sample_and_hold(frame.plant(), toy::sampled_at(1 / plan.sample_rate_hz, 1)),
                   frame.law(2 * toy::pi * (3 + 4 * uniform(random)), 0.5 + 0.4 * uniform(random),
                             2 * toy::pi * 0.05, 1 / plan.sample_rate_hz));
    auto record = toy::simulate(loop, w, VectorXd::Zero(loop.A.rows()));
    const double noise = 1e-3 * std::pow(10, -3 * uniform(random));
    for (double& value : record.outputs.reshaped()) value += noise * normal(random);
    const FrequencyResponse measured = identify(plan, record.inputs, record.outputs);
    const Bands bands = singular_value_bands(measured, 0.95, 400);
    const MatrixXd predicted = predicted_singular_values(loop, plan.frequencies_hz);
    const PredictionError right = compare(measured, bands, predicted, {.tolerance_db = 1e-3});
    if (right.n_compared == 0) continue;
    ++n_judged;
    if (!right.agrees()) ++n_disagree;
    if (!compare(measured, bands, factor(0.5) * predicted, {.tolerance_db = 1e-3}).agrees()) {
      ++n_found;
    }
  }
  std::cout << n_judged << " judged, true ones refused " << n_disagree << ", wrong ones found "
            << n_found << "\n";
  EXPECT_EQ(n_judged, n);  // noise is never as much as to leave no narrow band
  // All bands together hold with 95 %, so 10 of 200 are refused, and three standard deviations of
  // 3.1: of 1200 it were 54.
  EXPECT_LE(n_disagree, 19);
  // Of the 1200 two had no value whose band is within 0.5 dB.
  EXPECT_GE(n_found, n - 2);
}

}  // namespace
}  // namespace stillframe::report

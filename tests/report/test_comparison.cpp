#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "report/identification/comparison.hpp"
#include "tests/report/expect_error.hpp"
#include "tests/report/toy_frame.hpp"

namespace stillframe::report {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

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
    response.directional_coherence =
        MatrixXd::Ones(response.singular_values.rows(), response.singular_values.cols());
    return response;
  }
  MatrixXd predicted(const SampledLoop& loop) const {
    return predicted_singular_values(loop, frequencies_);
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

TEST_F(Comparison, FaultlessMeasurementDiffersByNothing) {
  const PredictionError error = compare(exact(closed_), predicted(closed_));
  EXPECT_EQ(error.largest_db, 0);
  EXPECT_GT(error.n_compared, 12);
}

TEST_F(Comparison, FindsTheLargestDeviationAndItsSign) {
  FrequencyResponse measured = exact(open_);
  measured.singular_values(2, 1) *= std::pow(10, 0.15 / 20);
  measured.singular_values(5, 2) *= std::pow(10, -0.31 / 20);
  const PredictionError error = compare(measured, predicted(open_));
  EXPECT_NEAR(error.largest_db, 0.31, 1e-12);
  EXPECT_EQ(error.at_frequency_hz, 50);
  EXPECT_NEAR(error.difference_db(2, 1), 0.15, 1e-12);
  EXPECT_NEAR(error.difference_db(5, 2), -0.31, 1e-12);
}

TEST_F(Comparison, IncoherentValuesAreLeftOut) {
  FrequencyResponse measured = exact(open_);
  measured.singular_values(7, 2) *= 10;
  measured.directional_coherence(7, 2) = 0.98;
  const PredictionError error = compare(measured, predicted(open_));
  EXPECT_TRUE(std::isnan(error.difference_db(7, 2)));
  EXPECT_EQ(error.largest_db, 0);
  EXPECT_EQ(error.n_compared, measured.singular_values.size() - 1);
  EXPECT_NEAR(compare(measured, predicted(open_), 0.97).largest_db, 20, 1e-12);
  measured.directional_coherence(7, 2) = std::nan("");
  EXPECT_EQ(compare(measured, predicted(open_)).n_compared, error.n_compared);
}

TEST_F(Comparison, MeasurementThatIsNotFiniteNeverPasses) {
  FrequencyResponse measured = exact(open_);
  measured.singular_values(0, 0) = 0;
  EXPECT_TRUE(std::isinf(compare(measured, predicted(open_)).largest_db));
}

TEST_F(Comparison, ReductionIsJudgedAboveTheLimitOnly) {
  FrequencyResponse open = exact(open_), closed = exact(closed_);
  closed.singular_values(1, 0) *= 100;
  ReductionCheck check = check_reduction(open, closed, predicted(open_), predicted(closed_), 10);
  EXPECT_EQ(check.n_frequencies, 6);
  EXPECT_EQ(check.largest_error_db, 0);
  EXPECT_EQ(check.n_compared, 18);
  closed.singular_values(3, 1) *= std::pow(10, 0.25 / 20);
  check = check_reduction(open, closed, predicted(open_), predicted(closed_), 10);
  EXPECT_NEAR(check.largest_error_db, 0.25, 1e-12);
  EXPECT_EQ(check.at_frequency_hz, 20);
}

TEST_F(Comparison, ClosedAboveOpenIsSeenAtOnePairOfOneFrequency) {
  const FrequencyResponse open = exact(open_);
  FrequencyResponse closed = exact(closed_);
  // At every frequency but the last the toy's loop isolates; there holding the force undoes it.
  EXPECT_EQ(check_reduction(open, closed, predicted(open_), predicted(closed_), 10).n_below, 6);
  EXPECT_TRUE(
      check_reduction(open, closed, predicted(open_), predicted(closed_), 10).closed_below_open());
  closed.singular_values(4, 2) = 1.01 * open.singular_values(4, 2);
  const ReductionCheck check =
      check_reduction(open, closed, predicted(open_), predicted(closed_), 10);
  EXPECT_EQ(check.n_below, 5);
  EXPECT_FALSE(check.closed_below_open());
  EXPECT_NEAR(check.least_reduction_db, -20 * std::log10(1.01), 1e-12);
  EXPECT_FALSE(check_reduction(open, closed, predicted(open_), predicted(closed_), 1000)
                   .closed_below_open());
}

TEST_F(Comparison, RefusesWhatDoesNotBelongTogether) {
  FrequencyResponse open = exact(open_);
  open.singular_values.conservativeResize(Eigen::NoChange, 2);
  expect_error<std::invalid_argument>([&] { compare(open, predicted(open_)); },
                                      "the loop has 3 singular values");
  FrequencyResponse closed = exact(closed_);
  closed.frequencies_hz[0] = 2;
  expect_error<std::invalid_argument>(
      [&] { check_reduction(exact(open_), closed, predicted(open_), predicted(closed_), 10); },
      "other frequencies");
}

}  // namespace
}  // namespace stillframe::report

#include "report/identification/comparison.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

namespace stillframe::report {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

void check_size(const FrequencyResponse& measured, const MatrixXd& predicted, const char* caller) {
  if (predicted.rows() != measured.singular_values.rows() ||
      predicted.cols() != measured.singular_values.cols()) {
    throw std::invalid_argument(std::string(caller) + ": the loop has " +
                                std::to_string(predicted.cols()) +
                                " singular values, the measured response " +
                                std::to_string(measured.singular_values.cols()));
  }
}

}  // namespace

MatrixXd decibels(const MatrixXd& values) { return 20 * values.array().log10(); }

MatrixXd predicted_singular_values(const SampledLoop& loop,
                                   const std::vector<double>& frequencies_hz) {
  std::vector<Eigen::MatrixXcd> T;
  T.reserve(frequencies_hz.size());
  for (const double frequency : frequencies_hz) {
    T.push_back(transfer(loop, 2 * std::numbers::pi * frequency));
  }
  return singular_values(T);
}

PredictionError compare(const FrequencyResponse& measured, const MatrixXd& predicted,
                        double least_coherence) {
  check_size(measured, predicted, "compare");
  PredictionError result;
  const MatrixXd predicted_db = decibels(predicted);
  result.difference_db = decibels(measured.singular_values) - predicted_db;
  for (Index l = 0; l < predicted_db.rows(); ++l) {
    for (Index i = 0; i < predicted_db.cols(); ++i) {
      double& difference = result.difference_db(l, i);
      if (!(measured.directional_coherence(l, i) > least_coherence)) {
        difference = std::numeric_limits<double>::quiet_NaN();
        continue;
      }
      ++result.n_compared;
      if (!(std::abs(difference) <= result.largest_db)) {
        result.largest_db = std::abs(difference);
        result.at_frequency_hz = measured.frequencies_hz[static_cast<std::size_t>(l)];
      }
    }
  }
  return result;
}

ReductionCheck check_reduction(const FrequencyResponse& open, const FrequencyResponse& closed,
                               const MatrixXd& open_predicted, const MatrixXd& closed_predicted,
                               double above_hz, double least_coherence) {
  if (open.frequencies_hz != closed.frequencies_hz) {
    throw std::invalid_argument(
        "check_reduction: open and closed loop were measured at other frequencies");
  }
  check_size(open, open_predicted, "check_reduction");
  check_size(closed, closed_predicted, "check_reduction");
  const MatrixXd open_db = decibels(open_predicted), closed_db = decibels(closed_predicted);
  if (open_db.cols() != closed_db.cols()) {
    throw std::invalid_argument("check_reduction: open and closed loop differ in size");
  }
  const MatrixXd measured = decibels(open.singular_values) - decibels(closed.singular_values);
  ReductionCheck check;
  check.least_reduction_db = std::numeric_limits<double>::infinity();
  for (Index l = 0; l < measured.rows(); ++l) {
    const double frequency = open.frequencies_hz[static_cast<std::size_t>(l)];
    if (!(frequency > above_hz)) continue;
    if ((open_db.row(l) - closed_db.row(l)).minCoeff() <= 0) continue;
    ++check.n_frequencies;
    const double least = measured.row(l).minCoeff();
    if (least > 0) ++check.n_below;
    check.least_reduction_db = std::min(check.least_reduction_db, least);
    for (Index i = 0; i < measured.cols(); ++i) {
      if (!(open.directional_coherence(l, i) > least_coherence) ||
          !(closed.directional_coherence(l, i) > least_coherence)) {
        continue;
      }
      ++check.n_compared;
      const double error = std::abs(measured(l, i) - (open_db(l, i) - closed_db(l, i)));
      if (!(error <= check.largest_error_db)) {
        check.largest_error_db = error;
        check.at_frequency_hz = frequency;
      }
    }
  }
  return check;
}

}  // namespace stillframe::report

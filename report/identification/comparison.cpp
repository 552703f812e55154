#include "report/identification/comparison.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>

#include "core/numerics/decibels.hpp"
#include "core/numerics/infinity.hpp"
#include "core/numerics/two_pi.hpp"

namespace stillframe::report {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

/// The level of the bands that are compared with, and of all of them together.
constexpr double confidence_level = 0.95;

/// How much wider the band of one of n values is if all n together are to hold with
/// `confidence_level`.
double joint_width(Index n, double dof) {
  const double each = 1 - (1 - confidence_level) / static_cast<double>(n);
  return student_quantile(each, 2 * dof) / student_quantile(confidence_level, 2 * dof);
}

bool is_narrow(double value, double lower, double upper, double widest_db) {
  const double factor = std::pow(10, widest_db / 20);
  return upper <= factor * value && value <= factor * lower;
}

/// How far a prediction lies outside a band, dB; infinite if it is not a number.
double beyond(double predicted, double lower, double upper) {
  if (lower <= predicted && predicted <= upper) return 0;
  const double distance =
      20 * std::max(std::log10(predicted / upper), std::log10(lower / predicted));
  return distance > 0 ? distance : infinity;
}

void check_size(const MatrixXd& predicted, Index rows, Index cols, const char* caller) {
  if (predicted.rows() == rows && predicted.cols() == cols) return;
  throw std::invalid_argument(
      std::string(caller) + ": the loop has " + std::to_string(predicted.cols()) +
      " singular values, the measured response " + std::to_string(cols) + ", at " +
      std::to_string(predicted.rows()) + " and " + std::to_string(rows) + " frequencies");
}

}  // namespace

MatrixXd predicted_singular_values(const SampledLoop& loop,
                                   const std::vector<double>& frequencies_hz) {
  std::vector<Eigen::MatrixXcd> T;
  T.reserve(frequencies_hz.size());
  for (const double frequency : frequencies_hz) {
    T.push_back(transfer(loop, two_pi * frequency));
  }
  return singular_values(T);
}

PredictionError compare(const FrequencyResponse& measured, const Bands& bands,
                        const MatrixXd& predicted, const ComparisonRule& rule) {
  const MatrixXd& values = measured.singular_values;
  check_size(predicted, values.rows(), values.cols(), "compare");
  PredictionError result;
  result.tolerance_db = rule.tolerance_db;
  result.difference_db.setConstant(values.rows(), values.cols(),
                                   std::numeric_limits<double>::quiet_NaN());
  result.beyond_each_db = result.difference_db;
  const auto is_compared = [&](Index l, Index i) {
    return is_narrow(values(l, i), bands.lower(l, i), bands.upper(l, i), rule.widest_db) &&
           !(predicted(l, i) <= rule.least_rank * predicted(l, 0));
  };
  for (Index l = 0; l < values.rows(); ++l) {
    for (Index i = 0; i < values.cols(); ++i)
      ++(is_compared(l, i) ? result.n_compared : result.n_left_out);
  }
  const auto raise = [](double value, double frequency, double& largest, double& at) {
    if (value <= largest) return;
    largest = std::isnan(value) ? infinity : value;
    at = frequency;
  };
  for (Index l = 0; l < values.rows(); ++l) {
    const double frequency = measured.frequencies_hz[static_cast<std::size_t>(l)];
    for (Index i = 0; i < values.cols(); ++i) {
      if (!is_compared(l, i)) continue;
      const double value = values(l, i), wider = joint_width(result.n_compared, measured.dof(l));
      const double difference = decibels(value / predicted(l, i));
      result.difference_db(l, i) = difference;
      raise(std::abs(difference), frequency, result.largest_db, result.at_frequency_hz);
      // Chance is shared among all values; what noise of the inputs takes off is in each alike.
      const double bias = bands.bias.size() > 0 ? bands.bias(l, i) : 0;
      const double below = value - bands.lower(l, i) - bias;
      const double above = bands.upper(l, i) - value - bias;
      const double lies_beyond =
          beyond(predicted(l, i), value - bias - wider * below, value + bias + wider * above);
      result.beyond_each_db(l, i) = lies_beyond;
      raise(lies_beyond, frequency, result.beyond_db, result.beyond_at_hz);
    }
  }
  return result;
}

double broadly_beyond_db(const PredictionError& error) {
  std::vector<double> beyond;
  for (const double value : error.beyond_each_db.reshaped()) {
    if (!std::isnan(value)) beyond.push_back(value);
  }
  if (beyond.empty()) return 0;
  // The n-th largest of 10 n: of fewer than ten the largest.
  const auto n = std::max<std::ptrdiff_t>(1, std::ssize(beyond) / 10);
  std::nth_element(beyond.begin(), beyond.begin() + (n - 1), beyond.end(), std::greater<>());
  return beyond[static_cast<std::size_t>(n - 1)];
}

ReductionCheck check_reduction(const std::vector<double>& frequencies_hz,
                               const PredictionError& open, const PredictionError& closed,
                               const MatrixXd& open_predicted, const MatrixXd& closed_predicted,
                               double above_hz) {
  const Index n_f = open.difference_db.rows(), n_s = open.difference_db.cols();
  for (const MatrixXd* other : {&closed.difference_db, &open_predicted, &closed_predicted}) {
    check_size(*other, n_f, n_s, "check_reduction");
  }
  if (static_cast<Index>(frequencies_hz.size()) != n_f) {
    throw std::invalid_argument("check_reduction: " + std::to_string(n_f) + " frequencies and " +
                                std::to_string(frequencies_hz.size()) + " names of them");
  }
  const MatrixXd error = open.difference_db - closed.difference_db;  // NaN: not both are compared
  const MatrixXd reduction = decibels(open_predicted) - decibels(closed_predicted);
  ReductionCheck check;
  check.least_reduction_db = infinity;
  const auto all_reduced = [&](Index l) {
    for (Index i = 0; i < n_s; ++i) {
      // Of a value that is zero but for rounding the ratio says nothing.
      if (open_predicted(l, i) <= ComparisonRule{}.least_rank * open_predicted(l, 0)) continue;
      if (!(reduction(l, i) > 0)) return false;
    }
    return n_s > 0;
  };
  for (Index l = 0; l < n_f; ++l) {
    const double frequency = frequencies_hz[static_cast<std::size_t>(l)];
    if (!(frequency > above_hz)) continue;
    Index n = 0;
    bool predicted = true;
    double least = infinity, largest_error = 0;
    for (Index i = 0; i < n_s; ++i) {
      if (std::isnan(error(l, i))) continue;
      ++n;
      predicted = predicted && reduction(l, i) > 0;
      least = std::min(least, reduction(l, i) + error(l, i));
      largest_error = std::max(largest_error, std::abs(error(l, i)));
    }
    if (n == 0 && all_reduced(l)) ++check.n_unknown;
    if (n == 0 || !predicted) continue;
    ++check.n_frequencies;
    check.n_compared += n;
    if (least > 0) ++check.n_below;
    check.least_reduction_db = std::min(check.least_reduction_db, least);
    if (!(largest_error <= check.largest_error_db)) {
      check.largest_error_db = largest_error;
      check.at_frequency_hz = frequency;
    }
  }
  return check;
}

}  // namespace stillframe::report

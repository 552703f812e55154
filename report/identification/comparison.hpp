#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/linear/sampled_loop.hpp"
#include "report/identification/identification.hpp"

namespace stillframe::report {

/// Below this level, dB, a singular value is not compared: noise and rounding of the run govern it.
inline constexpr double default_floor_db = -50;

/// 20 log10 of each value.
Eigen::MatrixXd decibels(const Eigen::MatrixXd& values);

/// sigma_i(T(e^{j 2 pi f T_s})) of a sampled loop, n_f x min(n_y, n_w), largest first; frequencies
/// in Hz.
Eigen::MatrixXd predicted_singular_values(const SampledLoop& loop,
                                          const std::vector<double>& frequencies_hz);

/// Measured against predicted singular values of one loop.
struct PredictionError {
  Eigen::MatrixXd predicted;      ///< n_f x n_s
  Eigen::MatrixXd difference_db;  ///< n_f x n_s, measured less predicted; NaN where predicted is
                                  ///< below the floor
  double largest_db = 0;          ///< largest |difference|
  double at_frequency_hz = 0;     ///< where it is
  Eigen::Index n_compared = 0;    ///< entries that are not NaN
};

/// Errors: std::invalid_argument if the response and the loop differ in size.
PredictionError compare(const FrequencyResponse& measured, const SampledLoop& loop,
                        double floor_db = default_floor_db);

/// Closed against open loop, at the frequencies above a limit.
struct ReductionCheck {
  Eigen::Index n_frequencies = 0;  ///< above the limit
  Eigen::Index n_below =
      0;  ///< of them, where every closed-loop singular value is below its open-loop one
  Eigen::Index n_compared = 0;  ///< pairs whose predicted values are both above the floor
  double largest_error_db = 0;  ///< |measured reduction - predicted reduction| over those pairs
  double at_frequency_hz = 0;   ///< where it is
  double least_reduction_db =
      0;  ///< smallest measured reduction of any pair, at any frequency above the limit

  bool closed_below_open() const { return n_frequencies > 0 && n_below == n_frequencies; }
};

/// The reduction sigma_i,open / sigma_i,closed, measured and predicted, for f > above_hz (2 omega_d
/// / 2 pi). Errors: std::invalid_argument if the frequencies or sizes differ.
ReductionCheck check_reduction(const FrequencyResponse& open, const FrequencyResponse& closed,
                               const SampledLoop& open_loop, const SampledLoop& closed_loop,
                               double above_hz, double floor_db = default_floor_db);

}  // namespace stillframe::report

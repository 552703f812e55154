#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/linear/sampled_loop.hpp"
#include "report/identification/multisine.hpp"

namespace stillframe::report {

/// A singular value is compared where its directional coherence is above this: elsewhere noise of
/// the run has a say in it.
inline constexpr double default_least_coherence = 0.99;

/// 20 log10 of each value.
Eigen::MatrixXd decibels(const Eigen::MatrixXd& values);

/// sigma_i(T(e^{j 2 pi f T_s})) of a sampled loop, n_f x min(n_y, n_w), largest first; frequencies
/// in Hz.
Eigen::MatrixXd predicted_singular_values(const SampledLoop& loop,
                                          const std::vector<double>& frequencies_hz);

/// Measured against predicted singular values of one loop.
struct PredictionError {
  Eigen::MatrixXd difference_db;  ///< n_f x n_s, measured less predicted; NaN where it is not
                                  ///< coherent
  double largest_db = 0;          ///< largest |difference|
  double at_frequency_hz = 0;     ///< where it is
  Eigen::Index n_compared = 0;    ///< entries that are not NaN
};

/// predicted: n_f x n_s, of the sampled or of the continuous loop. Errors: std::invalid_argument if
/// it is not.
PredictionError compare(const FrequencyResponse& measured, const Eigen::MatrixXd& predicted,
                        double least_coherence = default_least_coherence);

/// Closed against open loop, at the frequencies above a limit where every closed-loop singular
/// value is predicted to be below its open-loop one. (Near half the sample rate it is not.)
struct ReductionCheck {
  Eigen::Index n_frequencies = 0;  ///< of them
  Eigen::Index n_below = 0;        ///< of these, where that is so
  Eigen::Index n_compared = 0;     ///< pairs that are both coherent
  double largest_error_db = 0;     ///< |measured reduction - predicted reduction| over those pairs
  double at_frequency_hz = 0;      ///< where it is
  double least_reduction_db =
      0;  ///< smallest measured reduction of any pair, at any of the frequencies

  bool closed_below_open() const { return n_frequencies > 0 && n_below == n_frequencies; }
};

/// The reduction sigma_i,open / sigma_i,closed, measured and predicted, for f > above_hz (2 omega_d
/// / 2 pi). Errors: std::invalid_argument if the frequencies or sizes differ.
ReductionCheck check_reduction(const FrequencyResponse& open, const FrequencyResponse& closed,
                               const Eigen::MatrixXd& open_predicted,
                               const Eigen::MatrixXd& closed_predicted, double above_hz,
                               double least_coherence = default_least_coherence);

}  // namespace stillframe::report

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/systems/sampled_loop.hpp"
#include "report/identification/confidence.hpp"
#include "report/identification/multisine.hpp"

namespace stillframe::report {

/// What of a measured loop is compared with its prediction, and how: the one place that decides it.
/// A singular value is compared where its 95 % band is narrow, which says that noise of outputs and
/// inputs, the excitation at that frequency and the condition of the inputs leave it known, and
/// where the prediction has that rank. What lies within the bands agrees, all of them together at
/// 95 %; what lies beyond does so as far as the prediction itself is taken to be known.
struct ComparisonRule {
  /// dB, of how far beyond its band a value may lie: a linear model of constant parameters is not
  /// known better of a machine, and distortion of the runs of docs/identification.md stays below a
  /// tenth of it.
  double tolerance_db = 0.1;
  double widest_db = 1;  ///< a value whose band reaches further than this says little of a loop
  /// A predicted value below this share of the largest is zero, but for what solving with a matrix
  /// of condition 1 / share leaves of it: more outputs than dofs have such.
  double least_rank = 1e-8;
};

/// sigma_i(T(e^{j 2 pi f T_s})) of a sampled loop, n_f x min(n_y, n_w), largest first; frequencies
/// in Hz.
Eigen::MatrixXd predicted_singular_values(const SampledLoop& loop,
                                          const std::vector<double>& frequencies_hz);

/// Measured against predicted singular values of one loop.
struct PredictionError {
  Eigen::MatrixXd difference_db;   ///< n_f x n_s, measured less predicted; NaN: not compared
  Eigen::MatrixXd beyond_each_db;  ///< n_f x n_s, outside the value's band; NaN: not compared
  double largest_db = 0;           ///< largest |difference|
  double at_frequency_hz = 0;      ///< where it is
  double beyond_db = 0;            ///< furthest that a prediction lies outside the value's band
  double beyond_at_hz = 0;         ///< where it does
  double tolerance_db = 0;         ///< of the rule
  Eigen::Index n_compared = 0, n_left_out = 0;  ///< values

  /// Whether anything was compared and all of it agrees.
  bool agrees() const { return n_compared > 0 && beyond_db <= tolerance_db; }
};

/// predicted: n_f x n_s, of the sampled or of the continuous loop. bands: 95 %, of the measured
/// values. Errors: std::invalid_argument if sizes differ.
PredictionError compare(const FrequencyResponse& measured, const Bands& bands,
                        const Eigen::MatrixXd& predicted, const ComparisonRule& rule = {});

/// dB, so far outside its band or further lies a tenth of the values that are compared, at least
/// one: 0 for a prediction that is off at a few frequencies only.
double broadly_beyond_db(const PredictionError& error);

/// Closed against open loop, at the frequencies above a limit where every closed-loop singular
/// value that is compared is predicted to be below its open-loop one. (Near half the sample rate it
/// is not.)
struct ReductionCheck {
  Eigen::Index n_frequencies = 0;  ///< of them
  Eigen::Index n_below = 0;        ///< of these, where that is so
  /// Further ones of which no pair is compared, and the prediction is that it is so.
  Eigen::Index n_unknown = 0;
  Eigen::Index n_compared = 0;    ///< pairs of values that are both compared
  double largest_error_db = 0;    ///< |measured reduction - predicted reduction| over those pairs
  double at_frequency_hz = 0;     ///< where it is
  double least_reduction_db = 0;  ///< smallest measured reduction of those pairs
};

/// The reduction sigma_i,open / sigma_i,closed, measured and predicted, for f > above_hz (2 omega_d
/// / 2 pi). open, closed: both loops at these frequencies, compared with these predictions. Errors:
/// std::invalid_argument if the sizes differ.
ReductionCheck check_reduction(const std::vector<double>& frequencies_hz,
                               const PredictionError& open, const PredictionError& closed,
                               const Eigen::MatrixXd& open_predicted,
                               const Eigen::MatrixXd& closed_predicted, double above_hz);

}  // namespace stillframe::report

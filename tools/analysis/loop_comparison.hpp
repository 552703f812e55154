#pragma once

#include <optional>

#include "report/identification/comparison.hpp"
#include "tools/analysis/run_analysis.hpp"

namespace stillframe::tools {

/// What the issue of a measured loop has to meet: measured singular values within this of the exact
/// prediction, dB, wherever they are coherent.
inline constexpr double allowed_db = 0.1;

/// Measured singular values against both predictions.
struct PredictionErrors {
  Eigen::MatrixXd sampled_values, continuous_values;  ///< n_f x n_s, predicted
  report::PredictionError sampled, continuous;
};

/// Nothing without a measured and a predicted response of one size.
std::optional<PredictionErrors> prediction_errors(const JudgedResponse& response);

/// Closed against open loop where both matrices were measured at the same frequencies; above twice
/// the target. Nothing otherwise.
std::optional<report::ReductionCheck> reduction_check(const RunAnalyses& runs, double above_hz);

}  // namespace stillframe::tools

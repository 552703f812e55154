#include "tools/analysis/loop_comparison.hpp"

namespace stillframe::tools {

std::optional<PredictionErrors> prediction_errors(const JudgedResponse& response) {
  if (!response.measured.response || !response.predicted) return std::nullopt;
  const auto& measured = *response.measured.response;
  PredictionErrors errors;
  errors.sampled_values = report::singular_values(response.predicted->sampled);
  errors.continuous_values = report::singular_values(response.predicted->continuous);
  errors.sampled = report::compare(measured, errors.sampled_values);
  errors.continuous = report::compare(measured, errors.continuous_values);
  return errors;
}

std::optional<report::ReductionCheck> reduction_check(const RunAnalyses& runs, double above_hz) {
  if (!runs.passive || !runs.active || !runs.passive->matrix || !runs.active->matrix) return {};
  const JudgedResponse &open = *runs.passive->matrix, &closed = *runs.active->matrix;
  if (!open.measured.response || !closed.measured.response || !open.predicted ||
      !closed.predicted ||
      open.measured.response->frequencies_hz != closed.measured.response->frequencies_hz) {
    return std::nullopt;
  }
  return report::check_reduction(*open.measured.response, *closed.measured.response,
                                 report::singular_values(open.predicted->sampled),
                                 report::singular_values(closed.predicted->sampled), above_hz);
}

}  // namespace stillframe::tools

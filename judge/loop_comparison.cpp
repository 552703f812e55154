#include "judge/loop_comparison.hpp"

namespace stillframe::judge {

std::optional<report::ReductionCheck> reduction_check(const RunAnalyses& runs, double above_hz) {
  if (!runs.passive || !runs.active || !runs.passive->matrix || !runs.active->matrix) return {};
  const JudgedResponse &open = *runs.passive->matrix, &closed = *runs.active->matrix;
  if (!open.errors || !closed.errors ||
      open.measured.response->frequencies_hz != closed.measured.response->frequencies_hz) {
    return std::nullopt;
  }
  return report::check_reduction(open.measured.response->frequencies_hz, open.errors->sampled,
                                 closed.errors->sampled, open.errors->sampled_values,
                                 closed.errors->sampled_values, above_hz);
}

}  // namespace stillframe::judge

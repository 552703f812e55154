#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "judge/budget.hpp"

namespace stillframe::judge {

/// What a log holds of one axis of a budget, all samples of it.
struct MeasuredAxis {
  double rms = 0;            ///< m/s^2
  Eigen::VectorXd velocity;  ///< m/s rms in report::third_octave_bands()
  std::string vibration_class;
};

/// A run that a budget is held against.
struct BudgetRun {
  std::filesystem::path log;
  BudgetMethod method = BudgetMethod::passive;
  std::int64_t n_samples = 0;
  std::vector<MeasuredAxis> axes;
};

/// Reads a run of a design on a floor (the text of its block). Errors: as scan_log; InputError for
/// a run of another scene, floor or gains, one with samples missing, and one by the clock whose
/// loop took hold while it went on.
BudgetRun budget_run(const std::filesystem::path& log, const LoopDesign& design,
                     const std::string& floor_text, const std::vector<ComparedFrame>& axes);

/// One axis of a run beside what its budget has for it.
struct BudgetCheck {
  std::string axis;
  BudgetMethod method = BudgetMethod::passive;
  double predicted = 0, scatter = 0, measured = 0;  ///< m/s^2

  /// Measured over predicted, less 1.
  double difference() const { return measured / predicted - 1; }
  /// Within a part of what was measured, and twice the scatter of a run beside it.
  bool met(double within) const;
};

std::vector<BudgetCheck> checks_of(const Budget& budget, const std::vector<BudgetRun>& runs);

}  // namespace stillframe::judge

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "report/analysis/response_analyser.hpp"

namespace stillframe::report {

/// A direction in which what moves below is compared with what moves above, by names of
/// run_info_t.frame_names.
struct AxisPlan {
  std::string name, floor, frame;
};

/// What a response from the floors to the frames of axes is between. Axes may share a floor or a
/// frame; each is one input or output all the same: a motion that stood twice among the inputs
/// would be shared out between the two, and nothing would tell them apart.
struct AxisSignals {
  ResponseSignals signals;
  /// Axes x inputs: how the inputs move while the floor moves by one along the floor signal of an
  /// axis, and nowhere across it.
  Eigen::MatrixXd along = {};
  std::vector<Eigen::Index> output = {};  ///< of each axis
  /// Floors that are no inputs of their own, because their directions are combinations of those of
  /// inputs.
  std::vector<std::string> dependent_floors = {};
};

/// Every floor that an axis names is an input, every frame an output.
AxisSignals signals_by_name(const std::vector<AxisPlan>& axes);

}  // namespace stillframe::report

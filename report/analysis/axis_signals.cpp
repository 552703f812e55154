#include "report/analysis/axis_signals.hpp"

#include <algorithm>

namespace stillframe::report {

using Eigen::Index;

namespace {

/// The place of a name in a list, at whose end it is put if it is not there.
Index place_in(std::vector<std::string>& names, const std::string& name) {
  const auto found = std::find(names.begin(), names.end(), name);
  const Index place = found - names.begin();
  if (found == names.end()) names.push_back(name);
  return place;
}

}  // namespace

AxisSignals signals_by_name(const std::vector<AxisPlan>& axes) {
  AxisSignals result;
  std::vector<Index> input;
  for (const AxisPlan& axis : axes) {
    input.push_back(place_in(result.signals.inputs, axis.floor));
    result.output.push_back(place_in(result.signals.outputs, axis.frame));
  }
  result.along.setZero(std::ssize(axes), std::ssize(result.signals.inputs));
  for (std::size_t a = 0; a < axes.size(); ++a) result.along(static_cast<Index>(a), input[a]) = 1;
  return result;
}

}  // namespace stillframe::report

#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "report/log/log_scan.hpp"

namespace stillframe::report {

/// Signals of one kind in a log, the columns of one matrix of a SampleBlock.
struct SignalGroup {
  const char* name;      ///< "floor", "sigma", "applied", "frame", "command" or "excitation"
  const char* variable;  ///< of a .mat file
  const char* unit;
  Eigen::MatrixXd SampleBlock::*values;
  std::vector<std::string> stillframe_msgs::run_info_t::*names;
  bool unasked = true;  ///< it is exported where nothing is asked for
};

/// All kinds, in the order in which they are exported.
const std::array<SignalGroup, 6>& signal_groups();

/// One signal: a column of a group.
struct SignalColumn {
  const SignalGroup* group;
  Eigen::Index column;
  std::string name;  ///< as in the log
  std::string label() const { return std::string(group->name) + ":" + name; }
};

/// The signals of a run that are asked for by their label or by the name of their group, all but
/// excitations, which hardly any run has, if nothing is asked for, in the order of the groups.
/// Errors: InputError for one that is not in the log.
std::vector<SignalColumn> choose_columns(const stillframe_msgs::run_info_t& info,
                                         const std::vector<std::string>& asked_for);

}  // namespace stillframe::report

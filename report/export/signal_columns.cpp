#include "report/export/signal_columns.hpp"

#include "core/errors/input_error.hpp"
#include "core/yaml/reader.hpp"

namespace stillframe::report {

using stillframe_msgs::run_info_t;

const std::array<SignalGroup, 6>& signal_groups() {
  static const std::array<SignalGroup, 6> groups{{
      {"floor", "floor_acceleration", "m/s^2", &SampleBlock::floor_acceleration,
       &run_info_t::floor_names},
      {"sigma", "sigma", "N", &SampleBlock::sigma, &run_info_t::leg_names},
      {"applied", "applied_force", "N", &SampleBlock::applied_force, &run_info_t::leg_names},
      {"frame", "frame_acceleration", "m/s^2", &SampleBlock::frame_acceleration,
       &run_info_t::frame_names},
      {"command", "command_force", "N", &SampleBlock::command_force, &run_info_t::leg_names},
      {"excitation", "excitation", "N", &SampleBlock::excitation, &run_info_t::leg_names, false},
  }};
  return groups;
}

namespace {

std::vector<SignalColumn> all_columns(const run_info_t& info) {
  std::vector<SignalColumn> columns;
  for (const SignalGroup& group : signal_groups()) {
    const std::vector<std::string>& names = info.*group.names;
    for (std::size_t i = 0; i < names.size(); ++i) {
      columns.push_back({&group, static_cast<Eigen::Index>(i), names[i]});
    }
  }
  return columns;
}

[[noreturn]] void refuse(const std::string& word, const std::vector<SignalColumn>& columns) {
  std::vector<std::string> allowed;
  for (const SignalGroup& group : signal_groups()) allowed.emplace_back(group.name);
  for (const SignalColumn& column : columns) allowed.push_back(column.label());
  std::string text = "--channels: found '" + word + "'";
  const std::string near = nearest_name(word, allowed);
  if (!near.empty()) text += " (did you mean '" + near + "'?)";
  text += ", this log holds ";
  for (const std::string& name : allowed) text += (name == allowed.front() ? "" : ", ") + name;
  throw InputError(text);
}

}  // namespace

std::vector<SignalColumn> choose_columns(const run_info_t& info,
                                         const std::vector<std::string>& asked_for) {
  std::vector<SignalColumn> columns = all_columns(info);
  if (asked_for.empty()) {
    std::erase_if(columns, [](const SignalColumn& column) { return !column.group->unasked; });
    return columns;
  }
  std::vector<bool> chosen(columns.size(), false);
  for (const std::string& word : asked_for) {
    bool found = false;
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (word != columns[i].group->name && word != columns[i].label()) continue;
      chosen[i] = found = true;
    }
    if (!found) refuse(word, columns);
  }
  std::vector<SignalColumn> result;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (chosen[i]) result.push_back(columns[i]);
  }
  return result;
}

}  // namespace stillframe::report

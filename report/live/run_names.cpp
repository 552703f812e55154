#include "report/live/run_names.hpp"

#include <exception>

#include "core/yaml/reader.hpp"

namespace stillframe::live {

namespace {

// The scene was read whole before the run began, and may name files that are not here: only the
// one block that is needed is looked at.
std::vector<AxisNames> axes_of(const std::string& scene_text) {
  std::vector<AxisNames> axes;
  const auto compare = YamlReader::from_text(scene_text, "scene_text").find("compare");
  if (!compare) return axes;
  for (const auto& [name, value] : compare->entries()) {
    axes.push_back({name, value.require("floor").text(), value.require("frame").text()});
  }
  return axes;
}

std::optional<double> limit_of(const std::string& gains_text) {
  const auto limit = YamlReader::from_text(gains_text, "gains_text").find("force_limit_n");
  return limit ? std::optional(limit->positive()) : std::nullopt;
}

std::vector<std::string> numbered(const std::string& what, int n) {
  std::vector<std::string> names;
  for (int i = 1; i <= n; ++i) names.push_back(what + " " + std::to_string(i));
  return names;
}

}  // namespace

RunNames names_of(const stillframe_msgs::run_info_t& info) {
  RunNames names{.source = RunNames::Source::run_info,
                 .floor = info.floor_names,
                 .legs = info.leg_names,
                 .frame = info.frame_names,
                 .axes = {},
                 .force_limit_n = {},
                 .note = {}};
  try {
    if (!info.scene_text.empty()) names.axes = axes_of(info.scene_text);
    if (!info.gains_text.empty()) names.force_limit_n = limit_of(info.gains_text);
  } catch (const std::exception& error) {
    names.note = error.what();
  }
  return names;
}

RunNames numbered_names(int n_floor, int n_legs, int n_frame) {
  RunNames names;
  names.floor = numbered("floor", n_floor);
  names.legs = numbered("leg", n_legs);
  names.frame = numbered("frame", n_frame);
  return names;
}

}  // namespace stillframe::live

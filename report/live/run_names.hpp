#pragma once

#include <optional>
#include <string>
#include <vector>

#include "stillframe_msgs/run_info_t.hpp"

namespace stillframe::live {

/// What is compared with what: names of frame outputs.
struct AxisNames {
  std::string axis, floor, frame;
};

/// What the columns of the messages are called. Without a description of the run names are
/// numbers, and nothing is compared.
struct RunNames {
  enum class Source { run_info, scene, none };
  Source source = Source::none;
  std::vector<std::string> floor, legs, frame;
  std::vector<AxisNames> axes;
  std::optional<double> force_limit_n;  ///< N, of every leg
  std::string note;                     ///< what of the description could not be used; empty: all
};

/// The names in a run_info, the comparisons in its scene, the limit in its gains.
RunNames names_of(const stillframe_msgs::run_info_t& info);

/// Numbers for names: "floor 1", "leg 1", "frame 1", ...
RunNames numbered_names(int n_floor, int n_legs, int n_frame);

}  // namespace stillframe::live

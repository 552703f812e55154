#pragma once

#include <cstdint>
#include <string>

#include "core/mechanics/scene/scene.hpp"
#include "stillframe_msgs/run_info_t.hpp"

namespace stillframe {

/// What a run says of itself beside its scene.
struct RunDescription {
  std::int64_t run_id = 0, plant_instance = 0, n_samples = 0;
  std::string program_version, floor_text, gains_text;
  std::string mode, loop;  ///< lock_step, single_process or wall_clock; active or passive
};

/// The message that describes a run of a scene with a controller. Set-up.
stillframe_msgs::run_info_t describe_run(const Scene& scene, const RunDescription& run);

}  // namespace stillframe

#include "plant_sim/run_description.hpp"

namespace stillframe {

stillframe_msgs::run_info_t describe_run(const Scene& scene, const RunDescription& run) {
  stillframe_msgs::run_info_t info;
  info.run_id = run.run_id;
  info.plant_instance = run.plant_instance;
  info.format_version = 1;
  info.program_version = run.program_version;
  info.scene_name = scene.title;
  info.scene_hash = scene.hash;
  info.scene_text = text_with_full_paths(scene);
  info.floor_text = run.floor_text;
  info.gains_text = run.gains_text;
  info.mode = run.mode;
  info.loop = run.loop;
  info.sample_rate_hz = scene.controller->sample_rate_hz;
  info.delay_samples = scene.controller->delay_samples;
  info.n_samples = run.n_samples;
  for (const auto& signal : scene.inputs) info.floor_names.push_back(signal.name);
  for (const auto& leg : scene.controller->legs) info.leg_names.push_back(leg);
  for (const auto& signal : scene.outputs) info.frame_names.push_back(signal.name);
  for (const auto& signal : scene.monitors) info.frame_names.push_back(signal.name);
  info.n_floor = static_cast<std::int32_t>(info.floor_names.size());
  info.n_legs = static_cast<std::int32_t>(info.leg_names.size());
  info.n_frame = static_cast<std::int32_t>(info.frame_names.size());
  return info;
}

}  // namespace stillframe

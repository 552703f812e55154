#include "judge/aim.hpp"

#include <algorithm>

namespace stillframe::judge {

std::vector<double> aimed_hz(const SceneController& controller) {
  const auto& feed_forward = controller.feed_forward;
  if (feed_forward && feed_forward->target_hz) return {*feed_forward->target_hz};
  return controller.target_hz;
}

double lowest_aim_hz(const SceneController& controller) {
  const std::vector<double> all = aimed_hz(controller);
  return *std::min_element(all.begin(), all.end());
}

ControlLoop aim_of(const LoopDesign& design) {
  const auto& feed_forward = design.scene.controller->feed_forward;
  const bool has_targets = feed_forward && (feed_forward->target_hz || feed_forward->damping_ratio);
  return design.has_own_gains() && !has_targets ? design.loop : aim_of(design.scene, design.model);
}

ControlLoop aim_of(const Scene& scene, const Model& model) {
  Scene aims = scene;
  SceneController& block = *aims.controller;
  block.target_hz = aimed_hz(block);
  if (block.feed_forward && block.feed_forward->damping_ratio) {
    block.damping_ratio = {*block.feed_forward->damping_ratio};
  }
  block.roll_off_hz.reset();
  block.lead_samples = 0;
  return make_control_loop(aims, model);
}

}  // namespace stillframe::judge

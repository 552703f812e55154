#include "tests/fitting/small_frame.hpp"

#include <numeric>

#include "core/mechanics/scene/scene_reader.hpp"

namespace stillframe::fitting {

std::string small_frame_text() {
  return R"(title: A planar frame on three legs
planar: true
nodes:
  lens: {position: [0, 0]}
  left: {position: [-0.5, -0.1]}
  right: {position: [0.6, -0.1]}
  below_left: {position: [-0.5, -0.4]}
  below_right: {position: [0.6, -0.4]}
  beside: {position: [0.9, -0.1]}
masses:
  - {node: lens, mass: 300, inertia: 25}
elements:
  arm_left: {type: rigid_beam, nodes: [lens, left]}
  arm_right: {type: rigid_beam, nodes: [lens, right]}
  leg_l: {type: truss, nodes: [below_left, left], stiffness: 3e6, damping: 500}
  leg_r: {type: truss, nodes: [below_right, right], stiffness: 2.5e6, damping: 800}
  leg_s: {type: truss, nodes: [beside, right], stiffness: 2e6}
prescribed:
  - {nodes: [below_left, below_right, beside], move: [x, y]}
dofs:
  - {element: leg_l}
  - {element: leg_r}
  - {element: leg_s}
inputs:
  - {name: floor_l, acceleration: below_left, along: y}
  - {name: floor_r, acceleration: below_right, along: y}
  - {name: floor_s, acceleration: beside, along: x}
outputs:
  - {name: frame_l, acceleration: left, along: y}
  - {name: frame_r, acceleration: right, along: y}
  - {name: frame_s, acceleration: right, along: x}
controller:
  {legs: [leg_l, leg_r, leg_s], target_hz: 4, damping_ratio: 0.7, sample_rate_hz: 1000,
   delay_samples: 1, leak_hz: 0.1}
)";
}

SceneUncertainty everything_by(double part) {
  SceneUncertainty uncertainty;
  uncertainty.stiffness = uncertainty.damping = uncertainty.mass = uncertainty.inertia = part;
  uncertainty.centre_of_mass_m = 0.05 * part;
  uncertainty.leg_direction_rad = 0.2 * part;
  uncertainty.actuator_gain = uncertainty.sensor_gain = part / 4;
  uncertainty.delay_samples = 0.5;
  return uncertainty;
}

FitQuestion question_of(const Scene& scene, const SceneUncertainty& uncertainty) {
  FitQuestion question{.scene = scene,
                       .sampling = {},
                       .parameters = robustness::parameters_of(scene, uncertainty),
                       .frame = std::vector<Eigen::Index>(scene.outputs.size())};
  question.sampling.sample_time = 1 / scene.controller->sample_rate_hz;
  question.sampling.delay_samples = scene.controller->delay_samples;
  std::iota(question.frame.begin(), question.frame.end(), 0);
  return question;
}

FitQuestion small_frame_question() {
  return question_of(parse_scene(small_frame_text(), "small_frame"), everything_by(0.2));
}

}  // namespace stillframe::fitting

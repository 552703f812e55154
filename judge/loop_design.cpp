#include "judge/loop_design.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "controller/law.hpp"
#include "core/control/feed_forward_design.hpp"
#include "core/errors/input_error.hpp"
#include "core/mechanics/own_values.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "core/mechanics/state_space.hpp"
#include "judge/scene_design.hpp"

namespace stillframe::tools {

using Eigen::MatrixXd;

namespace {

/// The plant with a state that is zero where the frame has followed its floor, z - (R x, R v): of
/// a floor that moves as one only its acceleration is left, whatever the dofs are.
controller::PassivePlant passive_plant(const LoopPlant& plant) {
  const Index n = plant.A.rows() - plant.n_exogenous, p = plant.B_w.cols(), n_q = n / 2;
  controller::PassivePlant out{.A = plant.A.topLeftCorner(n, n),
                               .B = plant.B_u.topRows(n),
                               .C = plant.C_sigma.leftCols(n),
                               .B_w = plant.B_w.topRows(n)};
  if (plant.n_exogenous == 0) return out;
  out.A_w = plant.A.topRightCorner(n, 2 * p);
  out.C_w = plant.C_sigma.rightCols(2 * p);
  const MatrixXd stiffness = out.A.bottomLeftCorner(n_q, n_q);
  const MatrixXd R =
      -stiffness.completeOrthogonalDecomposition().solve(out.A_w.bottomRightCorner(n_q, p));
  MatrixXd follows = MatrixXd::Zero(n, 2 * p);
  follows.topRightCorner(n_q, p) = R;
  follows.bottomLeftCorner(n_q, p) = R;
  out.A_w += out.A * follows;
  out.A_w.topLeftCorner(n_q, p) -= R;
  out.C_w += out.C * follows;
  out.B_w.bottomRows(n_q) -= R;
  return out;
}

controller::Gains make_gains(const Scene& scene, const ControlLoop& loop, const LoopPlant& plant) {
  const SceneController& block = *scene.controller;
  return {.scene_hash = scene.hash,
          .legs = block.legs,
          .sample_rate_hz = block.sample_rate_hz,
          .delay_samples = block.delay_samples,
          .target_hz = block.target_hz,
          .realisation = block.realisation,
          .leak_hz = block.leak_hz,
          .high_pass_hz = block.high_pass_hz,
          .lead_samples = block.lead_samples,
          .roll_off_hz = block.roll_off_hz,
          .force_limit_n = block.force_limit_n,
          .K_P = loop.gains.K_P,
          .K_I = loop.gains.K_I,
          .instruments = scene.instruments,
          .plant = passive_plant(plant)};
}

std::vector<std::string> names_of(const std::vector<SceneSignal>& signals) {
  std::vector<std::string> names;
  for (const SceneSignal& signal : signals) names.push_back(signal.name);
  return names;
}

/// The feed-forward of a scene's controller block on a loop, aiming at what the continuous law of
/// that does; empty where none is asked for, or the feedback is not stable: then nothing is held.
controller::FloorFeedForward make_feed_forward(const Scene& scene, const ControlLoop& loop,
                                               LoopSettings settings) {
  const auto& block = scene.controller->feed_forward;
  settings.plant = loop_plant(loop.plant, loop.n_w, loop.n_y);
  // An error of calibration is what the design does not know.
  settings.sampling.instruments.actuator_gain = 1;
  if (!block || !(spectral_radius(settings) < largest_stable_radius)) return {};
  controller::FloorFeedForward made;
  made.floor = names_of(scene.inputs);
  made.filter = design_feed_forward(settings,
                                    [&](double omega) {
                                      return loop.closed({0, omega});
                                    },
                                    {.to_hz = block->to_hz,
                                     .corner_hz = block->corner_hz,
                                     .at_most = std::pow(10, block->at_most_db / 20),
                                     .actuator_error = block->actuator_error,
                                     .noise_over_floor = block->noise_over_floor,
                                     .n_taps = block->taps});
  return made;
}

/// Replaces the design by that of another model with the controller block of this one. The loop of
/// that model.
ControlLoop take_design_of(const std::filesystem::path& file, LoopDesign& design) {
  Scene scene = read_scene(file, std::nullopt);
  for (const std::string& leg : design.scene.controller->legs) {
    const bool there = std::any_of(
        scene.elements.begin(), scene.elements.end(),
        [&](const SceneElement& element) { return element.name == leg && !element.zero.front(); });
    if (!there) {
      throw InputError(file.string() + ": elements: has no elastic element '" + leg +
                       "', a leg of " + design.scene.file);
    }
  }
  scene.controller = design.scene.controller;
  if (scene.controller->feed_forward && names_of(scene.inputs) != names_of(design.scene.inputs)) {
    throw InputError(file.string() + ": inputs: a feed-forward of its model needs the inputs of " +
                     design.scene.file + ", by the same names and in the same order");
  }
  ControlLoop other = make_control_loop(scene, make_model(scene));
  design.loop.design = other.design;
  design.loop.gains = other.gains;
  return other;
}

}  // namespace

void sample(LoopDesign& design) {
  const LoopPlant plant = loop_plant(design.loop.plant, design.loop.n_w, design.loop.n_y);
  design.settings = {.plant = plant,
                     .feedback = design.gains.feedback(),
                     .law = design.gains.law_sampling(),
                     .sampling = design.gains.sampling(),
                     .feed_forward = design.gains.feed_forward.filter};
  design.loop.gains = continuous_law(design.settings);
  design.sampled = sample_and_hold(plant, design.gains.sampling());
  design.open = open_loop(design.sampled);
  design.closed = close_loop(design.sampled, controller::law_from_gains(design.gains));
  design.radius = spectral_radius(design.closed);
}

FrequencyRange axis_of(const LoopDesign& design, const std::vector<double>& targets_hz) {
  return frequency_range(own_frequencies_hz(design.loop.plant), targets_hz,
                         design.gains.sample_rate_hz);
}

namespace {

LoopDesign designed(Scene scene, const std::optional<std::filesystem::path>& design_scene) {
  LoopDesign design;
  design.scene = std::move(scene);
  design.model = make_model(design.scene);
  design.loop = make_control_loop(design.scene, design.model);
  std::optional<ControlLoop> other;
  if (design_scene) other = take_design_of(*design_scene, design);
  const LoopPlant plant = loop_plant(design.loop.plant, design.loop.n_w, design.loop.n_y);
  design.gains = make_gains(design.scene, design.loop, plant);
  sample(design);
  if (!design.scene.controller->feed_forward) return design;
  design.gains.feed_forward =
      make_feed_forward(design.scene, other ? *other : design.loop, design.settings);
  sample(design);
  return design;
}

}  // namespace

LoopDesign make_loop_design(Scene scene) { return designed(std::move(scene), std::nullopt); }

LoopDesign make_loop_design(const std::filesystem::path& scene_file,
                            const std::optional<std::filesystem::path>& controller_file,
                            const std::optional<std::filesystem::path>& design_scene) {
  return designed(read_scene(scene_file, controller_file), design_scene);
}

}  // namespace stillframe::tools

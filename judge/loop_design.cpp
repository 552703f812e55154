#include "judge/loop_design.hpp"

#include <Eigen/QR>
#include <algorithm>

#include "controller/law.hpp"
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

/// Replaces the design by that of another model with the controller block of this one.
void take_design_of(const std::filesystem::path& file, LoopDesign& design) {
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
  const ControlLoop other = make_control_loop(scene, make_model(scene));
  design.loop.design = other.design;
  design.loop.gains = other.gains;
}

}  // namespace

void sample(LoopDesign& design) {
  const LoopPlant plant = loop_plant(design.loop.plant, design.loop.n_w, design.loop.n_y);
  design.settings = {.plant = plant,
                     .feedback = design.gains.feedback(),
                     .law = design.gains.law_sampling(),
                     .sampling = design.gains.sampling()};
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
  if (design_scene) take_design_of(*design_scene, design);
  const LoopPlant plant = loop_plant(design.loop.plant, design.loop.n_w, design.loop.n_y);
  design.gains = make_gains(design.scene, design.loop, plant);
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

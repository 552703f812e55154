#include "judge/loop_design.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "controller/law.hpp"
#include "core/control/feed_forward_design.hpp"
#include "core/errors/input_error.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/mechanics/own_values.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "core/mechanics/state_space.hpp"
#include "judge/aim.hpp"
#include "judge/law_file.hpp"
#include "judge/scene_design.hpp"

namespace stillframe::judge {

using Eigen::MatrixXd;

namespace {

/// Of sample rates that are meant to be one.
constexpr double same_rate = 1e-9;

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

std::vector<std::string> names_of(const std::vector<SceneSignal>& signals) {
  std::vector<std::string> names;
  for (const SceneSignal& signal : signals) names.push_back(signal.name);
  return names;
}

/// A law of A, B, C, D has all filters of its feedback in it.
void check_alone(const SceneController& block) {
  const auto refuse = [&](bool given, const char* key) {
    if (!given) return;
    throw InputError(block.place + ": " + key + ": is given beside the law of " + block.law->file +
                     ", which is A, B, C and D and has all of its filters in it; take it out");
  };
  refuse(block.realisation != Realisation::implicit_feedthrough, "realisation");
  refuse(block.leak_hz > 0, "leak_hz");
  refuse(block.high_pass_hz > 0, "high_pass_hz");
  refuse(block.lead_samples > 0, "lead_samples");
  refuse(block.roll_off_hz.has_value(), "roll_off_hz");
}

/// Puts the law of the controller block into gains that have been made without it.
void take_own_law(const Scene& scene, controller::Gains& gains) {
  const SceneController& block = *scene.controller;
  const LawFile file = read_law_file(block.law->file, block.law->bytes);
  const auto fail = [&](const std::string& what) {
    throw InputError(block.law->file + ": " + what);
  };
  // A sample time that was written in decimals is not its rate to the bit.
  if (file.sample_rate_hz &&
      std::abs(*file.sample_rate_hz / block.sample_rate_hz - 1) > same_rate) {
    fail("sample_rate_hz: found " + shortest_digits(*file.sample_rate_hz) +
         ", allowed is that of the controller block, " + shortest_digits(block.sample_rate_hz));
  }
  if (!file.law) {
    const Index m = gains.n_legs();
    if (file.K_P.rows() != m || file.K_P.cols() != m || file.K_I.rows() != m ||
        file.K_I.cols() != m) {
      fail("K_P, K_I: found " + std::to_string(file.K_P.rows()) + " x " +
           std::to_string(file.K_P.cols()) + " and " + std::to_string(file.K_I.rows()) + " x " +
           std::to_string(file.K_I.cols()) + ", allowed is a row and a column for each of the " +
           std::to_string(m) + " legs");
    }
    gains.K_P = file.K_P;
    gains.K_I = file.K_I;
    return;
  }
  check_alone(block);
  controller::BroughtLaw law{.matrices = *file.law};
  const std::vector<std::string> floor = names_of(scene.inputs);
  if (hears_floor(law.matrices)) {
    if (block.feed_forward) {
      throw InputError(block.place + ": feed_forward: is given beside the law of " +
                       block.law->file + ", which hears the floor itself; take it out");
    }
    law.floor = floor;
  }
  try {
    own_law(law.matrices, gains.legs, floor);
  } catch (const InputError& error) {
    fail(error.what());
  }
  gains.law = std::move(law);
  if (most_loop_states(gains) > controller::largest_loop) {
    fail("A: found " + std::to_string(file.law->A.rows()) + " states, which make a loop of " +
         std::to_string(most_loop_states(gains)) + "; allowed are up to " +
         std::to_string(controller::largest_loop));
  }
}

controller::Gains make_gains(const Scene& scene, const ControlLoop& loop, const LoopPlant& plant) {
  const SceneController& block = *scene.controller;
  return {.scene_hash = scene.hash,
          .legs = block.legs,
          .sample_rate_hz = block.sample_rate_hz,
          .delay_samples = block.delay_samples,
          .target_hz = aimed_hz(block),
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

/// The feed-forward of a scene's controller block on the plant of `aim`, aiming at what the
/// continuous law of that does; empty where none is asked for, or the feedback is not stable: then
/// nothing is held.
controller::FloorFeedForward make_feed_forward(const Scene& scene, const ControlLoop& aim,
                                               LoopSettings settings) {
  const auto& block = scene.controller->feed_forward;
  settings.plant = loop_plant(aim.plant, aim.n_w, aim.n_y);
  // An error of calibration is what the design does not know.
  settings.sampling.instruments.actuator_gain = 1;
  if (!block || !(spectral_radius(settings) < largest_stable_radius)) return {};
  controller::FloorFeedForward made;
  made.floor = names_of(scene.inputs);
  made.filter = design_feed_forward(settings,
                                    [&](double omega) {
                                      return aim.closed({0, omega});
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
/// that model, or what its feed-forward aims at.
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
  const Model model = model_of(scene);
  const ControlLoop other = make_control_loop(scene, model);
  design.loop.design = other.design;
  design.loop.gains = other.gains;
  return scene.controller->feed_forward ? aim_of(scene, model) : other;
}

}  // namespace

void sample(LoopDesign& design) {
  const LoopPlant plant = loop_plant(design.loop.plant, design.loop.n_w, design.loop.n_y);
  design.settings = {.plant = plant,
                     .feedback = design.gains.feedback(),
                     .law = design.gains.law_sampling(),
                     .sampling = design.gains.sampling(),
                     .feed_forward = design.gains.feed_forward.filter};
  if (design.gains.law) design.settings.own = controller::law_from_gains(design.gains);
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
  design.model = model_of(design.scene);
  design.loop = make_control_loop(design.scene, design.model);
  std::optional<ControlLoop> other;
  if (design_scene && design.scene.controller->law) {
    throw InputError(design.scene.controller->place +
                     ": law: brings its own matrices, so that those of the design scene would be "
                     "of no use; take out one of the two");
  }
  if (design_scene) other = take_design_of(*design_scene, design);
  const LoopPlant plant = loop_plant(design.loop.plant, design.loop.n_w, design.loop.n_y);
  design.gains = make_gains(design.scene, design.loop, plant);
  if (design.scene.controller->law) take_own_law(design.scene, design.gains);
  sample(design);
  if (!design.scene.controller->feed_forward) return design;
  design.gains.feed_forward =
      make_feed_forward(design.scene, other ? *other : aim_of(design), design.settings);
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

}  // namespace stillframe::judge

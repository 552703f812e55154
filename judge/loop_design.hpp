#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "controller/gains.hpp"
#include "core/control/design/control_loop.hpp"
#include "core/control/loop_settings.hpp"
#include "core/mechanics/model/model.hpp"
#include "core/mechanics/scene/scene.hpp"
#include "core/systems/frequency_range.hpp"

namespace stillframe::judge {

/// Everything that follows from a scene and its controller block before anything runs.
struct LoopDesign {
  Scene scene;
  Model model;
  ControlLoop loop;
  controller::Gains gains;
  LoopSettings settings;  ///< the loop as margins and rates are found with
  SampledPlant sampled;   ///< the plant with held inputs
  SampledLoop open, closed;
  double radius = 0;  ///< spectral radius of closed

  /// Whether a law of one's own, A, B, C and D, runs; loop.gains is then what it is held against.
  bool runs_own_law() const { return gains.law.has_value(); }
  /// Whether K_P and K_I are numbers of a file and not designed.
  bool has_own_gains() const { return scene.controller->law && !gains.law; }
};

/// With a design scene the gains are those of its model, of the same legs and with the same
/// controller block, and everything else is that of `scene`: what gains of a simpler model do on
/// this plant. Errors: InputError and Refusal of the steps, InputError if the legs are not the
/// same; an unstable loop is not refused here.
LoopDesign make_loop_design(const std::filesystem::path& scene,
                            const std::optional<std::filesystem::path>& controller,
                            const std::optional<std::filesystem::path>& design_scene = {});

/// Fills settings, sampled, open, closed and radius of a design from its loop and gains. Errors: as
/// loop_plant, sample_and_hold and law_from_gains.
void sample(LoopDesign& design);

/// The axis of frequency of a loop: that of its plant, of what its gains aim at and of its rate.
FrequencyRange axis_of(const LoopDesign& design, const std::vector<double>& targets_hz);

}  // namespace stillframe::judge

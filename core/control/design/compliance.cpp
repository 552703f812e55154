#include "core/control/design/compliance.hpp"

#include "core/control/design/control_loop.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/mechanics/state_space.hpp"

namespace stillframe {

namespace {

std::vector<SceneSignal> at_outputs(const Scene& scene, Quantity quantity) {
  std::vector<SceneSignal> signals = scene.outputs;
  for (SceneSignal& signal : signals) signal.quantity = quantity;
  const auto legs = leg_signals(*scene.controller);
  signals.insert(signals.end(), legs.begin(), legs.end());
  return signals;
}

}  // namespace

LoopPlant compliance_plant(const Scene& scene, const Model& model) {
  require_loop_signals(scene);
  const auto n = static_cast<Index>(scene.outputs.size());
  return loop_plant(linearise(scene, model, at_outputs(scene, Quantity::force),
                              at_outputs(scene, Quantity::position)),
                    n, n);
}

}  // namespace stillframe

#include "core/compliance.hpp"

#include "core/control_loop.hpp"
#include "core/frequency_response.hpp"
#include "core/operating_point.hpp"

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

Compliance::Compliance(const Scene& scene, const Model& model)
    : n_(static_cast<Index>(scene.outputs.size())) {
  require_loop_signals(scene);
  model_ = linearise(model, at_outputs(scene, Quantity::force),
                     at_outputs(scene, Quantity::position));
}

Eigen::MatrixXcd Compliance::open(std::complex<double> s) const {
  return transfer_function(model_, s).topLeftCorner(n_, n_);
}

Eigen::MatrixXcd Compliance::closed(std::complex<double> s, const ForceFeedback& feedback) const {
  return closed_loop(transfer_function(model_, s), n_, n_, feedback(s));
}

}  // namespace stillframe

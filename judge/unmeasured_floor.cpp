#include "judge/unmeasured_floor.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "core/mechanics/model/model.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/numerics/decibels.hpp"
#include "core/numerics/singular_values.hpp"
#include "judge/directions.hpp"
#include "judge/response_prediction.hpp"

namespace stillframe::judge {

using Eigen::Index;

namespace {

/// Translations of floor nodes that no input tells of, as inputs.
std::vector<SceneSignal> unmeasured(const Scene& scene, const report::ResponseSignals& signals,
                                    bool inputs_are_floors) {
  std::vector<Eigen::Vector3d> floors;
  if (inputs_are_floors) {
    for (const std::string& name : signals.inputs) add_to(floors, signal_of(scene, name).direction);
  }
  std::vector<SceneSignal> result;
  for (SceneSignal& signal : prescribed_translations(scene)) {
    std::vector<Eigen::Vector3d> known = floors;
    for (const SceneSignal& input : scene.inputs) {
      if (inputs_are_floors || input.node != signal.node) continue;
      if (input.quantity == Quantity::acceleration) add_to(known, input.direction);
    }
    for (const SceneSignal& before : result) {
      if (before.node == signal.node) add_to(known, before.direction);
    }
    signal.direction = across(signal.direction, known);
    if (!signal.direction.isZero(0)) result.push_back(signal);
  }
  return result;
}

/// Largest singular value of T from unmeasured directions to outputs, one a frequency.
std::vector<double> sizes(const LoopDesign& design, const std::vector<SceneSignal>& inputs,
                          const JudgedResponse& response, bool active) {
  LoopDesign other;
  other.scene = design.scene;
  other.scene.inputs = inputs;
  other.model = model_of(other.scene);
  other.loop = design.loop;
  other.gains = design.gains;
  other.gains.forget_floor();  // which hears what is measured alone
  report::ResponseSignals signals{{}, response.measured.signals.outputs};
  for (const SceneSignal& input : inputs) signals.inputs.push_back(input.name);
  std::vector<double> result;
  const auto prediction =
      ResponsePrediction(other, signals).at(response.measured.response->frequencies_hz, active);
  for (const Eigen::MatrixXcd& T : prediction.sampled) {
    result.push_back(T.size() > 0 ? singular_values(T)(0) : 0);
  }
  return result;
}

struct Shifts {
  double largest_db = 0, broadly_db = 0;
};

Shifts shifts_of(const std::vector<double>& sizes, const PredictionErrors& errors) {
  std::vector<double> shifts;
  const Eigen::MatrixXd& values = errors.sampled_values;
  for (Index l = 0; l < values.rows(); ++l) {
    for (Index k = 0; k < values.cols(); ++k) {
      if (std::isnan(errors.sampled.difference_db(l, k))) continue;
      const double size = sizes[static_cast<std::size_t>(l)] / values(l, k);
      shifts.push_back(decibels(1 + size));
    }
  }
  if (shifts.empty()) return {};
  std::sort(shifts.begin(), shifts.end(), std::greater<>());
  return {shifts.front(), shifts[(shifts.size() - 1) / 10]};
}

}  // namespace

UnmeasuredFloor unmeasured_floor(const LoopDesign& design, const JudgedResponse& response,
                                 bool active, bool inputs_are_floors, FloorNodes nodes) {
  UnmeasuredFloor result;
  if (!response.errors || nodes == FloorNodes::rest) return result;
  const std::vector<SceneSignal> inputs = unmeasured(
      design.scene, response.measured.signals, inputs_are_floors && nodes == FloorNodes::follow);
  result.n_directions = std::ssize(inputs);
  if (inputs.empty()) return result;
  const Shifts shifts = shifts_of(sizes(design, inputs, response, active), *response.errors);
  result.largest_db = shifts.largest_db;
  result.broadly_db = shifts.broadly_db;
  return result;
}

}  // namespace stillframe::judge

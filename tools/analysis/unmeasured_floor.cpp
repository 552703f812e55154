#include "tools/analysis/unmeasured_floor.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "core/model/model.hpp"
#include "tools/analysis/response_prediction.hpp"

namespace stillframe::tools {

using Eigen::Index;

namespace {

/// What is left of a direction across others, which are orthonormal; nothing of one within them.
Eigen::Vector3d across(Eigen::Vector3d direction, const std::vector<Eigen::Vector3d>& others) {
  for (const Eigen::Vector3d& other : others) direction -= other.dot(direction) * other;
  // Directions of a scene are written in a few digits.
  return direction.norm() > 1e-6 ? direction.normalized() : Eigen::Vector3d::Zero();
}

void add_to(std::vector<Eigen::Vector3d>& basis, const Eigen::Vector3d& direction) {
  const Eigen::Vector3d rest = across(direction, basis);
  if (!rest.isZero(0)) basis.push_back(rest);
}

const SceneSignal* signal_named(const Scene& scene, const std::string& name) {
  for (const auto* list : {&scene.outputs, &scene.monitors}) {
    for (const SceneSignal& signal : *list) {
      if (signal.name == name) return &signal;
    }
  }
  return nullptr;
}

/// Translations of floor nodes that no input tells of, as inputs.
std::vector<SceneSignal> unmeasured(const Scene& scene, const report::ResponseSignals& signals,
                                    bool inputs_are_floors) {
  std::vector<Eigen::Vector3d> floors;
  if (inputs_are_floors) {
    for (const std::string& name : signals.inputs) {
      if (const SceneSignal* signal = signal_named(scene, name)) add_to(floors, signal->direction);
    }
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

/// Largest singular value of T from unmeasured directions to outputs, one a frequency, of a scene
/// with the gains of a design.
std::vector<double> sizes(const LoopDesign& design, Scene scene,
                          const std::vector<SceneSignal>& inputs, const JudgedResponse& response,
                          bool active) {
  scene.inputs = inputs;
  LoopDesign other;
  other.model = make_model(scene);
  other.scene = std::move(scene);
  other.loop = design.loop;
  other.gains = design.gains;
  report::ResponseSignals signals{{}, response.measured.signals.outputs};
  for (const SceneSignal& input : inputs) signals.inputs.push_back(input.name);
  std::vector<double> result;
  const auto prediction =
      ResponsePrediction(other, signals).at(response.measured.response->frequencies_hz, active);
  for (const Eigen::MatrixXcd& T : prediction.sampled) {
    result.push_back(T.size() > 0 ? T.jacobiSvd().singularValues()(0) : 0);
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
      shifts.push_back(20 * std::log10(1 + size));
    }
  }
  if (shifts.empty()) return {};
  std::sort(shifts.begin(), shifts.end(), std::greater<>());
  return {shifts.front(), shifts[(shifts.size() - 1) / 10]};
}

/// The causes that a scene has, each with what takes all others away.
struct Cause {
  const char* name;
  bool there;
  std::function<void(Scene&)> remove;
};

std::vector<Cause> causes_of(const Scene& scene) {
  const bool preloaded =
      std::any_of(scene.elements.begin(), scene.elements.end(), [](const SceneElement& element) {
        return element.preload.size() > 0 && !element.preload.isZero(0);
      });
  return {{"weight", !scene.gravity.isZero(0), [](Scene& s) { s.gravity.setZero(); }},
          {"preload", preloaded,
           [](Scene& s) {
             for (SceneElement& element : s.elements) element.preload.setZero();
           }},
          {"loads", !scene.loads.empty(), [](Scene& s) { s.loads.clear(); }}};
}

/// Those without which the frame would be shaken by half or less; its springs, if it would not be
/// without any; all that are there, where no one of them decides.
std::string why(const LoopDesign& design, const std::vector<SceneSignal>& inputs,
                const JudgedResponse& response, bool active, double largest_db) {
  const auto without = [&](const std::function<void(Scene&)>& remove) {
    Scene scene = design.scene;
    remove(scene);
    return shifts_of(sizes(design, std::move(scene), inputs, response, active), *response.errors)
        .largest_db;
  };
  std::string there, deciding;
  const auto add = [](std::string& list, const char* name) {
    list += (list.empty() ? "" : " and ") + std::string(name);
  };
  const std::vector<Cause> causes = causes_of(design.scene);
  const auto none = [&](Scene& scene) {
    for (const Cause& cause : causes) cause.remove(scene);
  };
  for (const Cause& cause : causes) {
    if (cause.there) add(there, cause.name);
  }
  const char* const springs = "springs across the inputs";
  if (there.empty()) return springs;
  try {
    if (without(none) > largest_db / 2) return springs;
    for (const Cause& cause : causes) {
      if (cause.there && without(cause.remove) <= largest_db / 2) add(deciding, cause.name);
    }
  } catch (const std::exception&) {
    // A frame that does not stand without one of them is held by it.
  }
  return deciding.empty() ? there : deciding;
}

}  // namespace

UnmeasuredFloor unmeasured_floor(const LoopDesign& design, const JudgedResponse& response,
                                 bool active, bool inputs_are_floors) {
  UnmeasuredFloor result;
  if (!response.errors) return result;
  const std::vector<SceneSignal> inputs =
      unmeasured(design.scene, response.measured.signals, inputs_are_floors);
  result.n_directions = std::ssize(inputs);
  if (inputs.empty()) return result;
  const Shifts shifts =
      shifts_of(sizes(design, design.scene, inputs, response, active), *response.errors);
  result.largest_db = shifts.largest_db;
  result.broadly_db = shifts.broadly_db;
  // Less is not told of.
  if (result.largest_db > response.errors->sampled.tolerance_db) {
    result.why = why(design, inputs, response, active, shifts.largest_db);
  }
  return result;
}

}  // namespace stillframe::tools

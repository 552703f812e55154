#include "judge/response_prediction.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <set>
#include <utility>

#include "controller/law.hpp"
#include "core/errors/input_error.hpp"
#include "core/mechanics/state_space.hpp"
#include "core/numerics/two_pi.hpp"

namespace stillframe::judge {

using Eigen::Index;
using Eigen::MatrixXd;

const SceneSignal& signal_of(const Scene& scene, const std::string& name) {
  for (const auto* list : {&scene.outputs, &scene.monitors}) {
    for (const SceneSignal& signal : *list) {
      if (signal.name == name) return signal;
    }
  }
  throw InputError("the scene has no output and no monitor '" + name + "'");
}

namespace {

bool are_the_inputs(const Scene& scene, const std::vector<std::string>& names) {
  return std::equal(
      names.begin(), names.end(), scene.inputs.begin(), scene.inputs.end(),
      [](const std::string& name, const SceneSignal& signal) { return name == signal.name; });
}

std::vector<SceneSignal> floor_signals(const Scene& scene, const std::vector<std::string>& names) {
  std::set<std::string> on_floor;
  for (const SceneConstraint& constraint : scene.prescribed) on_floor.insert(constraint.node);
  std::vector<SceneSignal> signals;
  for (const std::string& name : names) {
    signals.push_back(signal_of(scene, name));
    if (signals.back().quantity != Quantity::acceleration ||
        !on_floor.contains(signals.back().node)) {
      throw InputError("'" + name + "' is no acceleration of a node that the floor moves");
    }
  }
  return signals;
}

/// Which rows are no combinations of those before them.
std::vector<bool> independent_rows(const MatrixXd& directions) {
  // Inputs that are less apart are not told apart in a log either.
  constexpr double least_angle = 1 / report::largest_shown_condition;
  std::vector<bool> independent;
  std::vector<Eigen::RowVector3d> basis;
  for (Index i = 0; i < directions.rows(); ++i) {
    Eigen::RowVector3d rest = directions.row(i);
    for (const Eigen::RowVector3d& other : basis) rest -= other.dot(rest) * other;
    independent.push_back(rest.norm() > least_angle * directions.row(i).norm());
    if (independent.back()) basis.push_back(rest.normalized());
  }
  return independent;
}

}  // namespace

std::vector<SceneSignal> prescribed_translations(const Scene& scene) {
  std::vector<SceneSignal> inputs;
  for (const SceneConstraint& constraint : scene.prescribed) {
    if (constraint.rotation || !constraint.element.empty()) continue;
    for (const Eigen::Vector3d& direction : constraint.directions) {
      SceneSignal signal;
      signal.name = constraint.node + " " + std::to_string(inputs.size());
      signal.place = constraint.place;
      signal.node = constraint.node;
      signal.quantity = Quantity::acceleration;
      signal.direction = direction;
      inputs.push_back(signal);
    }
  }
  return inputs;
}

MatrixXd directions_of(const std::vector<SceneSignal>& signals) {
  MatrixXd D = MatrixXd::Zero(std::ssize(signals), 3);
  for (std::size_t i = 0; i < signals.size(); ++i) {
    if (signals[i].quantity != Quantity::acceleration) continue;
    D.row(static_cast<Index>(i)) = signals[i].direction.transpose();
  }
  return D;
}

report::AxisSignals signals_by_motion(const Scene& scene,
                                      const std::vector<report::AxisPlan>& axes) {
  report::AxisSignals result = report::signals_by_name(axes);
  const std::vector<std::string> floors = std::exchange(result.signals.inputs, {});
  const MatrixXd D = directions_of(floor_signals(scene, floors));
  const std::vector<bool> independent = independent_rows(D);
  std::vector<Index> rows;
  for (std::size_t i = 0; i < floors.size(); ++i) {
    (independent[i] ? result.signals.inputs : result.dependent_floors).push_back(floors[i]);
    if (independent[i]) rows.push_back(static_cast<Index>(i));
  }
  const MatrixXd inputs = D(rows, Eigen::all);
  // A floor that moves by a has signals D a: one along its own direction d alone moves by d / d'd.
  const MatrixXd own = D.array().colwise() / D.rowwise().squaredNorm().array();
  result.along = result.along * own * inputs.transpose();
  return result;
}

MatrixXd floors_of_inputs(const Scene& scene, const std::vector<std::string>& names) {
  return directions_of(floor_signals(scene, names)) *
         directions_of(scene.inputs).completeOrthogonalDecomposition().pseudoInverse();
}

MatrixXd inputs_of_floors(const Scene& scene, const std::vector<std::string>& names) {
  return directions_of(scene.inputs) * directions_of(floor_signals(scene, names))
                                           .completeOrthogonalDecomposition()
                                           .pseudoInverse();
}

namespace {

/// The law of a design behind a plant whose inputs are other motions of the same floor: what the
/// feed-forward hears of each is its part along the measured accelerations of that node.
DiscreteLaw law_hearing(const LoopDesign& design, const std::vector<SceneSignal>& inputs) {
  DiscreteLaw law = controller::law_from_gains(design.gains);
  const std::vector<SceneSignal>& measured = design.scene.inputs;
  if (law.feed_forward.D.cols() == 0) return law;
  MatrixXd heard = MatrixXd::Zero(std::ssize(measured), std::ssize(inputs));
  for (Index i = 0; i < heard.rows(); ++i) {
    for (Index j = 0; j < heard.cols(); ++j) {
      const SceneSignal &a = measured[static_cast<std::size_t>(i)],
                        &b = inputs[static_cast<std::size_t>(j)];
      if (a.node == b.node) heard(i, j) = a.direction.dot(b.direction);
    }
  }
  law.feed_forward.B *= heard;
  law.feed_forward.D *= heard;
  return law;
}

}  // namespace

ResponsePrediction::ResponsePrediction(const LoopDesign& design,
                                       const report::ResponseSignals& signals, FloorNodes nodes) {
  Scene scene = design.scene;
  std::vector<SceneSignal> outputs;
  for (const std::string& name : signals.outputs) outputs.push_back(signal_of(scene, name));
  bool same = true;
  if (are_the_inputs(scene, signals.inputs)) {
    E_ = MatrixXd::Identity(static_cast<Index>(scene.inputs.size()),
                            static_cast<Index>(scene.inputs.size()));
  } else {
    const MatrixXd D = directions_of(floor_signals(scene, signals.inputs));
    const std::vector<bool> independent = independent_rows(D);
    const auto other = std::find(independent.begin(), independent.end(), false);
    if (other != independent.end()) {
      throw InputError("'" + signals.inputs[static_cast<std::size_t>(other - independent.begin())] +
                       "' moves as the other floor signals say, and is no input of its own");
    }
    if (nodes != FloorNodes::rest) {
      scene.inputs = prescribed_translations(scene);
      same = false;
    }
    E_ = inputs_of_floors(scene, signals.inputs);
  }
  scene.outputs = outputs;
  loop_ = design.loop;
  loop_.plant = loop_model(scene, design.model);
  loop_.n_w = static_cast<Index>(scene.inputs.size());
  loop_.n_y = static_cast<Index>(scene.outputs.size());
  const LoopPlant plant = loop_plant(loop_.plant, loop_.n_w, loop_.n_y);
  const SampledPlant sampled = sample_and_hold(plant, design.gains.sampling());
  open_ = open_loop(sampled);
  closed_ = close_loop(
      sampled, same ? controller::law_from_gains(design.gains) : law_hearing(design, scene.inputs));
}

PredictedResponse ResponsePrediction::at(const std::vector<double>& frequencies_hz,
                                         bool active) const {
  PredictedResponse response{frequencies_hz, {}, {}};
  for (const double frequency : frequencies_hz) {
    const double omega = two_pi * frequency;
    const std::complex<double> s(0, omega);
    response.sampled.push_back(transfer(active ? closed_ : open_, omega) * E_);
    response.continuous.push_back((active ? loop_.closed(s) : loop_.open(s)) * E_);
  }
  return response;
}

}  // namespace stillframe::judge

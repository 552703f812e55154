#pragma once

#include <Eigen/Core>
#include <vector>

#include "judge/floor_nodes.hpp"
#include "judge/loop_design.hpp"
#include "report/analysis/axis_signals.hpp"

namespace stillframe::judge {

/// T between signals of a log as the model has it, at one frequency each, n_y x n_w.
struct PredictedResponse {
  std::vector<double> frequencies_hz;
  std::vector<Eigen::MatrixXcd> sampled;     ///< what a log must show
  std::vector<Eigen::MatrixXcd> continuous;  ///< of the continuous loop, without sampling
};

/// The directions of accelerations, n x 3; zero of signals that are none.
Eigen::MatrixXd directions_of(const std::vector<SceneSignal>& signals);

/// The signals of axes on a floor that does not turn. Floors of which one moves as the others say,
/// as two feet along one direction do, tell of one motion: those that are named first are the
/// inputs, the others depend on them. Errors: as ResponsePrediction.
report::AxisSignals signals_by_motion(const Scene& scene,
                                      const std::vector<report::AxisPlan>& axes);

/// Accelerations of floor nodes as the scene's inputs have them on a floor that does not turn,
/// names x inputs: D_m D_w^+, D the rows of their directions. Errors: as ResponsePrediction.
Eigen::MatrixXd floors_of_inputs(const Scene& scene, const std::vector<std::string>& names);

/// The scene's inputs on a floor that does not turn, moves these accelerations of its nodes by one
/// each, and does not move across them, inputs x names: D_w D_m^+. Errors: as ResponsePrediction.
Eigen::MatrixXd inputs_of_floors(const Scene& scene, const std::vector<std::string>& names);

/// Errors: InputError if no output and no monitor has that name.
const SceneSignal& signal_of(const Scene& scene, const std::string& name);

/// Every prescribed translation of a scene as an input of its own (m/s^2).
std::vector<SceneSignal> prescribed_translations(const Scene& scene);

/// Predicts T between accelerations of a loop's scene. Inputs are either the scene's inputs, all of
/// them in their order, or accelerations of floor nodes; the latter speak for a floor that does not
/// turn, whose translation a follows from them, m = D a, D the rows of their directions: all of its
/// nodes move by a, or where they rest the scene's inputs alone. Set-up.
class ResponsePrediction {
 public:
  /// Errors: InputError for a signal that the scene has not, for an input that is no acceleration
  /// of a prescribed node, and for inputs whose directions depend on each other: no response tells
  /// what each of them does.
  ResponsePrediction(const LoopDesign& design, const report::ResponseSignals& signals,
                     FloorNodes nodes = FloorNodes::follow);

  /// With the law, or with zero commands.
  PredictedResponse at(const std::vector<double>& frequencies_hz, bool active) const;

 private:
  ControlLoop loop_;
  SampledLoop open_, closed_;
  Eigen::MatrixXd E_;  ///< loop inputs x signals: w = E m
};

}  // namespace stillframe::judge

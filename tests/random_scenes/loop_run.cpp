#include "tests/random_scenes/loop_run.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/mechanics/node_moves.hpp"
#include "core/mechanics/state_space.hpp"
#include "core/numerics/eigenvalues.hpp"
#include "core/numerics/worst.hpp"
#include "plant_sim/floor/sources.hpp"
#include "tools/run/closed_loop.hpp"

namespace stillframe::random_scenes {

void Signals::shorten(Index n) {
  for (Eigen::MatrixXd* each : {&sigma, &acceleration, &force}) {
    each->conservativeResize(n, Eigen::NoChange);
  }
}

Signals run_loop(const Scene& scene, const judge::LoopDesign& design,
                 std::unique_ptr<floor::FloorSource> floor, Index n, bool active,
                 long most_evaluations) {
  controller::Gains gains = design.gains;
  gains.force_limit_n = scene.controller->force_limit_n;
  tools::ClosedLoop loop(scene, gains, std::move(floor), 1, active);
  const auto n_legs = static_cast<Index>(scene.controller->legs.size());
  Signals out{Eigen::MatrixXd(n, n_legs),
              Eigen::MatrixXd(n, static_cast<Index>(scene.outputs.size() + scene.monitors.size())),
              Eigen::MatrixXd(n, n_legs)};
  for (Index k = 0; k < n; ++k) {
    const std::string reason = loop.step();
    if (!reason.empty()) throw std::runtime_error(reason);
    const auto row = [](const std::vector<double>& values) {
      return Eigen::Map<const Eigen::RowVectorXd>(values.data(), static_cast<Index>(values.size()));
    };
    out.sigma.row(k) = row(loop.measurement().sigma);
    out.acceleration.row(k) = row(loop.measurement().frame_acceleration);
    out.force.row(k) = row(loop.command().force);
    if (k + 1 < n && loop.plant().evaluations() >= most_evaluations) out.shorten(n = k + 1);
  }
  return out;
}

Signals run_loop(const Scene& scene, const judge::LoopDesign& design, const Eigen::MatrixXd& floor,
                 bool active) {
  return run_loop(scene, design,
                  std::make_unique<floor::TabulatedFloor>(floor::FloorChannels::inputs, floor),
                  floor.cols(), active);
}

Index run_samples(Case& scene) {
  const Index all = floor::make_floor_source(*scene.floor())->n_samples();
  const double stated = scene.scene().simulation.duration_s;
  if (!(stated > 0)) return all;
  const double n = std::round(stated * scene.scene().controller->sample_rate_hz);
  return std::clamp<Index>(static_cast<Index>(n), 1, all);
}

long affordable_evaluations(Case& scene) {
  if (scene.in_full) return std::numeric_limits<long>::max();
  // An evaluation takes up to a microsecond for each coordinate of a node.
  return 2'000'000 / scene.model().n_x;
}

Scene without_nonlinear_instruments(Scene scene) {
  scene.instruments.force_rate_limit = std::numeric_limits<double>::infinity();
  scene.instruments.hysteresis.reset();
  scene.instruments.force_sensors.reset();
  scene.instruments.floor_sensors.reset();
  scene.controller->force_limit_n.reset();
  scene.disturbances.clear();
  return scene;
}

double fastest_rate(Case& scene) {
  const auto rates = eigenvalues(state_matrix(scene.linear()));
  if (!rates) throw std::runtime_error("the eigenvalues of the linear model are not found");
  return rates->size() > 0 ? rates->cwiseAbs().maxCoeff() : 0.0;
}

RunRounding::RunRounding(Case& scene) {
  const double fastest = fastest_rate(scene);
  const Model& model = scene.model();
  double stiffest = 0, static_force = 0;
  for (const ModelElement& element : model.elements) {
    if (element.S.size() > 0) stiffest = std::max(stiffest, element.S.cwiseAbs().maxCoeff());
  }
  for (const SceneElement& element : scene.scene().elements) {
    static_force = std::max(static_force, worst_of(element.preload));
  }
  // Positions that satisfy conditions are known to some 1e-12 of the scene's size, what changes of
  // them from one sample to the next to some hundred epsilon: a rotor turns all the time.
  const double eps = 1000 * std::numeric_limits<double>::epsilon(), size = scene_size(model);
  acceleration = eps * size * fastest * fastest;
  sigma = 1e-12 * (size * stiffest + static_force);
}

}  // namespace stillframe::random_scenes

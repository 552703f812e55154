#include "bench/large_motion/our_runs.hpp"

#include "bench/plant_run.hpp"
#include "plant_sim/floor/sources.hpp"

namespace stillframe::race {

Run our_run(Scene scene, const Eigen::MatrixXd& inputs, PlantMethod method, double tolerance) {
  scene.simulation.method = method;
  scene.simulation.relative_tolerance = tolerance;
  Plant plant(scene, std::make_unique<floor::TabulatedFloor>(floor::FloorChannels::inputs, inputs));
  const Eigen::VectorXd command =
      Eigen::VectorXd::Zero(static_cast<Index>(scene.controller->legs.size()));
  const auto n_outputs = static_cast<Index>(scene.outputs.size());
  Run result;
  result.accelerations.resize(n_outputs, inputs.cols());
  const double begin = thread_seconds();
  for (Index k = 0; k < inputs.cols(); ++k) {
    if (const std::string reason = plant.advance(command); !reason.empty()) {
      throw std::runtime_error(reason);
    }
    result.accelerations.col(k) = plant.read().frame_acceleration.head(n_outputs);
  }
  result.seconds = thread_seconds() - begin;
  return result;
}

}  // namespace stillframe::race

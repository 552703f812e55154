#pragma once

#include <cmath>
#include <limits>

#include "core/mechanics/operating_point.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "plant_sim/motion/adaptive_motion.hpp"
#include "plant_sim/motion/exponential_motion.hpp"
#include "plant_sim/motion/make_motion.hpp"
#include "plant_sim/motion/ode_motion.hpp"
#include "plant_sim/plant.hpp"
#include "tests/plant_sim/frame.hpp"

namespace stillframe::test {

inline Scene scene_of(const std::string& name, const std::string& folder = "config/scenes") {
  return read_scene(std::filesystem::path(STILLFRAME_SOURCE_DIR) / folder / (name + ".yaml"));
}

/// A plant's accelerations and stresses, samples x (outputs, legs), under given forces (legs x
/// samples) and floor inputs (inputs x samples).
inline Eigen::MatrixXd trajectory(const Scene& scene, const Eigen::MatrixXd& forces,
                                  const Eigen::MatrixXd& floor) {
  Plant plant(scene, table(floor));
  const auto n_y = static_cast<Index>(scene.outputs.size());
  Eigen::MatrixXd result(forces.cols(), n_y + forces.rows());
  for (Index k = 0; k < forces.cols(); ++k) {
    const std::string reason = plant.advance(forces.col(k));
    if (!reason.empty()) throw std::runtime_error(reason);
    result.row(k) << plant.read().frame_acceleration.head(n_y).transpose(),
        plant.read().sigma.transpose();
  }
  return result;
}

inline Scene with_method(Scene scene, PlantMethod method, double tolerance) {
  scene.simulation.method = method;
  scene.simulation.relative_tolerance = tolerance;
  return scene;
}

inline double relative(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return (a - b).norm() / b.norm();
}

/// A scene's motion with the parts of a plant in the open.
struct MotionRig {
  MergedScene merged;
  Model model;
  Drive drive;
  MinimalEquations equations;
  MotionChoice choice;
  std::unique_ptr<Motion> motion;

  MotionRig(const Scene& scene, PlantMethod method, Eigen::MatrixXd floor)
      : merged(merge_rigid_bodies(scene)),
        model(make_model(merged.scene)),
        drive(FloorMotion(table(std::move(floor)), merged.scene, model),
              Actuators(static_cast<Index>(scene.controller->legs.size()),
                        std::numeric_limits<double>::infinity(), {}),
              Disturbances(merged.scene, model, 1 / scene.controller->sample_rate_hz),
              legs_of(scene, model)),
        equations(model, nominal_motion(model), drive.legs(), 0),
        choice{method, ""},
        motion(make_motion(merged, model, choice, drive, {1 / scene.controller->sample_rate_hz})) {}

  static std::vector<Index> legs_of(const Scene& scene, const Model& model) {
    std::vector<Index> rows;
    for (const std::string& leg : scene.controller->legs) {
      rows.push_back(model.deformation_row(leg));
    }
    return rows;
  }

  /// Holds forces (N) for a duration (s).
  bool hold(const Eigen::VectorXd& force, double duration) {
    drive.actuators().command(force);
    if (motion->advance(drive, duration) != Motion::Status::ok) return false;
    drive.floor().finish(duration);
    drive.actuators().finish(duration);
    return true;
  }
  const Eigen::VectorXd& state() const {
    if (const auto* exponential = dynamic_cast<const ExponentialMotion*>(motion.get())) {
      return exponential->state();
    }
    return dynamic_cast<const OdeMotion&>(*motion).state();
  }
  /// Kinetic and potential energy, J, on a floor at rest.
  double energy() {
    Eigen::VectorXd rate(equations.size());
    equations.evaluate(drive, 0, state(), rate);
    return kinetic_energy(model, equations.data()) + potential_energy(model, equations.data());
  }
};

}  // namespace stillframe::test

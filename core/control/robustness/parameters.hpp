#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/mechanics/scene/scene.hpp"
#include "core/systems/sampled_plant.hpp"

namespace stillframe::robustness {

/// One thing that the plant may differ in from its model, in the scale of a value of -1 to 1.
struct Parameter {
  enum class Kind {
    stiffness,       ///< of a leg, all its deformations alike: relative
    damping,         ///< of a leg that has some, all its dampers alike: relative
    mass,            ///< of one entry of masses: relative
    inertia,         ///< of one entry of masses, all its moments alike: relative
    centre_of_mass,  ///< position of a node with a mass, along `direction`: m
    leg_direction,   ///< of a leg, towards `direction`: rad
    actuator_gain,   ///< of a leg: relative
    sensor_gain,     ///< of a leg's force sensor: relative
    delay,           ///< of all commands: samples
  };
  Kind kind = Kind::stiffness;
  std::string subject;  ///< name of the leg or of the node; empty for the delay
  size_t index = 0;     ///< of a leg in the controller block, of a mass or a node in the scene
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< unit vector
  double size = 0;                                      ///< deviation at a value of 1
};

/// The parameters of a scene with a controller, p of them, in the order of Parameter::Kind; a kind
/// whose uncertainty is 0 has none.
///   Centre of mass: of every node that carries a mass, ends no leg and is not held altogether.
///   Leg direction: about both axes across the leg (in a planar scene the one), towards the two
///   directions across it that are nearest to world axes.
/// Set-up.
std::vector<Parameter> parameters_of(const Scene& scene, const SceneUncertainty& uncertainty);

/// A parameter in words: "stiffness", "leg_1v" ("lens along x", "leg_1v towards y"), and "+10 %" at
/// a value; the delay has no subject.
std::string kind_text(Parameter::Kind kind);
/// Its key in `uncertainty` and in `corrections`.
std::string key_of(Parameter::Kind kind);
std::string subject_text(const Parameter& parameter);
std::string deviation_text(const Parameter& parameter, double value);

/// All of it: "leg_1v stiffness", and "leg_1v stiffness +10 %".
std::string name_of(const Parameter& parameter);
std::string describe(const Parameter& parameter, double value);

/// A plant that differs from its model.
struct PerturbedPlant {
  Scene scene;
  Sampling sampling;
};

/// The scene and its sampling with every parameter at its value (p, -1 to 1).
///   A leg turns, at constant length, about its end that is less held, the end at the frame; its
///   foot is displaced, and whatever else ends in that node goes with it. A node with a mass is
///   displaced, and its other elements are unstrained in their new shape. Nodes that hinges join
///   move together. The delay goes no lower than 0.
/// Set-up. Errors: std::invalid_argument unless there is a value for each parameter.
PerturbedPlant perturbed(const Scene& scene, const Sampling& sampling,
                         const std::vector<Parameter>& parameters, const Eigen::VectorXd& values);

/// What a loop is closed around: linear model about the plant's equilibrium, sampled; y are the
/// scene's outputs. Set-up. Errors: InputError, Refusal.
SampledPlant sampled(const PerturbedPlant& plant);

}  // namespace stillframe::robustness

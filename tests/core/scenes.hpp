#pragma once

#include <random>
#include <string>

#include "core/mechanics/dynamics.hpp"
#include "core/mechanics/scene/scene.hpp"

namespace stillframe::test {

/// The scenes of config/scenes.
Scene frame_scene();
Scene cart_scene();

/// The cart with q^d = x(mass) in place of e(spring): the moving floor then strains the spring.
Scene cart_by_position();
/// The same frame with q^d = x, y, z and the Euler parameters 1, 2, 3 of the lens; the legs become
/// redundant.
Scene by_lens_coordinates(Scene frame);
/// The frame with dampers, a load of its weight at the lens and a second, opposing truss beside
/// each leg; legs and opposing trusses are preloaded in balance. The upper ends of the vertical
/// ones are prescribed along oblique axes.
Scene preloaded_frame();
/// A crank (rigid beam on a ball joint) that pushes a slider on an oblique rail by a rigid rod;
/// springs to a prescribed wall and to a fixed anchor hold it. q^d: the Euler parameters of the
/// crank. Loads and preloads balance.
Scene mechanism();
/// A body with three different principal axes that are not the coordinate axes, in free space.
Scene free_body();
/// A mass between two trusses of length 0.5 m and 0.8 m along x, both with the preload tension (N).
Scene strung_mass(double tension);

/// Inputs and outputs of every kind, for the frames and for the mechanism; they replace those of
/// the scene.
void use_all_signals_of_frame(Scene& scene);
void use_all_signals_of_mechanism(Scene& scene);

/// The scene turned by Q and shifted by t, with all its directions.
Scene moved(Scene scene, const Eigen::Matrix3d& Q, const Eigen::Vector3d& t);
/// Nodes, elements, masses and supports in another order.
Scene renumbered(Scene scene, unsigned seed);
/// From metres and kilograms to millimetres and tonnes (forces stay in N, time in s).
Scene in_millimetres(Scene scene);

Eigen::Matrix3d random_rotation(unsigned seed);
Eigen::VectorXd random_vector(Eigen::Index n, std::mt19937& engine);
/// A random state: dofs and rates of the given sizes (Euler parameters: radians), prescribed motion
/// alike.
MotionState random_motion(const Model& model, double size, double rate, std::mt19937& engine);

SceneDof dof_of_element(const std::string& element, int mode = 1);
SceneDof dof_along(const std::string& node, const Eigen::Vector3d& direction);
SceneDof dof_euler(const std::string& node, int parameter);
SceneSignal node_signal(const std::string& name, const std::string& node, Quantity quantity,
                        const Eigen::Vector3d& direction);
SceneSignal element_signal(const std::string& name, const std::string& element, Quantity quantity,
                           int mode = 1);
SceneLoad force_at(const std::string& node, const Eigen::Vector3d& force);
/// Dofs q_d, at rest, prescribed motion as written.
MotionState position_state(const Model& model, const Eigen::VectorXd& q_d);

}  // namespace stillframe::test

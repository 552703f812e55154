#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/mechanics/scene/scene.hpp"

namespace stillframe {

/// An element as a vector from the end at the frame to its foot, the end that is held along more
/// directions.
struct SceneLeg {
  size_t foot = 0, top = 0;  ///< nodes
  Eigen::Vector3d span = Eigen::Vector3d::Zero();
};

/// Errors: std::out_of_range on names that are not there.
size_t node_index(const Scene& scene, const std::string& name);
size_t element_index(const Scene& scene, const std::string& name);

/// Number of directions in which a node is supported or prescribed.
size_t directions_held(const Scene& scene, const std::string& node);

SceneLeg leg_of(const Scene& scene, const std::string& element);

/// The two directions across a leg (in a planar scene the one) in which its foot can go, those
/// nearest to world axes.
std::vector<Eigen::Vector3d> across(const Eigen::Vector3d& span, bool planar);

/// All stiffnesses of an element; its dampers stay. And all its dampers.
void scale_stiffness(SceneElement& element, double factor);
void scale_damping(SceneElement& element, double factor);
/// Whether it has any.
bool is_damped(const SceneElement& element);
bool is_stiff(const SceneElement& element);

/// Displaces a node (m), and with it those that hinges join to it. Elements that end there are
/// unstrained in their new shape.
void move_node(Scene& scene, size_t node, const Eigen::Vector3d& displacement);

/// Turns a leg at constant length about its top, by the rotation vector whose foot goes along
/// `angle` (rad, across the leg); whatever else ends in its foot goes with it.
void turn_leg(Scene& scene, const SceneLeg& leg, const Eigen::Vector3d& angle);

}  // namespace stillframe

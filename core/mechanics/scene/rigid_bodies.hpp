#pragma once

#include <map>
#include <set>
#include <string>

#include "core/mechanics/scene/scene.hpp"

namespace stillframe {

/// A node that rigid beams join to a body's node: a point of the body at an arm (m, scene as
/// written) from it.
struct CarriedNode {
  std::string body;
  Eigen::Vector3d arm;
};

/// A scene in which rigid bodies have one node each, and what became of the others.
struct MergedScene {
  Scene scene;
  std::map<std::string, CarriedNode> carried;
};

/// Takes out the nodes that rigid beams join to another node and to which nothing but trusses is
/// attached besides, with those beams; the trusses get arms. The motion of what is left is the same
/// as before (the rigid beams are solved for), in fewer coordinates: the metrology frame has 7
/// instead of 28. Nodes with a mass, load, support, prescribed motion, dof, input or disturbance,
/// and those in `keep`, stay; so does everything in a planar scene. Outputs and monitors are left
/// as they are, also where they name a node that is carried. Set-up.
MergedScene merge_rigid_bodies(const Scene& scene, const std::set<std::string>& keep = {});

}  // namespace stillframe

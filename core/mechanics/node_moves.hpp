#pragma once

#include <string>

#include "core/mechanics/model/model.hpp"

namespace stillframe {

/// How far the scene as written reaches from its first node, m; 1 if all nodes are in one place.
double scene_size(const Model& model);

/// The same where a displacement (n_x) has taken the nodes, if that is more.
double scene_size(const Model& model, const Eigen::VectorXd& displacement);

/// The largest turn of a node, rad, in a displacement (n_x): twice that of its Euler parameters.
double largest_turn(const Model& model, const Eigen::VectorXd& displacement);

/// The same, or the largest translation over the size of the scene if that is more: how far a
/// displacement goes, in all units.
double largest_move(const Model& model, const Eigen::VectorXd& displacement);

/// The same with translations over another size, m.
double largest_move(const Model& model, const Eigen::VectorXd& displacement, double size);

/// The turn (angle times axis, rad) of a displacement of a rotation: the angle of a planar node (1)
/// or changes of Euler parameters (4).
Eigen::Vector3d turn_of(const LocalVector& local);

/// The node that a displacement (n_x) moves most by that measure, and how: "node c1 has moved
/// -0.41 m along z", "node table has turned 0.8 rad about y". Empty if none moves.
std::string largest_move_in_words(const Model& model, const Eigen::VectorXd& displacement);

/// The largest work of nodal forces (n_x), N m, over a move of 1.
double largest_nodal_work(const Model& model, const Eigen::VectorXd& forces);

}  // namespace stillframe

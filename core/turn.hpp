#pragma once

#include "core/model/model.hpp"

namespace stillframe {

/// The largest turn of a node, rad, in a displacement (n_x): twice that of its Euler parameters.
double largest_turn(const Model& model, const Eigen::VectorXd& displacement);

}  // namespace stillframe

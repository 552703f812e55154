#pragma once

#include "bench/large_motion/mechanism.hpp"
#include "core/mechanics/scene/scene.hpp"

namespace stillframe::race {

/// The plant simulator with all commands zero; inputs: inputs x samples, m/s^2, held over each
/// sample. Errors: std::runtime_error with the reason of a plant that cannot go on.
Run our_run(Scene scene, const Eigen::MatrixXd& inputs, PlantMethod method, double tolerance);

}  // namespace stillframe::race

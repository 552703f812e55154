#pragma once

#include <string>

#include "controller/gains.hpp"

// What a gains file is held to beside the ranges of its numbers.
namespace stillframe::controller {

/// States of the sampled loop that gains are judged by, at most: plant, law, instruments, and what
/// is under way.
Eigen::Index most_loop_states(const Gains& gains);

/// More of them take minutes to be judged, the time being their cube.
inline constexpr Eigen::Index largest_loop = 400;

/// Accelerations of a floor: for each the loop is followed when a controller starts.
inline constexpr Eigen::Index most_floor_channels = 64;

/// Of the legs, the scene's hash and the matrices of the plant: 16 hexadecimal digits.
std::string plant_hash(const Gains& gains);

}  // namespace stillframe::controller

#pragma once

#include "core/mechanics/model/model.hpp"

namespace stillframe {

/// One signal for each prescribed coordinate (n_r, in their order), of its position, named as a
/// person would: "axle", "axle (mode 2)", "mount_1 along x", "table (rotation)".
std::vector<SceneSignal> prescribed_signals(const Model& model);

/// Whether the motion of a signal is an angle (rad), that of a hinge or a rotation, or a length
/// (m).
bool is_angle(const Model& model, const SceneSignal& signal);

/// "x", "y", "z", or the numbers of another direction.
std::string direction_in_words(const Eigen::Vector3d& direction);

}  // namespace stillframe

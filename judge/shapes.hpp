#pragma once

#include <optional>

#include "core/mechanics/model/model.hpp"
#include "report/page/mode_shapes.hpp"

namespace stillframe::judge {

/// The structure of a scene at its operating point and its slowest modes, for pictures: the
/// displacement of each node is Y_p v, v the mode shape of the dofs and Y_p that of the positions
/// of all nodes. Nodes that no dof moves count as floor. Damping ratios are given where legs or
/// beams have damping. Nothing if the model has no natural frequencies (in motion, or a stiffness
/// that is not symmetric). most_modes: how many at most. Errors: Refusal of linearise() and
/// modes().
std::optional<page::ModeShapes> mode_shapes(const Scene& scene, const Model& model,
                                            Eigen::Index most_modes = 6);

}  // namespace stillframe::judge

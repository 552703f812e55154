#pragma once

#include "bench/simbody/runs.hpp"
#include "core/mechanics/scene/scene.hpp"

namespace stillframe::simbody {

/// What Simbody is told of a scene: its only body on its trusses, whose first nodes the inputs move
/// in their order; and its rigid beams on hinges.
BodyOnSprings body_on_springs(const Scene& scene);
LinkChain link_chain(const Scene& scene);

/// The plant of the scene without commands, with the floor along its inputs. Errors:
/// std::runtime_error if it cannot go on.
Run plant_run(Scene scene, const Eigen::MatrixXd& floor, double tolerance);

}  // namespace stillframe::simbody

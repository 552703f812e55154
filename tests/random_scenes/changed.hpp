#pragma once

#include <Eigen/Core>

#include "core/mechanics/scene/scene.hpp"
#include "tests/random_scenes/answers.hpp"
#include "tests/random_scenes/generator/draws.hpp"

// The same thing, told otherwise.
namespace stillframe::random_scenes {

/// Turned by Q and then shifted by t (m), with all its directions.
Scene moved(Scene scene, const Eigen::Matrix3d& Q, const Eigen::Vector3d& t);
/// In another order, with other names, trusses from their other end.
Scene renumbered(Scene scene, Draws& draws);
Scene in_units(Scene scene, const Units& units);

}  // namespace stillframe::random_scenes

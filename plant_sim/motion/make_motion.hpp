#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/mechanics/scene/rigid_bodies.hpp"
#include "plant_sim/motion/motion.hpp"

namespace stillframe {

/// Which method moves a plant, and why.
struct MotionChoice {
  PlantMethod method = PlantMethod::exponential;
  std::string reason;
};

/// The method that the scene states, or for `auto` the one that docs/speed_against_error.md found
/// cheapest for such a scene:
///   - the exponential method, where the legs' forces are constant or decay by one exponential
///     while a command stands, and the model has at most 60 dofs; and while motion is large, by the
///     stiffness of the scene, the explicit method of order 5 or collocation in nodal coordinates
///     (AdaptiveMotion); a frame that make_motion finds to be too stiff for it, over a hundred
///     radians of the fastest mode in a part, goes by the nodal one throughout;
///   - collocation in nodal coordinates, where it has more dofs or forces bend within a sample;
///   - beside an operating point that moves, which make_motion finds, the exponential or the
///     explicit method in its stead.
/// Errors: InputError if the stated method cannot do what the scene asks for.
MotionChoice choose_method(const Scene& scene, const Model& model, const Drive& drive);

/// A plant at the operating point of a merged scene. choice: of choose_method; it says nodal
/// afterwards where the scene was found to be too stiff for another, and another where its
/// operating point moves. model: made from merged.scene; outlives the motion. durations: of the
/// parts of a sample, s. Errors: InputError as choose_method, and for small motion about an
/// operating point that moves; Refusal as nominal_motion.
std::unique_ptr<Motion> make_motion(const MergedScene& merged, const Model& model,
                                    MotionChoice& choice, const Drive& drive,
                                    const std::vector<double>& durations);

}  // namespace stillframe

#pragma once

#include "core/control/fitting/rig_fit.hpp"

namespace stillframe::fitting {

/// A planar frame on three legs, damped but for one, with accelerometers of its own: what is asked
/// of it with all parameters that such a scene has, 20 of them.
FitQuestion small_frame_question();
std::string small_frame_text();

/// The same of a scene.
FitQuestion question_of(const Scene& scene, const SceneUncertainty& uncertainty);
SceneUncertainty everything_by(double part);

}  // namespace stillframe::fitting

#pragma once

#include "bench/large_motion/mechanism.hpp"
#include "core/mechanics/scene/scene.hpp"

namespace stillframe::race {

/// A scene of rigid beams, hinges that follow each other, trusses and masses, or of one body on
/// trusses whose feet the inputs move, as a mechanism. The nodes of prescribed motion are the base.
/// Errors: std::invalid_argument of a body without mass.
Mechanism mechanism_of(const Scene& scene);

}  // namespace stillframe::race

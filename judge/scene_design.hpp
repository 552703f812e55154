#pragma once

#include "judge/loop_design.hpp"

namespace stillframe::judge {

/// The design of a scene that was not read from a file, or was changed since. Errors: as
/// make_loop_design of a file.
LoopDesign make_loop_design(Scene scene);

}  // namespace stillframe::judge

#pragma once

#include "core/mechanics/scene/scene.hpp"

namespace stillframe::tools {

/// Says on standard error where lengths of a scene read like millimetres: an element of 20 m or
/// more, of which frames that stand on legs have none.
void hint_at_units(const Scene& scene);

}  // namespace stillframe::tools

#pragma once

#include "core/mechanics/scene/scene.hpp"

namespace stillframe::tools {

/// Frames that stand on legs have no part of that length.
inline constexpr double longest_likely_m = 20;

/// Says on standard error where lengths of a scene read like millimetres: an element of that
/// length or more.
void hint_at_units(const Scene& scene);

}  // namespace stillframe::tools

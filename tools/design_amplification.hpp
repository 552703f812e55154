#pragma once

#include <string>
#include <vector>

#include "core/control/loop_settings.hpp"

namespace stillframe::tools {

/// In words, where from the target up to half the sample rate the controlled frame moves more than
/// the passive one: where its law does so without sampling, and where sampling adds it. Of a stable
/// loop.
std::vector<std::string> amplification_warnings(const LoopSettings& settings, double target_hz);

}  // namespace stillframe::tools

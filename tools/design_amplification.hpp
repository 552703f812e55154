#pragma once

#include "core/control/loop_settings.hpp"
#include "tools/remarks.hpp"

namespace stillframe::tools {

/// In words, where from the target up to half the sample rate the controlled frame moves more than
/// the passive one: where its law does so without sampling, and where sampling adds it. That is a
/// note where a twentieth of the floor is left at most: every loop has such a band, as what is won
/// below has to be paid (the integral of log |S|). Of a stable loop.
Remarks amplification(const LoopSettings& settings, double target_hz);

}  // namespace stillframe::tools

#pragma once

#include "controller/background.hpp"

namespace stillframe::controller {

/// From now on all that is logged goes to standard error in the background: a terminal that was
/// stopped, or a full pipe, holds up nobody. Lines that found no room are counted, and told once
/// the terminal takes lines again. background outlives the logging. Set-up.
void log_in_background(const char* name, Background& background);

}  // namespace stillframe::controller

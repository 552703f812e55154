#pragma once

#include <string>

#include "core/control/robustness/monte_carlo.hpp"

namespace stillframe::tools {

/// What --shard I/N asks for, all of it where it is empty. Errors: InputError.
robustness::Shard parse_shard(const std::string& text);

}  // namespace stillframe::tools

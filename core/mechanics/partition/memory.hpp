#pragma once

#include <string>

namespace stillframe {

/// Refuses a scene whose dense matrices of so many numbers do not fit into this machine, before
/// they are asked for. Errors: InputError at `place` saying what they would take.
void require_memory(double numbers, const std::string& place, const std::string& of_what);

}  // namespace stillframe

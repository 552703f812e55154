#pragma once

#include <string>

#include "core/linear/instruments.hpp"
#include "core/yaml/reader.hpp"

namespace stillframe {

/// Reads a block of instruments, as it stands in scenes and in gains files. Errors: InputError.
Instruments read_instruments(const YamlReader& block);

}  // namespace stillframe

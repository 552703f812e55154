#pragma once

#include <string>

#include "core/systems/instruments.hpp"
#include "core/yaml/reader.hpp"

namespace stillframe {

/// Reads a block of instruments as it stands in gains files: the linear part. Errors: InputError.
Instruments read_instruments(const YamlReader& block);

/// Reads a block of instruments as it stands in scenes; n_legs: how many numbers a list has that
/// goes leg by leg, negative if that is open. Errors: InputError.
Instruments read_scene_instruments(const YamlReader& block, int n_legs);

}  // namespace stillframe

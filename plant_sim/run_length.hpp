#pragma once

#include <cstdint>
#include <optional>

#include "core/mechanics/scene/scene.hpp"
#include "plant_sim/floor/floor_block.hpp"

namespace stillframe {

/// How many samples a run has: the duration asked for on the command line, else the scene's where
/// the floor is a recording, else all the floor has. Errors: InputError if the floor ends before
/// that, or it is not even one sample.
std::int64_t run_length(const Scene& scene, const floor::FloorSpec& spec,
                        std::int64_t floor_samples, std::optional<double> duration_s);

}  // namespace stillframe

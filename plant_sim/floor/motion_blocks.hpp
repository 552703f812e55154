#pragma once

#include <string>

#include "plant_sim/floor/floor_block.hpp"

// The kinds of floor block that are made from positions: they end where they say, and at rest. All
// throw InputError.
namespace stillframe::floor {

/// A block step, impact or sine_sweep.
CourseSpec read_course_block(const std::string& kind, const YamlReader& block,
                             double sample_rate_hz, const FloorInputs& inputs);

/// A block noise; inputs: number of floor inputs of the scene.
NoiseSpec read_noise_block(const YamlReader& block, double sample_rate_hz, Eigen::Index inputs);

/// The key vc, peterson or psd of a block: exactly one of them. Errors: InputError.
Density read_density(const YamlReader& block, double sample_rate_hz);

}  // namespace stillframe::floor

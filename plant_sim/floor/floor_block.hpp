#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "core/yaml/reader.hpp"
#include "plant_sim/floor/floor_source.hpp"
#include "plant_sim/floor/multisine.hpp"

namespace stillframe::floor {

/// Which column of a recording moves which world axis (0 x, 1 y, 2 z).
struct AxisMapping {
  std::string column;
  Eigen::Index axis;
};

/// A recorded floor: three translations.
struct RecordingSpec {
  YamlReader block;  ///< where it was read, for messages
  std::filesystem::path file;
  double scale = 1.0;         ///< the recording is multiplied by it
  double start_s = 0.0;       ///< s into the recording
  double high_pass_hz = 0.5;  ///< corner of the high-pass
  std::vector<AxisMapping> axes;
};

/// Independent noise on each floor input.
struct WhiteSpec {
  std::uint64_t seed = 1;
  double rms = 0.0;           ///< m/s^2, behind the high-pass
  double high_pass_hz = 0.5;  ///< corner of the high-pass
  std::int64_t n_samples = 0;
};

/// No motion.
struct StillSpec {
  std::int64_t n_samples = 0;
};

/// A floor block as it was read: everything that can be checked without opening a recording holds.
struct FloorSpec {
  double sample_rate_hz = 0.0;
  Eigen::Index inputs = 0;  ///< number of floor inputs of the scene
  std::variant<RecordingSpec, MultisinePlan, WhiteSpec, StillSpec> kind;
};

/// Reads a floor block: a map with exactly one of the keys recording, multisine, white, still.
/// sample_rate_hz is the control rate, inputs the number of floor inputs of the scene.
/// Errors: InputError for whatever is wrong in the block; std::invalid_argument unless
/// sample_rate_hz > 0 and inputs >= 1. Set-up.
FloorSpec read_floor_block(const YamlReader& block, double sample_rate_hz, Eigen::Index inputs);

/// The source that a spec describes; this is where a recording is read. The same spec makes the
/// same samples, bit for bit. Errors: InputError for a missing or unsound recording, a column that
/// it has not, a start too near its end. Set-up.
std::unique_ptr<FloorSource> make_floor_source(const FloorSpec& spec);

}  // namespace stillframe::floor

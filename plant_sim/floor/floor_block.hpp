#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "core/yaml/reader.hpp"
#include "plant_sim/floor/courses.hpp"
#include "plant_sim/floor/density.hpp"
#include "plant_sim/floor/floor_source.hpp"
#include "plant_sim/floor/multisine.hpp"
#include "plant_sim/floor/target.hpp"

namespace stillframe::floor {

/// Which column of a recording moves which axis (0 to 5, as axis_names).
struct AxisMapping {
  std::string column;
  Eigen::Index axis;
};

/// A recorded floor: three translations, or three rotations about a point.
struct RecordingSpec {
  YamlReader block;  ///< where it was read, for messages
  std::filesystem::path file;
  double scale = 1.0;         ///< the recording is multiplied by it
  double start_s = 0.0;       ///< s into the recording
  double high_pass_hz = 0.5;  ///< corner of the high-pass
  std::vector<AxisMapping> axes;
  Eigen::Vector3d about = Eigen::Vector3d::Zero();  ///< m, of the rotations
  bool ring_out = false;  ///< goes on until the high-pass has come to rest

  bool turns() const { return !axes.empty() && axes.front().axis >= 3; }
};

/// Independent noise on each floor input.
struct WhiteSpec {
  std::uint64_t seed = 1;
  double rms = 0.0;           ///< m/s^2, behind the high-pass
  double high_pass_hz = 0.5;  ///< corner of the high-pass
  std::int64_t n_samples = 0;
  bool ring_out = false;  ///< goes on until the high-pass has come to rest
};

/// Independent noise of a spectral density on each of some axes, or on each floor input.
struct NoiseSpec {
  Density density;
  std::uint64_t seed = 1;
  double high_pass_hz = 0.05;  ///< corner
  double period_s = 1000.0;    ///< the noise repeats after it, or somewhat later
  std::int64_t n_samples = 0;
  std::vector<Eigen::Index> axes;                   ///< 0 to 5; none: the inputs
  Eigen::Vector3d about = Eigen::Vector3d::Zero();  ///< m, of the rotations
};

/// A step, impact or sweep of one axis or input.
struct CourseSpec {
  Target target;
  std::variant<StepCourse, ImpactCourse, SweepCourse> course;
  std::int64_t begin = 0;      ///< sample with which it begins
  std::int64_t n_samples = 0;  ///< of the floor
};

/// No motion.
struct StillSpec {
  std::int64_t n_samples = 0;
};

struct FloorSpec;

/// Several floors at once, as long as the longest.
struct SumSpec {
  std::vector<FloorSpec> parts;
  std::vector<YamlReader> blocks;  ///< of the parts, for messages
};

/// A floor block as it was read: everything that can be checked without opening a recording holds.
struct FloorSpec {
  double sample_rate_hz = 0.0;
  Eigen::Index inputs = 0;  ///< number of floor inputs of the scene
  std::variant<RecordingSpec, MultisinePlan, WhiteSpec, NoiseSpec, CourseSpec, StillSpec, SumSpec>
      kind;

  /// Whether it is as long as somebody recorded: a recording, or a sum that has one.
  bool recorded() const;
};

/// Reads a floor block: a map with exactly one of the keys recording, multisine, white, noise,
/// step, impact, sine_sweep, still, sum. sample_rate_hz is the control rate, inputs the floor
/// inputs of the scene, by their number or their names; only by names can a block refer to one of
/// them. Errors: InputError for whatever is wrong in the block; std::invalid_argument unless
/// sample_rate_hz > 0 and there are inputs. Set-up.
FloorSpec read_floor_block(const YamlReader& block, double sample_rate_hz,
                           const FloorInputs& inputs);

/// The source that a spec describes; this is where a recording is read. The same spec makes the
/// same samples, bit for bit. Errors: InputError for a missing or unsound recording, a column that
/// it has not, a start too near its end, a multisine that ends before others of a sum. Set-up.
std::unique_ptr<FloorSource> make_floor_source(const FloorSpec& spec);

}  // namespace stillframe::floor

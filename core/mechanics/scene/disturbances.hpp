#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

// The block `disturbances` of a scene: forces on nodes that change with time, all in N.
namespace stillframe {

class YamlReader;
struct Scene;

/// From nothing to `height` along s(p) = p^3 (10 - 15 p + 6 p^2), at once without a rise time.
struct ForceStep {
  double at_s = 0, height = 0, rise_s = 0;
};

/// Half a period of a sine.
struct ForceImpact {
  double at_s = 0, peak = 0, width_s = 0;
};

/// A sine that begins at zero.
struct ForceSine {
  double at_s = 0, amplitude = 0, frequency_hz = 0;
};

/// A sine of changing frequency; see floor::SweepCourse.
struct ForceSweep {
  double at_s = 0, amplitude = 0, from_hz = 0, to_hz = 0, sweep_s = 0;
  bool linear = false;
};

/// Noise of a spectral density, straight between points in logarithms of both.
struct ForceNoise {
  double at_s = 0;
  std::vector<std::pair<double, double>> psd;  ///< Hz, N^2/Hz
  std::uint64_t seed = 1;
  double period_s = 1000;  ///< the noise repeats after it, or somewhat later
};

/// A column of a CSV file.
struct ForceRecording {
  double at_s = 0;
  std::filesystem::path file;
  std::string column;
  double scale = 1, start_s = 0;
};

/// A force on a node along a direction that is fixed in space.
struct SceneDisturbance {
  std::string name, node, place;
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();
  std::variant<ForceStep, ForceImpact, ForceSine, ForceSweep, ForceNoise, ForceRecording> force;
};

/// Reads the sequence `disturbances`, if the scene has one, after its nodes. Errors: InputError.
std::vector<SceneDisturbance> read_disturbances(const YamlReader& root, const Scene& scene);

/// The scene's text, in which recordings of forces and bodies are called by their full paths:
/// whoever reads it in another folder finds them. Errors: InputError at a relative path that is
/// written with escapes or by shorthand, in whose place no other can be written.
std::string text_with_full_paths(const Scene& scene);

}  // namespace stillframe

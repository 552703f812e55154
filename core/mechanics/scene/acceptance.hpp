#pragma once

#include <optional>
#include <string>
#include <vector>

// The block `accept` of a scene: what a run has to show so that it is accepted.
namespace stillframe {

class YamlReader;
struct Scene;

/// What is asked of one comparison in a range of frequencies. Ratios are of the active frame to the
/// floor below it, or to the passive frame on the same floor.
struct AxisAcceptance {
  std::string axis = {};                       ///< the name of a comparison
  double from_hz = 1, to_hz = 80;              ///< Hz
  std::optional<double> rms_of_floor = {};     ///< ratio of rms accelerations
  std::optional<double> rms_of_passive = {};   ///< the same to the passive frame
  std::optional<double> band_of_floor = {};    ///< the largest ratio of a one-third-octave band
  std::optional<double> band_of_passive = {};  ///< the same to the passive frame
  std::optional<std::string> vibration_class = {};  ///< VC-A ... VC-G, of 1 to 80 Hz
};

/// What a scene asks for; what it does not name is asked for as report/verdict/acceptance.hpp says.
struct SceneAcceptance {
  std::vector<AxisAcceptance> axes = {};  ///< a comparison may stand here several times
  /// Largest shares of the periods of the active loop, 0 to 1: those in which a force was limited,
  /// those whose measurement was lost, and those whose measurement the controller rejected.
  std::optional<double> limited_share = {}, lost_share = {}, discarded_share = {};
  std::optional<double> prediction_db = {};  ///< dB, largest distance from the prediction
};

/// Reads the block, after the comparisons and the controller of the scene. Errors: InputError.
SceneAcceptance read_acceptance(const YamlReader& block, const Scene& scene);

/// The block of a scene that was read, from its text; no model needs it. Set-up.
SceneAcceptance acceptance_of(const Scene& scene);

}  // namespace stillframe

#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "judge/closing.hpp"
#include "judge/commissioning.hpp"
#include "report/page/page_data.hpp"
#include "tools/json.hpp"

namespace stillframe::tools {

/// The loops that the gains of before and those of the updated scene make on what was found.
struct CommissionedLoops {
  double before = 0, after = 0;  ///< spectral radii
};

struct CommissionedFiles {
  std::optional<std::filesystem::path> scene, uncertainty, rig;
};

/// The loop as it ran.
struct ClosedOnRig {
  controller::ClosedRecording run;
  std::vector<judge::ClosedResponse> responses;
};

/// What was asked for.
struct HowCommissioned {
  std::string scene, played;  ///< files; played: by which scene, empty: on a rig
  std::string date;           ///< as it is to be read
  double force_n = 0, window_s = 0;
  int windows = 0;
};

/// Of a peak of a few thousand samples: noise alone makes it differ by a twentieth.
inline constexpr double most_shaken = 1.1;
/// Of each accelerometer by itself, those that read less than a tenth of what the loudest did
/// without the loop left alone: there a step on the floor is more than the drive. Sound loops, with
/// less force than the drive, read up to as much as without.
inline constexpr double most_shaken_axis = 2, heard_part = 0.1;

/// How far a commissioning came, and what it found.
struct Commissioning {
  std::string title;  ///< of the scene
  HowCommissioned how;
  controller::RigFile rig;  ///< whose channels the loop ran on
  std::vector<std::string> legs;
  std::optional<judge::Commissioned> found;  ///< none: the scene was corrected before
  CommissionedFiles files;                   ///< that were written
  std::optional<CommissionedLoops> loops;
  std::optional<ClosedOnRig> closed;
  bool passed = false;

  bool is_fitted() const { return found && loops; }
  /// Accelerometers of the frame were read both with the loop and while it was driven without.
  bool has_both_peaks() const;
  /// Accelerometers that read more than most_shaken_axis times what they did without the loop.
  std::vector<std::size_t> shaken_axes() const;
  /// The closed loop shook the frame by more than most_shaken times what the drive without it did,
  /// or one of its axes, or nobody knows.
  bool is_shaken_harder() const;
  /// It did as predicted, and did not.
  bool is_closed_well() const;
};

Json to_json(const Commissioning& all);
void print_wiring(const Commissioning& all);
void print_parameters(const Commissioning& all);
void print_closed(const Commissioning& all);
/// All of it as a page. Set-up.
page::PageData page_of(const Commissioning& all);

}  // namespace stillframe::tools

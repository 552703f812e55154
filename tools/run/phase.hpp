#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "tools/run/run_directory.hpp"

namespace stillframe::tools {

/// What one run of plant, controller and logger needs to know.
struct PhaseOptions {
  std::filesystem::path scene, gains;
  std::optional<std::filesystem::path> floor;
  /// Of what scene, controller and floor name.
  std::filesystem::path scene_folder, controller_folder, floor_folder;
  std::optional<std::filesystem::path> controller;
  std::string mode, loop, lcm_url;
  std::int64_t run_id = 0;
  std::optional<double> duration_s;
  double sample_rate_hz = 0, timeout_s = 10;
  std::optional<std::filesystem::path> policy;  ///< of the controller, docs/safety.md
  std::optional<std::string> realtime;          ///< off, best_effort or enforce
};

/// How it went: exit code 0, or the code and reason of the process that ended it.
struct PhaseResult {
  int exit_code = 0;
  std::string reason;
  std::string controller_line;  ///< what the controller printed at the end
};

/// Starts lcm-logger, stillframe-controller and stillframe-plant, waits for the logger before the
/// first message, shows progress, and stops all of them at the end, on Ctrl-C and when one of them
/// dies. The log is LOOP.lcm, what they say is LOOP.txt, and in wall-clock mode the controller's
/// histograms are LOOP_timing.json in the run directory, its flight records beside them. Errors:
/// InputError if a program cannot be started or LCM cannot be opened.
PhaseResult run_phase(const PhaseOptions& options, const RunDirectory& directory);

}  // namespace stillframe::tools

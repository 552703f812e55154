#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "controller/gains.hpp"
#include "controller/rig/driver.hpp"
#include "controller/rig/scaled_io.hpp"
#include "stillframe_msgs/run_info_t.hpp"

namespace stillframe::controller {

/// What a rig file says of sensors and actuators; docs/hardware.md. All of it has a default: the
/// channels of a driver one after the other, in SI units.
struct RigFile {
  std::string title;
  std::string driver;                          ///< empty: none is named
  std::map<std::string, std::string> options;  ///< of the driver
  std::filesystem::path folder;                ///< of the file
  std::string scene;                           ///< path of the scene it names, empty without
  std::string scene_text;                      ///< of that scene
  Channels channels;
  std::vector<std::string> floor, frame;  ///< names of these channels
  /// How messages call what stands in the file, by its name: "rig.yaml:9:3: frame.lens_x".
  std::map<std::string, std::string> places;

  /// That of a name; the name itself where it stands in no file.
  std::string place_of(const std::string& name) const;
  DriverSetting setting(const Gains& gains) const;
};

/// The rig of a loop without a rig file.
RigFile default_rig(const Gains& gains);

/// Reads a rig file for the legs and the floor of these gains. Errors: InputError (missing file,
/// unknown key or leg, a leg that is left out, a channel that is used twice).
RigFile read_rig(const std::filesystem::path& path, const Gains& gains);

/// Takes the driver that --io names, if it names one. Errors: InputError where neither does.
void choose_driver(RigFile& rig, const std::string& io);

/// As a rig file, with all channels written out. driver: its name.
std::string to_yaml(const RigFile& rig, const Gains& gains);

/// The run_info_t of a run on a rig. gains_text: of the gains file; n_samples: 0 if it has no end;
/// version: of the program.
stillframe_msgs::run_info_t describe_rig(const RigFile& rig, const Gains& gains,
                                         const std::string& gains_text, std::int64_t run_id,
                                         std::int64_t n_samples, const std::string& version);

}  // namespace stillframe::controller

#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "controller/background.hpp"
#include "controller/policy.hpp"

namespace stillframe::controller {

/// The fault that only a person ends. It outlives the session, the plant and, in a file, this
/// process. Set-up.
class Latch {
 public:
  using Warn = std::function<void(const std::string&)>;

  /// Reads the file if there is one, or clears it at once; without a name nothing outlives the
  /// process. disk writes it later, and outlives the latch. Errors: InputError if the file does not
  /// name a fault, or it cannot be found out whether there is one.
  Latch(std::filesystem::path file, Background& disk, Warn warn, bool clear_at_once);

  Fault fault() const { return fault_; }  ///< none: nothing is latched
  /// The name of the leg that began it, as fault_in_words has it; empty: of none, or not known.
  const std::string& leg() const { return leg_; }
  const std::filesystem::path& file() const { return file_; }
  void hold(Fault fault, std::int64_t run_id, const std::string& leg = "");
  /// A person says that the cause is mended.
  void clear();

 private:
  std::filesystem::path file_;
  Background& disk_;
  Warn warn_;
  Fault fault_ = Fault::none;
  std::string leg_;
};

/// Where the latch of a frame is kept if nobody says: $XDG_STATE_HOME/stillframe or
/// ~/.local/state/stillframe, a file for each title of a scene, because a scene that is edited is
/// still that of the frame which is broken. Empty if the user has no such folder.
std::filesystem::path default_latch_file(const std::string& scene_title);

}  // namespace stillframe::controller

#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "core/mechanics/scene/scene.hpp"
#include "plant_sim/floor/floor_block.hpp"

namespace stillframe::tools {

/// The files that a run reads again in each of its phases. Were one of them changed in between, its
/// folder would show what did not run.
class RunFiles {
 public:
  /// Begins with the recordings of both, as they are now.
  RunFiles(const Scene& scene, const floor::FloorSpec& floor);
  /// A file that holds this text.
  void add(const std::filesystem::path& file, const std::string& text);
  /// Of what is in all of them.
  std::string hash() const;
  /// Which one is no longer what it was, in a sentence; empty: none.
  std::string changed() const;

 private:
  void add_recordings(const floor::FloorSpec& floor);
  std::vector<std::pair<std::filesystem::path, std::string>> files_;  ///< with their hashes
};

}  // namespace stillframe::tools

#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace stillframe::tools {

/// A file of a command line, or nothing where its option was not given. name: as messages call it,
/// "the log" if it is read, its option if it is written.
struct GivenFile {
  std::string name;
  std::optional<std::filesystem::path> path;
};

/// What is written takes the place neither of what is read nor of something else that is written,
/// and has a folder that takes it; called before anything is computed or measured. Devices and
/// pipes may be given as often as one likes. Errors: InputError, also for an empty path to write
/// to.
void require_own_places(const std::vector<GivenFile>& read, const std::vector<GivenFile>& written);

}  // namespace stillframe::tools

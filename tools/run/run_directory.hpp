#pragma once

#include <filesystem>
#include <string>

namespace stillframe::tools {

/// The folder of a run. While the run goes on it is called NAME.incomplete; only what has come to a
/// good end is called NAME, so that nobody takes half a run for a whole one.
class RunDirectory {
 public:
  /// Errors: InputError if NAME is there already or cannot be made. An older NAME.incomplete is
  /// replaced.
  explicit RunDirectory(const std::filesystem::path& name);
  /// Leaves a file FAILED.txt behind if finish() has not been called.
  ~RunDirectory();
  RunDirectory(const RunDirectory&) = delete;
  RunDirectory& operator=(const RunDirectory&) = delete;

  std::filesystem::path operator/(const std::string& file) const { return present_ / file; }
  const std::filesystem::path& present() const { return present_; }
  const std::filesystem::path& name() const { return name_; }
  void write(const std::string& file, const std::string& text) const;
  /// What FAILED.txt will say.
  void set_failure(const std::string& reason) { failure_ = reason; }
  /// Gives the folder its name.
  void finish();

 private:
  std::filesystem::path name_, present_;
  std::string failure_ = "stopped before the run had ended";
  bool finished_ = false;
};

}  // namespace stillframe::tools

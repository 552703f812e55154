#pragma once

#include <filesystem>
#include <string>

namespace stillframe::tools {

/// The folder of a run. While the run goes on it is called NAME.incomplete; only what has come to a
/// good end is called NAME, so that nobody takes half a run for a whole one. It is a run's own:
/// made by it, of no other, and nothing that was there before is ever written to or removed.
class RunDirectory {
 public:
  /// What to do if NAME or NAME.incomplete is there: refuse, or take the first of NAME-2, NAME-3,
  /// ... that is not.
  enum class Taken { refuse, count_on };
  /// Errors: InputError if the folder is there already, or cannot be made.
  explicit RunDirectory(const std::filesystem::path& name, Taken taken = Taken::refuse);
  /// Leaves a file FAILED.txt behind if finish() has not been called.
  ~RunDirectory();
  RunDirectory(const RunDirectory&) = delete;
  RunDirectory& operator=(const RunDirectory&) = delete;

  std::filesystem::path operator/(const std::string& file) const { return present_ / file; }
  const std::filesystem::path& present() const { return present_; }
  const std::filesystem::path& name() const { return name_; }
  /// Errors: those of WholeFile.
  void write(const std::string& file, const std::string& text) const;
  /// What FAILED.txt will say.
  void set_failure(const std::string& reason) { failure_ = reason; }
  /// Gives the folder its name. Errors: OutputError, and the folder keeps the name it has.
  void finish();

 private:
  /// Makes the folder; answers what is in the way if anything is.
  std::filesystem::path claim(const std::string& name);
  std::filesystem::path name_, present_;
  std::string failure_ = "stopped before the run had ended";
  bool finished_ = true;
};

}  // namespace stillframe::tools

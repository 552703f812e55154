#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace stillframe::tools {

/// A process of a run, started and ended by its id. It gets a process group of its own, so that
/// Ctrl-C reaches only the program that started it, and a SIGTERM if that program dies.
class ChildProcess {
 public:
  /// name stands for the process in messages. Its standard output goes to a pipe that read_lines()
  /// empties, its standard error to `error_file`. Errors: InputError if the program cannot be
  /// started.
  ChildProcess(std::string name, const std::vector<std::string>& command,
               const std::filesystem::path& error_file);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  const std::string& name() const { return name_; }
  /// Exit code once the process has ended (128 + the signal's number if one ended it), nothing
  /// before.
  std::optional<int> exit_code();
  /// Whole lines that have come on its standard output since the last call. Does not block.
  std::vector<std::string> read_lines();
  /// Waits up to timeout_s for the end.
  std::optional<int> wait(double timeout_s);
  /// SIGTERM, and SIGKILL if it has not ended 2 s later.
  void stop();

 private:
  std::string name_;
  pid_t pid_ = -1;
  int output_ = -1;
  std::string pending_;
  std::optional<int> exit_code_;
};

/// The folder in which the running program stands, where its sister programs are.
std::filesystem::path program_folder();

}  // namespace stillframe::tools

#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace stillframe::faults {

/// A program under test, by its id: started, stopped, killed, waited for with a limit. What it says
/// goes to a file. Killed if it is left before it has ended.
class Process {
 public:
  /// priority: of SCHED_FIFO if the system allows it; none: an ordinary process.
  /// Errors: std::runtime_error if it cannot be started.
  Process(const std::vector<std::string>& command, std::filesystem::path said,
          std::optional<int> priority = {});
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  pid_t pid() const { return pid_; }
  /// Sends a signal, unless the process has ended and was waited for.
  void signal(int number) const;
  /// SIGSTOP; returns once it stands still.
  void suspend() const;
  /// SIGKILL; returns once it is gone.
  void kill();
  /// The exit code, minus the signal that ended it, or nothing if it still runs after limit_s.
  std::optional<int> wait(double limit_s);
  /// All that it and those before it wrote to the file.
  std::string said() const;

 private:
  pid_t pid_ = -1;
  int pid_fd_ = -1;
  std::filesystem::path said_;
};

}  // namespace stillframe::faults

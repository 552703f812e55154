#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace stillframe::test {

/// A program run by a test, with what it prints; killed if the test leaves before it has ended.
class ChildProcess {
 public:
  /// arguments[0] is the program, looked up in PATH. It begins as any program does, whatever this
  /// one is; at a real-time priority if one is given and allowed. Errors: std::runtime_error.
  explicit ChildProcess(std::vector<std::string> arguments, int priority = 0);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  pid_t pid() const { return pid_; }
  void signal(int number) const;
  /// Stops it with SIGSTOP and returns once it stands still; SIGCONT lets it go on.
  void suspend() const;
  /// Waits for the end; the exit code, or minus the signal that ended it.
  int wait();
  /// What it printed, once it has ended.
  const std::string& out() const { return out_; }
  const std::string& err() const { return err_; }

 private:
  pid_t pid_ = -1;
  int out_fd_ = -1, err_fd_ = -1;
  std::string out_, err_;
};

}  // namespace stillframe::test

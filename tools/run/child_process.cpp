#include "tools/run/child_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>

#include "core/errors/input_error.hpp"
#include "msgs/clock.hpp"

namespace stillframe::tools {

namespace {

/// Between fork and exec only calls that are safe there; answers to the parent by the exit code
/// 127.
[[noreturn]] void become(char* const* arguments, int output, int error) {
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  dup2(output, STDOUT_FILENO);
  dup2(error, STDERR_FILENO);
  execvp(arguments[0], arguments);
  _exit(127);
}

}  // namespace

ChildProcess::ChildProcess(std::string name, const std::vector<std::string>& command,
                           const std::filesystem::path& error_file)
    : name_(std::move(name)) {
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  int pipe_ends[2];
  const int error = open(error_file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (error < 0 || pipe2(pipe_ends, O_CLOEXEC) != 0) {
    throw InputError(error_file.string() + ": cannot be written, " + name_ + " is not started");
  }
  // The reading end alone: a child whose pipe is full has to wait, not to lose what it writes.
  fcntl(pipe_ends[0], F_SETFL, O_NONBLOCK);
  pid_ = fork();
  if (pid_ == 0) become(arguments.data(), pipe_ends[1], error);
  close(pipe_ends[1]);
  close(error);
  output_ = pipe_ends[0];
  if (pid_ < 0) throw InputError("no process can be started for " + name_);
}

ChildProcess::~ChildProcess() {
  stop();
  if (output_ >= 0) close(output_);
}

std::optional<int> ChildProcess::exit_code() {
  int status = 0;
  if (!exit_code_ && pid_ > 0 && waitpid(pid_, &status, WNOHANG) == pid_) {
    exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  return exit_code_;
}

std::vector<std::string> ChildProcess::read_lines() {
  char buffer[4096];
  for (ssize_t n; (n = read(output_, buffer, sizeof buffer)) > 0;) {
    pending_.append(buffer, static_cast<size_t>(n));
  }
  std::vector<std::string> lines;
  for (size_t end; (end = pending_.find('\n')) != std::string::npos;) {
    lines.push_back(pending_.substr(0, end));
    pending_.erase(0, end + 1);
  }
  return lines;
}

std::optional<int> ChildProcess::wait(double timeout_s) {
  const std::int64_t until = monotonic_ns() + static_cast<std::int64_t>(timeout_s * 1e9);
  while (!exit_code() && monotonic_ns() < until) sleep_until(monotonic_ns() + 10'000'000);
  return exit_code_;
}

void ChildProcess::stop() {
  if (pid_ <= 0 || exit_code()) return;
  kill(pid_, SIGTERM);
  if (wait(2.0)) return;
  kill(pid_, SIGKILL);
  wait(2.0);
}

std::filesystem::path program_folder() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path();
}

}  // namespace stillframe::tools

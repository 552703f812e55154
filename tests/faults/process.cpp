#include "tests/faults/process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <spawn.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <utility>

extern char** environ;

namespace stillframe::faults {

namespace {

/// A child inherits the scheduling of the thread that starts it.
class Scheduling {
 public:
  explicit Scheduling(std::optional<int> priority) {
    if (!priority) return;
    pthread_getschedparam(pthread_self(), &policy_, &before_);
    const sched_param wanted{.sched_priority = *priority};
    changed_ = pthread_setschedparam(pthread_self(), SCHED_FIFO, &wanted) == 0;
  }
  ~Scheduling() {
    if (changed_) pthread_setschedparam(pthread_self(), policy_, &before_);
  }
  Scheduling(const Scheduling&) = delete;
  Scheduling& operator=(const Scheduling&) = delete;

 private:
  int policy_ = SCHED_OTHER;
  sched_param before_{};
  bool changed_ = false;
};

}  // namespace

Process::Process(const std::vector<std::string>& command, std::filesystem::path said,
                 std::optional<int> priority)
    : said_(std::move(said)) {
  std::vector<std::string> arguments = command;
  std::vector<char*> argv;
  for (auto& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, said_.c_str(),
                                   O_WRONLY | O_CREAT | O_APPEND, 0644);
  posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  int status = 0;
  {
    const Scheduling scheduling(priority);
    status = posix_spawnp(&pid_, argv[0], &actions, nullptr, argv.data(), environ);
  }
  posix_spawn_file_actions_destroy(&actions);
  if (status != 0) throw std::runtime_error("cannot start " + command[0]);
  pid_fd_ = static_cast<int>(syscall(SYS_pidfd_open, pid_, 0));
  if (pid_fd_ < 0) {
    kill();
    throw std::runtime_error("pidfd_open is not there: Linux 5.3 or later is needed");
  }
}

Process::~Process() {
  kill();
  if (pid_fd_ >= 0) close(pid_fd_);
}

void Process::signal(int number) const {
  if (pid_ > 0) ::kill(pid_, number);
}

void Process::suspend() const {
  signal(SIGSTOP);
  siginfo_t info;
  if (pid_ > 0) waitid(P_PID, static_cast<id_t>(pid_), &info, WSTOPPED | WEXITED | WNOWAIT);
}

void Process::kill() {
  if (pid_ <= 0) return;
  signal(SIGKILL);
  waitpid(pid_, nullptr, 0);
  pid_ = -1;
}

std::optional<int> Process::wait(double limit_s) {
  if (pid_ <= 0) return std::nullopt;
  pollfd ended{.fd = pid_fd_, .events = POLLIN, .revents = 0};
  if (poll(&ended, 1, static_cast<int>(limit_s * 1e3)) <= 0) return std::nullopt;
  int status = 0;
  waitpid(pid_, &status, 0);
  pid_ = -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

std::string Process::said() const {
  std::ifstream stream(said_);
  std::stringstream text;
  text << stream.rdbuf();
  return text.str();
}

}  // namespace stillframe::faults

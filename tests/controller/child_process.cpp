#include "tests/controller/child_process.hpp"

#include <fcntl.h>
#include <sched.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <stdexcept>

extern char** environ;

namespace stillframe::test {

namespace {

// Files in memory, and not pipes: a child never blocks on what nobody reads.
std::string contents(int fd) {
  std::string text(static_cast<size_t>(lseek(fd, 0, SEEK_END)), '\0');
  const auto size = pread(fd, text.data(), text.size(), 0);
  text.resize(size < 0 ? 0 : static_cast<size_t>(size));
  close(fd);
  return text;
}

}  // namespace

ChildProcess::ChildProcess(std::vector<std::string> arguments, int priority)
    : out_fd_(memfd_create("out", MFD_CLOEXEC)), err_fd_(memfd_create("err", MFD_CLOEXEC)) {
  std::vector<char*> argv;
  for (auto& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, out_fd_, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, err_fd_, STDERR_FILENO);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSCHEDULER);
  const auto spawn = [&](int policy, int its_priority) {
    const sched_param parameters{.sched_priority = its_priority};
    posix_spawnattr_setschedpolicy(&attributes, policy);
    posix_spawnattr_setschedparam(&attributes, &parameters);
    return posix_spawnp(&pid_, argv[0], &actions, &attributes, argv.data(), environ);
  };
  int status = priority > 0 ? spawn(SCHED_FIFO, priority) : -1;
  if (status != 0) status = spawn(SCHED_OTHER, 0);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (status != 0) throw std::runtime_error("cannot start " + arguments[0]);
}

ChildProcess::~ChildProcess() {
  if (pid_ <= 0) return;
  kill(pid_, SIGKILL);
  wait();
}

void ChildProcess::signal(int number) const {
  // -1 would mean every process there is.
  if (pid_ > 0) kill(pid_, number);
}

void ChildProcess::suspend() const {
  signal(SIGSTOP);
  int status = 0;
  waitpid(pid_, &status, WUNTRACED);
}

int ChildProcess::wait() {
  int status = 0;
  waitpid(pid_, &status, 0);
  pid_ = -1;
  out_ = contents(out_fd_);
  err_ = contents(err_fd_);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

}  // namespace stillframe::test

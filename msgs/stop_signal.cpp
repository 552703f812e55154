#include "msgs/stop_signal.hpp"

#include <cerrno>
#include <csignal>
#include <initializer_list>
#include <system_error>

namespace stillframe {

namespace {

volatile std::sig_atomic_t stop_flag = 0;

void on_signal(int) { stop_flag = 1; }

void handle(std::initializer_list<int> signals, void (*handler)(int)) {
  struct sigaction action {};
  action.sa_handler = handler;  // without SA_RESTART, so that sleeps and polls end at once
  sigemptyset(&action.sa_mask);
  for (const int signal : signals) {
    if (sigaction(signal, &action, nullptr) != 0) {
      throw std::system_error(errno, std::generic_category(), "sigaction");
    }
  }
}

}  // namespace

void catch_stop_signals() {
  handle({SIGINT, SIGTERM}, on_signal);
  struct sigaction before {};
  if (sigaction(SIGHUP, nullptr, &before) == 0 && before.sa_handler == SIG_IGN) return;
  handle({SIGHUP}, on_signal);
}

void ignore_write_signals() { handle({SIGPIPE, SIGXFSZ}, SIG_IGN); }

bool stop_requested() noexcept { return stop_flag != 0; }

}  // namespace stillframe

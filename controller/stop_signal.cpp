#include "controller/stop_signal.hpp"

#include <cerrno>
#include <csignal>
#include <system_error>

namespace stillframe::controller {

namespace {

volatile std::sig_atomic_t stop_flag = 0;

void on_signal(int) { stop_flag = 1; }

}  // namespace

void catch_stop_signals() {
  struct sigaction action {};
  action.sa_handler = on_signal;  // without SA_RESTART, so that sleeps and polls end at once
  sigemptyset(&action.sa_mask);
  for (const int signal : {SIGINT, SIGTERM}) {
    if (sigaction(signal, &action, nullptr) != 0) {
      throw std::system_error(errno, std::generic_category(), "sigaction");
    }
  }
}

bool stop_requested() noexcept { return stop_flag != 0; }

}  // namespace stillframe::controller

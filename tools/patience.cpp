#include "tools/patience.hpp"

#include <unistd.h>

#include <cstdio>

namespace stillframe::tools {

using namespace std::chrono_literals;

Patience::Patience(std::string what) : what_(std::move(what)) {
  if (isatty(STDERR_FILENO) == 0) return;
  watcher_ = std::jthread([this](const std::stop_token& stop) { watch(stop); });
}

Patience::~Patience() {
  watcher_.request_stop();
  if (watcher_.joinable()) watcher_.join();
}

void Patience::now(std::string what, double percent) {
  const std::lock_guard lock(mutex_);
  what_ = std::move(what);
  percent_ = percent;
}

void Patience::watch(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  bool shown = false;
  auto next = began_ + 2s;
  while (!wake_.wait_until(lock, stop, next, [] { return false; }) && !stop.stop_requested()) {
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - began_;
    std::fprintf(stderr, "\r\033[K%s", what_.c_str());
    if (percent_ >= 0) std::fprintf(stderr, ", %.0f %%", percent_);
    std::fprintf(stderr, ", %.0f s", spent.count());
    std::fflush(stderr);
    shown = true;
    next += 500ms;
  }
  if (shown) std::fputs("\r\033[K", stderr);
}

}  // namespace stillframe::tools

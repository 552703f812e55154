#include "tools/run/progress_bar.hpp"

#include <unistd.h>

#include <cstdio>

#include "msgs/clock.hpp"

namespace stillframe::tools {

ProgressBar::ProgressBar(std::string what, double sample_rate_hz)
    : what_(std::move(what)),
      sample_rate_hz_(sample_rate_hz),
      began_ns_(monotonic_ns()),
      terminal_(isatty(STDERR_FILENO) != 0) {}

ProgressBar::~ProgressBar() {
  if (shown_) std::fputs("\r\033[K", stderr);
}

void ProgressBar::show(std::int64_t done, std::int64_t all) {
  if (!terminal_ || all <= 0) return;
  constexpr int width = 30;
  const int filled = static_cast<int>(width * done / all);
  const double plant_s = static_cast<double>(done) / sample_rate_hz_;
  const double wall_s = static_cast<double>(monotonic_ns() - began_ns_) * 1e-9;
  std::fprintf(stderr, "\r\033[K%s [%s%s] %.1f of %.1f s, %.1f times real time", what_.c_str(),
               std::string(static_cast<size_t>(filled), '#').c_str(),
               std::string(static_cast<size_t>(width - filled), '.').c_str(), plant_s,
               static_cast<double>(all) / sample_rate_hz_, wall_s > 0 ? plant_s / wall_s : 0.0);
  shown_ = true;
}

}  // namespace stillframe::tools

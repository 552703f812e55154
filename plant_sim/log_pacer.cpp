#include "plant_sim/log_pacer.hpp"

#include <sys/stat.h>

#include "msgs/clock.hpp"
#include "msgs/stop_signal.hpp"

namespace stillframe {

namespace {

// lcm-logger drops what comes while 30 messages wait in its queue; these leave room for those that
// are on their way.
constexpr std::int64_t messages_behind = 16, most_behind = 24;
// It writes by blocks, if messages are large enough that one fills before they are too many, or
// else what a flush or a nudge makes it write.
constexpr std::int64_t block_bytes = 4096, messages_beside_block = 6;
// Event header of an LCM log: sync word, number, time, two lengths.
constexpr std::int64_t header_bytes = 28;
constexpr std::int64_t pause_ns = 50'000, nudge_ns = 1'500'000;
constexpr std::int64_t answer_ns = 200'000'000, settle_ns = 20'000'000;
constexpr std::int64_t patience_ns = 5'000'000'000;

}  // namespace

LogPacer::LogPacer(std::filesystem::path log, std::function<void()> nudge)
    : log_(std::move(log)), nudge_(std::move(nudge)) {}

std::int64_t LogPacer::size() const noexcept {
  struct stat status {};
  return stat(log_.c_str(), &status) == 0 ? status.st_size : 0;
}

bool LogPacer::begin() {
  const std::int64_t begin = monotonic_ns();
  // The log has caught up once a nudge makes it grow by that nudge alone; an older message that had
  // not been written yet would count as one of the run, and the run be let go too far ahead.
  while (monotonic_ns() - begin < patience_ns && !stop_requested()) {
    const std::int64_t before = size();
    sent_ = 0;
    nudge_();
    const std::int64_t asked = monotonic_ns();
    while (size() < before + sent_ && monotonic_ns() - asked < answer_ns) {
      sleep_until(monotonic_ns() + pause_ns);
    }
    sleep_until(monotonic_ns() + settle_ns);
    base_ = size();
    if (base_ == before + sent_) {
      sent_ = messages_ = 0;
      return true;
    }
  }
  return false;
}

void LogPacer::sent(std::size_t bytes, std::size_t channel_length) noexcept {
  sent_ += header_bytes + static_cast<std::int64_t>(bytes + channel_length);
  ++messages_;
}

bool LogPacer::wait() noexcept {
  const std::int64_t begin = monotonic_ns();
  // A logger that does not get the processor would lose its queue to nudges in even steps: doubled
  // steps make eleven of them before the patience is out.
  std::int64_t nudged = begin, pause = nudge_ns;
  if (messages_ == 0) return true;
  const std::int64_t mean = sent_ / messages_,
                     by_blocks = block_bytes / mean + messages_beside_block;
  const std::int64_t behind = mean * (by_blocks <= most_behind ? by_blocks : messages_behind);
  while (sent_ - (size() - base_) > behind) {
    const std::int64_t now = monotonic_ns();
    if (now - begin > patience_ns || stop_requested()) return false;
    if (now - nudged > pause) {
      nudge_();
      nudged = now;
      pause *= 2;
    }
    sleep_until(now + pause_ns);
  }
  return true;
}

}  // namespace stillframe

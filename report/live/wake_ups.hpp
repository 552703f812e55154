#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

#include "report/live/wrapping.hpp"
#include "stillframe_msgs/loop_records_t.hpp"

namespace stillframe::live {

/// How late a wall-clock loop woke up, and how long it computed, second by second as its records
/// came, over the last minute. Hot: noexcept, no allocation.
class WakeUps {
 public:
  static constexpr std::int64_t n_seconds = 60;
  struct Worst {
    std::int64_t wake_up_ns = 0;  ///< past a deadline
    std::int64_t compute_ns = 0;  ///< from wake-up to the command
  };

  void take(const stillframe_msgs::loop_records_t& message, std::int64_t now_ns) noexcept {
    const std::int64_t number = now_ns / ns;
    Second& second = seconds_[at(number)];
    if (second.number != number) second = {.number = number, .worst = {}};
    any_ = any_ || !message.records.empty();
    for (const auto& record : message.records) {
      Worst& worst = second.worst;
      worst.wake_up_ns =
          std::max(worst.wake_up_ns, wrapping_difference(record.wake_up_ns, record.deadline_ns));
      worst.compute_ns =
          std::max(worst.compute_ns, wrapping_difference(record.computed_ns, record.wake_up_ns));
    }
  }

  bool any() const noexcept { return any_; }

  /// Of the second that was so many before that of now_ns; nothing if no record came in it.
  std::optional<Worst> ago(std::int64_t seconds, std::int64_t now_ns) const noexcept {
    const std::int64_t number = now_ns / ns - seconds;
    if (number < 0 || seconds_[at(number)].number != number) return std::nullopt;
    return seconds_[at(number)].worst;
  }

  /// Of the second of now_ns and so many before it; nothing if no record came in them.
  std::optional<Worst> since(std::int64_t seconds, std::int64_t now_ns) const noexcept {
    std::optional<Worst> worst;
    for (std::int64_t s = 0; s <= seconds; ++s) {
      const auto one = ago(s, now_ns);
      if (!one) continue;
      if (!worst) worst.emplace();
      worst->wake_up_ns = std::max(worst->wake_up_ns, one->wake_up_ns);
      worst->compute_ns = std::max(worst->compute_ns, one->compute_ns);
    }
    return worst;
  }

 private:
  struct Second {
    std::int64_t number = -1;
    Worst worst;
  };
  static constexpr std::int64_t ns = 1'000'000'000;

  static std::size_t at(std::int64_t number) noexcept {
    return static_cast<std::size_t>(number % n_seconds);
  }

  std::array<Second, n_seconds> seconds_{};
  bool any_ = false;
};

}  // namespace stillframe::live

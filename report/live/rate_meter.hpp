#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

namespace stillframe::live {

/// How many messages a second came lately, counted in slots of a quarter of a second over the last
/// two seconds. Times are on any clock that does not go back. Hot: noexcept, no allocation.
class RateMeter {
 public:
  void count(std::int64_t now_ns) noexcept {
    advance(now_ns);
    if (first_ns_ < 0) first_ns_ = now_ns;
    ++slots_[at(now_ns / slot_ns)];
    ++n_;
    last_ns_ = now_ns;
  }

  /// Messages a second, over the whole slots before now; over what there is before there are two
  /// seconds, 0 before a first whole slot.
  double per_s(std::int64_t now_ns) const noexcept {
    if (first_ns_ < 0) return 0;
    const std::int64_t now = now_ns / slot_ns;
    const std::int64_t from = std::max(now - n_slots + 1, first_ns_ / slot_ns + 1);
    if (from >= now) return 0;
    std::int64_t sum = 0;
    for (std::int64_t slot = from; slot < std::min(now, slot_ + 1); ++slot) {
      sum += slots_[at(slot)];
    }
    return static_cast<double>(sum) * 1e9 / (static_cast<double>(now - from) * slot_ns);
  }

  std::int64_t n() const noexcept { return n_; }
  /// Of the newest message; negative: none yet.
  std::int64_t last_ns() const noexcept { return last_ns_; }

 private:
  static constexpr std::int64_t slot_ns = 250'000'000, n_slots = 9;

  static std::size_t at(std::int64_t slot) noexcept {
    return static_cast<std::size_t>(slot % n_slots);
  }

  void advance(std::int64_t now_ns) noexcept {
    const std::int64_t slot = now_ns / slot_ns;
    for (std::int64_t i = std::max(slot_ + 1, slot - n_slots + 1); i <= slot; ++i)
      slots_[at(i)] = 0;
    slot_ = std::max(slot, slot_);
  }

  std::array<std::int64_t, n_slots> slots_{};
  std::int64_t slot_ = -1, first_ns_ = -1, last_ns_ = -1, n_ = 0;
};

}  // namespace stillframe::live

// The converters of a rig, here without the rig: stiff legs on a floor that moves at 3 Hz, and a
// clock that does not wait: it is at once 15 us past the time that is waited for, and every
// hundredth time 2.2 ms.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

class Cards {
 public:
  explicit Cards(std::size_t n_legs) : force_(n_legs) {}

  std::int64_t now_ns() const noexcept { return now_ns_; }
  void wait_until(std::int64_t time_ns) noexcept {
    now_ns_ = time_ns + (++n_waits_ % 100 == 0 ? 2'200'000 : 15'000);
  }

  double read_force(int leg) const noexcept {
    return read_applied(leg) + std::sin(18.8e-9 * static_cast<double>(now_ns_) + leg);
  }
  double read_applied(int leg) const noexcept { return force_[static_cast<std::size_t>(leg)]; }
  void write_force(int leg, double force) noexcept {
    force_[static_cast<std::size_t>(leg)] = force;
  }

 private:
  std::vector<double> force_;
  std::int64_t now_ns_ = 0, n_waits_ = 0;
};

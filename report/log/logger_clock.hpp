#pragma once

#include <cstdint>
#include <cstdlib>
#include <optional>

namespace stillframe::report {

/// The time that passed by a logger's clock, which may be set while it logs: a step back, or ahead
/// by over a minute (less may be silence), is counted and left out. One time alone that is off is
/// no step of the clock but damage to that time, and left out too.
class LoggerClock {
 public:
  void add(std::int64_t time_us) {
    if (!last_us_) {
      first_us_ = time_us;
      last_us_ = time_us;
    } else if (goes_on(*last_us_, time_us)) {
      advance(time_us - *last_us_, time_us);
    } else if (stray_us_ && goes_on(*stray_us_, time_us)) {
      count_step(difference_s(*stray_us_, *last_us_));
      advance(time_us - *stray_us_, time_us);
    } else {
      stray_us_ = time_us;
    }
  }
  std::int64_t first_us() const { return first_us_; }  ///< as it was set then
  double passed_s() const { return 1e-6 * static_cast<double>(passed_us_); }
  std::int64_t n_steps() const { return n_steps_; }
  double largest_step_s() const { return largest_step_s_; }  ///< with its sign

 private:
  static constexpr double longest_pause_s = 60;

  static double difference_s(std::int64_t to_us, std::int64_t from_us) {
    return 1e-6 * (static_cast<double>(to_us) - static_cast<double>(from_us));
  }
  static bool goes_on(std::int64_t from_us, std::int64_t to_us) {
    return to_us >= from_us && difference_s(to_us, from_us) <= longest_pause_s;
  }
  void advance(std::int64_t passed_us, std::int64_t time_us) {
    passed_us_ += passed_us;
    last_us_ = time_us;
    stray_us_.reset();
  }
  void count_step(double step_s) {
    ++n_steps_;
    if (std::abs(step_s) > std::abs(largest_step_s_)) largest_step_s_ = step_s;
  }

  std::optional<std::int64_t> last_us_, stray_us_;
  std::int64_t first_us_ = 0, passed_us_ = 0, n_steps_ = 0;
  double largest_step_s_ = 0;
};

}  // namespace stillframe::report

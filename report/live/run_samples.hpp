#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "report/live/rolling_window.hpp"
#include "stillframe_msgs/command_t.hpp"
#include "stillframe_msgs/measurement_t.hpp"

namespace stillframe::live {

/// What happened within one bucket of plant time.
struct Bucket {
  std::int64_t number = 0;            ///< it begins at number times bucket_s
  std::int64_t n = 0;                 ///< measurements
  std::vector<double> sum_squares;    ///< of each acceleration, floor first, (m/s^2)^2
  std::vector<double> largest_force;  ///< N, of each leg, of the commands
};

/// The newest measurements and commands of one run: as even samples for spectra, and as a history
/// of buckets. Memory is bounded by the rate and the sizes. Set-up.
class RunSamples {
 public:
  static constexpr double window_s = 16;  ///< s of plant time
  static constexpr double bucket_s = 0.5;
  static constexpr std::size_t n_buckets = 120;
  /// A gap of up to so much plant time is bridged by straight lines; after a longer one the window
  /// begins anew.
  static constexpr double bridged_s = 0.2;

  RunSamples(int n_floor, int n_legs, int n_frame, std::optional<double> sample_rate_hz);

  enum class Taken { fresh, old, restarted, wrong_size };
  /// restarted: its numbers have been going up from far behind, so it is another run of the same
  /// name, and begins here.
  Taken take(const stillframe_msgs::measurement_t& message);
  bool take(const stillframe_msgs::command_t& message);  ///< false: wrong size

  /// Hz; from the numbers and times of the measurements where it was not given. 0: not known yet.
  double sample_rate_hz() const noexcept { return rate_; }
  std::int64_t seq() const noexcept { return seq_; }  ///< of the newest measurement, -1: none
  double time_s() const noexcept { return time_s_; }
  std::int64_t n_missed() const noexcept { return n_missed_; }  ///< that never came here
  /// Whether some of them would be in the window.
  bool missed_lately() const noexcept {
    return n_missed_ > 0 && seq_ - gap_seq_ < motion_.capacity();
  }
  std::int64_t n_not_finite() const noexcept { return n_not_finite_; }
  std::int64_t n_saturated() const noexcept { return n_saturated_; }  ///< commands
  /// Whether a gap emptied the window, which has not been filled since.
  bool began_anew() const noexcept { return began_anew_ && motion_.size() < motion_.capacity(); }

  int n_floor() const noexcept { return n_floor_; }
  int n_legs() const noexcept { return n_legs_; }
  int n_frame() const noexcept { return n_frame_; }
  /// Accelerations, floor first, m/s^2, a sample a measurement.
  const RollingWindow& motion() const noexcept { return motion_; }
  const RollingWindow& force() const noexcept { return force_; }  ///< N, a sample a command
  const std::deque<Bucket>& history() const noexcept { return history_; }

 private:
  bool fits(const stillframe_msgs::measurement_t& message) const noexcept;
  void find_rate(const stillframe_msgs::measurement_t& message);
  void make_windows();
  double time_of(std::int64_t seq, std::int64_t time_ns) const noexcept;
  void bridge(std::int64_t n);
  void clean(std::vector<double>& values, const RollingWindow& window);
  Bucket& bucket_at(double time_s);

  int n_floor_, n_legs_, n_frame_;
  double rate_ = 0, time_s_ = 0;
  std::int64_t seq_ = -1, command_seq_ = -1, behind_seq_ = -1, n_behind_ = 0;
  std::int64_t gap_seq_ = -1;  ///< of the first measurement after the newest gap
  std::int64_t n_missed_ = 0, n_not_finite_ = 0, n_saturated_ = 0;
  bool began_anew_ = false;
  RollingWindow motion_, force_;
  std::vector<double> row_;
  std::deque<Bucket> history_;
};

}  // namespace stillframe::live

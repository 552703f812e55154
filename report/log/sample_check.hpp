#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "report/log/channel_course.hpp"
#include "stillframe_msgs/run_info_t.hpp"

namespace stillframe::report {

/// What is wrong with the values that a log holds, however whole it is.
struct SampleFaults {
  std::int64_t n_not_finite = 0;  ///< values of measurements and commands, see largest_value
  std::string first_not_finite;   ///< where, as in "seq 30000, sigma of leg_1"; empty: nowhere
  /// Measurements that are the one before to the bit in every channel while the floor moves.
  std::int64_t n_repeats = 0;
  /// Channel by channel; the rests tell of all of them, one list after the other.
  std::vector<ChannelCourse> floor, sigma, applied, frame, commanded;
};

/// N and m/s^2, a thousand times the largest force limit that gains may have: what is beyond it is
/// counted with what is not finite, long before its square is none.
inline constexpr double largest_value = 1e12;

/// Looks at the values of a run, sample by sample in the order of seq.
class SampleCheck {
 public:
  explicit SampleCheck(const stillframe_msgs::run_info_t& info);

  /// values: floor, sigma, applied and frame of one measurement (n_floor + 2 n_legs + n_frame).
  void measurement(std::int64_t seq, const double* values);
  /// values: the forces of one command (n_legs).
  void command(std::int64_t seq, const double* values);
  SampleFaults faults() const;

 private:
  void look(std::int64_t seq, const double* values, const std::vector<std::string>& names);

  std::vector<std::string> measured_, commanded_;  ///< what each value is
  std::size_t n_floor_, n_legs_;
  CourseRecorder courses_;
  std::vector<double> last_, first_floor_;
  std::int64_t last_seq_ = -1;
  bool floor_moves_ = false;
  SampleFaults faults_;
};

}  // namespace stillframe::report

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

namespace stillframe::report {

/// The rms of a signal in consecutive tenths of a second, from the first sample on: how loud it is,
/// over time. Eight bytes for each.
class LevelTrack {
 public:
  static constexpr double step_s = 0.1;
  explicit LevelTrack(double sample_rate_hz);

  void add(const Eigen::Ref<const Eigen::VectorXd>& x);
  /// The next n samples are missing.
  void skip(std::int64_t n);

  /// NaN where nothing was there; the last tenth, if it is not whole, is left out.
  const std::vector<double>& levels() const { return levels_; }

 private:
  void close();
  double samples_per_step_;
  std::int64_t next_ = 0;  ///< index of the next sample
  double sum_ = 0;
  std::int64_t in_step_ = 0;
  std::vector<double> levels_;
};

/// Something that shook floor or frame far above what is usual there and what was there just
/// before, and how long the frame took to come back to that.
struct Shock {
  double time_s = 0;       ///< of its largest level, plant time
  double floor_level = 0;  ///< largest rms in a tenth of a second, unit of the signal
  double frame_level = 0;  ///< the frame's largest from there on
  /// From there until the frame is below what is called settled for as long as levels are one
  /// shock; none if it is not before the next shock or the end.
  std::optional<double> settling_s;
};

/// When something is a shock, and when it is over. What is usual is the rms of a Gaussian motion of
/// this median level, the lowest motion that a tenth of a second can be of: one half-wave. Then a
/// level of 6 comes once in 5e8 tenths, so that no steady noise is a shock, and one of 4 once in
/// 16 000, so that it is not taken for one that goes on.
struct ShockCriteria {
  double times_usual = 6;         ///< a level so many times the usual one
  double times_before = 6;        ///< and the rms of what was before is a shock
  double share_of_largest = 0.1;  ///< if it is at least this share of the largest level there is
  double before_s = 10;           ///< so far back, to the end of the last shock
  double rest_times_before = 4;   ///< settled: below so many times the frame's rms before
  double rest_share = 0.05;       ///< or below this share of its largest after the shock
  double apart_s = 2;             ///< levels that are high so soon after one another are one shock
};

/// Shocks in the levels of floor and frame over the same tenths, in their order. first_time_s: of
/// the beginning of the first tenth.
std::vector<Shock> find_shocks(const std::vector<double>& floor, const std::vector<double>& frame,
                               double first_time_s = 0, const ShockCriteria& criteria = {});

}  // namespace stillframe::report

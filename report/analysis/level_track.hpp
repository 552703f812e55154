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

/// Something that shook floor or frame far above what is usual there, and how long the frame took
/// to come to rest.
struct Shock {
  double time_s = 0;       ///< of its largest level, from the first sample
  double floor_level = 0;  ///< largest rms in a tenth of a second, unit of the signal
  double frame_level = 0;  ///< the frame's largest from there on
  /// From there until the frame stays below what is called settled; none if it does not before the
  /// next shock or the end.
  std::optional<double> settling_s;
};

/// When something is a shock, and when it is over.
struct ShockCriteria {
  double times_median = 6;        ///< a level so many times the median is a shock
  double share_of_largest = 0.1;  ///< and at least this share of the largest level there is
  /// Settled: below so many times the level that the frame is below for a tenth of the run (its
  /// median would be that of its ringing where it rings on),
  double rest_times_quiet = 3;
  double rest_share = 0.05;  ///< or below this share of its largest after the shock
  double apart_s = 2;        ///< levels that are high so soon after one another are one shock
};

/// Shocks in the levels of floor and frame over the same tenths, in their order.
std::vector<Shock> find_shocks(const std::vector<double>& floor, const std::vector<double>& frame,
                               const ShockCriteria& criteria = {});

}  // namespace stillframe::report

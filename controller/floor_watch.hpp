#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "controller/policy.hpp"
#include "core/numerics/smooth_step.hpp"

namespace stillframe::controller {

/// Whether the floor's sensors are to be believed, and how much of the feed-forward acts: s(p), p
/// going to 0 within the policy's fade_s once a sensor is broken, and then back within ramp_in_s
/// when all have been well for one and a half. A sensor that has moved and then repeats one reading
/// while others go on is broken; where all rest, the floor does. So is one that reads white noise
/// ten times as large as that of any other, one that leaps by twenty times its largest change of
/// late, and one that the frame has not felt (floor_evidence.hpp). Feedback needs none of them.
/// Construction is set-up; the rest is hot: noexcept, no allocation. Source: docs/safety.md.
class FloorWatch {
 public:
  /// p sensors.
  FloorWatch(Eigen::Index p, const Policy& policy, double sample_time);

  /// What they read (p, m/s^2) n samples after the last time; liar: one that the frame has not
  /// felt, or -1; judged: false while that cannot be told yet, and nothing of the feed-forward
  /// acts: then it comes in as after a break.
  void hear(std::int64_t n, const Eigen::Ref<const Eigen::VectorXd>& w, Eigen::Index liar = -1,
            bool judged = true) noexcept;

  double share() const noexcept { return smooth_step(p_); }  ///< 0 to 1
  /// Whether the feed-forward should hear them: not while it has just begun, and not from when one
  /// breaks until it is faded out and all have been well for half a second. So it knows a second of
  /// the floor before it comes back.
  bool believed() const noexcept {
    return n_heard_ * sample_time_ > begins_s && (!goes_ || well_ > quiet_s);
  }
  /// The sensor that is broken, or was last while the feed-forward is not wholly back; -1: none.
  Eigen::Index broken() const noexcept { return broken_; }

  template <class Archive>
  void visit(Archive& archive) {
    archive(last_), archive(same_), archive(largest_), archive(moved_), archive(well_), archive(p_),
        archive(broken_);
    archive(goes_), archive(n_heard_);
    archive(begun_), archive(before_), archive(mean_), archive(rough_), archive(swing_);
    archive(n_in_a_row_), archive(n_averaged_);
  }

 private:
  static constexpr double begins_s = 0.2;  ///< well below the time that an arming takes
  static constexpr double quiet_s = 0.5, well_s = 1.5;

  void average(std::int64_t n, const Eigen::Ref<const Eigen::VectorXd>& w) noexcept;
  Eigen::Index stuck() const noexcept;
  Eigen::Index noisy() const noexcept;
  Eigen::Index leaping(double samples, const Eigen::Ref<const Eigen::VectorXd>& w) noexcept;

  double sample_time_, fade_s_, ramp_in_s_;
  double stuck_after_;       ///< samples
  Eigen::VectorXd last_;     ///< p, m/s^2
  Eigen::VectorXd largest_;  ///< p, m/s^2, change from one sample to the next, of late
  Eigen::VectorXd same_;     ///< p, samples for which it read the same
  Eigen::VectorXd moved_;    ///< p, 1: it has changed before
  Eigen::VectorXd before_;   ///< p, m/s^2, the reading before last_
  Eigen::VectorXd mean_;     ///< p, m/s^2, and of squares: of second differences, about the mean
  Eigen::VectorXd rough_, swing_;
  double keep_;            ///< part of largest_ that is left after a sample
  double forget_;          ///< part of an average that a sample replaces
  double n_in_a_row_ = 0;  ///< samples since the last gap
  double n_averaged_ = 0;
  double n_heard_ = 0;  ///< samples in all
  double well_ = 0;     ///< s, for which none is broken
  double p_ = 1;
  Eigen::Index broken_ = -1;
  bool begun_ = false;
  bool goes_ = false;  ///< the feed-forward fades out, or has
};

}  // namespace stillframe::controller

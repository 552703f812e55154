#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "controller/gains.hpp"

namespace stillframe::controller {

/// Whether the forces that are said to act are those that were commanded. Commands come late, are
/// lost or held, so that of leg i anything acts between the least and the largest of the last
/// commands that may, behind the lag of its amplifier: in [l_i, h_i]. The read-back r_i, what it
/// reads without a force (z_i, followed within seconds) taken off, disobeys if
///   r_i - h_i or l_i - r_i > n_i + part S_i               where |r_i| is the larger, or its sign
///                                                         another,
///                          > n_i + max(part, 1/4) S_i     where it is the smaller;
/// S_i: the largest |l_i| or |h_i|, forgotten within seconds, so that a hysteresis is a part of it;
/// n_i: the range of what it read while arming, and the smallest step that it was seen to make. A
/// force that is larger than what was commanded, or a read-back that says so, makes a loop unstable
/// that cancels the stiffness of its legs; one that falls short does not. Construction is set-up;
/// the rest is hot: noexcept, no allocation. Source: docs/safety.md.
class Obedience {
 public:
  /// part: of Policy::disobeyed_part.
  Obedience(const Gains& gains, double part);

  /// Arming begins: what was learned is forgotten.
  void restart() noexcept;
  /// What is said to act (m, N) while nothing is commanded.
  void listen(const Eigen::Ref<const Eigen::VectorXd>& applied) noexcept;
  /// The loop is closed: no command has been sent that still acts.
  void begin() noexcept;
  /// That much (m, N) is commanded.
  void command(const Eigen::Ref<const Eigen::VectorXd>& force) noexcept;
  /// n samples after the last measurement, that much (m, N) is said to act.
  void hear(std::int64_t n, const Eigen::Ref<const Eigen::VectorXd>& applied) noexcept;
  /// Commands have not been heard, or measurements did not come: what acts has not been followed,
  /// and nothing is compared until that has passed.
  void lose_track() noexcept;

  /// True if too many measurements in a row said that one leg does not do as it is told.
  bool is_broken() const noexcept { return leg_ >= 0; }
  /// That leg, the furthest off of several; -1: none.
  Eigen::Index leg() const noexcept { return leg_; }

  template <class Archive>
  void visit(Archive& archive) {
    archive(commands_), archive(least_), archive(most_), archive(size_), archive(zero_);
    archive(low_), archive(high_), archive(last_), archive(step_);
    archive(in_row_), archive(newest_), archive(since_), archive(n_listened_), archive(leg_);
  }

 private:
  /// In a row: one sample alone is a telegram that went wrong, and no reason to let go.
  static constexpr double enough = 3;

  double beyond(Eigen::Index i, double read) const noexcept;

  double part_, short_part_;      ///< of S
  double sample_time_, lag_;      ///< s; what is left of a step after a sample, 0: no lag
  double keep_, follows_;         ///< of S, and of z, in a sample
  Eigen::MatrixXd commands_;      ///< m x as many as may act, a ring
  Eigen::VectorXd least_, most_;  ///< m, N, l and h
  Eigen::VectorXd now_least_, now_most_;
  Eigen::VectorXd size_, zero_;  ///< m, N, S and z
  Eigen::VectorXd low_, high_;   ///< m, N, what was read without a force
  Eigen::VectorXd last_, step_;  ///< m, N, the last reading, and its smallest step
  Eigen::VectorXd in_row_;       ///< m, how often it disobeyed, the last measurement included
  std::int64_t settles_;         ///< samples after which what was not followed acts no more
  std::int64_t newest_ = 0, since_ = 0, n_listened_ = 0;
  Eigen::Index leg_ = -1;
};

}  // namespace stillframe::controller

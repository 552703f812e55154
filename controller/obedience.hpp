#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "controller/gains.hpp"

namespace stillframe::controller {

/// Whether the forces that are said to act are those that were commanded. Commands come late, are
/// lost or held, so that of leg i anything acts between the least and the largest of the last
/// commands that may, behind the lag of its amplifier: in [l_i, h_i]. The read-back r_i, what it
/// reads without a force (z_i) taken off, disobeys if
///   r_i - h_i or l_i - r_i > n_i + part S_i               where |r_i| is the larger, or its sign
///                                                         another,
///                          > n_i + max(part, 1/4) S_i     where it is the smaller;
/// S_i: the largest |l_i| or |h_i|, forgotten within seconds, so that a hysteresis is a part of it;
/// n_i: the range of what it read while arming, but for single telegrams, and the smallest step
/// that it was seen to make. z_i is either of two, both followed within seconds: one as if whatever
/// is off were the zero, the other by what neither the part nor a quarter explains, because of a
/// force that is held nobody can tell a zero that drifts from one that falls short, until it goes.
/// A force that is larger than what was commanded, or a read-back that says so, makes a loop
/// unstable that cancels the stiffness of its legs; one that falls short does not. But it leaves
/// them some of their stiffness: how much acts is told by acts(). Amplifiers that miss commands
/// hold their forces, all of them: while no reading moves, for as long as the law makes up for,
/// none disobeys that obeyed before. Construction is set-up; the rest is hot: noexcept, no
/// allocation. Source: docs/safety.md.
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
  /// Of what changes in a command, that part is said to act (m, 1), by the swings of the last
  /// seconds: three quarters at least, which is as far as it may fall short, and all at most.
  const Eigen::VectorXd& acts() const noexcept { return acts_; }

  template <class Archive>
  void visit(Archive& archive) {
    archive(commands_), archive(least_), archive(most_), archive(size_), archive(zero_);
    archive(sure_zero_), archive(low_), archive(high_), archive(last_), archive(before_);
    archive(step_), archive(held_), archive(in_row_);
    archive(asked_), archive(mean_asked_), archive(mean_read_), archive(squares_);
    archive(products_), archive(acts_);
    archive(newest_), archive(since_), archive(n_listened_), archive(n_learned_), archive(still_);
    archive(held_obeyed_), archive(leg_);
  }

 private:
  /// In a row: one sample alone is a telegram that went wrong, and no reason to let go.
  static constexpr double enough = 3;

  double own(Eigen::Index i) const noexcept { return high_(i) - low_(i) + step_(i); }
  double beyond(Eigen::Index i, double read) const noexcept;
  double disobeys(Eigen::Index i, double applied) const noexcept;
  void follow_commands(double passed) noexcept;
  bool are_held(std::int64_t n, const Eigen::Ref<const Eigen::VectorXd>& applied,
                bool obey) noexcept;
  void learn(Eigen::Index i, double applied, double part) noexcept;

  double part_, short_part_;      ///< of S
  double sample_time_, lag_;      ///< s; what is left of a step after a sample, 0: no lag
  double keep_, follows_;         ///< of S, and of z, in a sample
  Eigen::MatrixXd commands_;      ///< m x as many as may act, a ring
  Eigen::VectorXd least_, most_;  ///< m, N, l and h
  Eigen::VectorXd now_least_, now_most_;
  Eigen::VectorXd size_;              ///< m, N, S
  Eigen::VectorXd zero_, sure_zero_;  ///< m, N, both z
  Eigen::VectorXd low_, high_;        ///< m, N, what was read without a force
  Eigen::VectorXd last_, before_;     ///< m, N, the last reading, and the one before it
  Eigen::VectorXd step_;              ///< m, N, its smallest step
  Eigen::VectorXd held_;              ///< m, N, what is read for as long as nothing moves
  Eigen::VectorXd in_row_;            ///< m, how often it disobeyed, the last measurement included
  Eigen::VectorXd off_;               ///< m, N, by how much it disobeys now
  Eigen::VectorXd asked_;             ///< m, N, the command that should act now
  Eigen::VectorXd mean_asked_, mean_read_, squares_, products_;  ///< m, N and N^2, of the last
                                                                 ///< seconds, for acts_
  Eigen::VectorXd acts_;                                         ///< m, 1
  Eigen::Index age_;      ///< of the command that should act now, in samples
  std::int64_t settles_;  ///< samples after which what was not followed acts no more
  std::int64_t newest_ = 0, since_ = 0, n_listened_ = 0, n_learned_ = 0;
  std::int64_t still_ = 0;    ///< samples, for which no reading has moved
  bool held_obeyed_ = false;  ///< what has not moved since obeyed when it last moved
  Eigen::Index leg_ = -1;
};

}  // namespace stillframe::controller

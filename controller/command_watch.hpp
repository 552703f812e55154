#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace stillframe::controller {

/// Watches whether the actuators can do what the law asks of them: the share of commands at the
/// force limit, a mean over about a second, and of those that were to change faster than the pace
/// of the designed loop, over about twenty samples. A loop that has become unstable ends there,
/// whatever the reason, and swings from limit to limit. Construction is set-up; the rest is hot:
/// noexcept, no allocation.
class CommandWatch {
 public:
  /// m legs; sample_time in s; force_limit in N; limited_part: the largest shares that are no
  /// fault.
  CommandWatch(Eigen::Index m, double sample_time, double force_limit, double limited_part);

  /// Takes the force (m, N) that is commanded. driving: the law asks for it; hurries: the leg whose
  /// force was to change the furthest beyond its pace, -1: none.
  void command(const Eigen::Ref<const Eigen::VectorXd>& force, bool driving,
               Eigen::Index hurries) noexcept;
  /// True if too many were at the limit.
  bool limited() const noexcept { return share_ > limited_part_; }
  /// True if too many were to change faster.
  bool restless() const noexcept { return hurried_ > restless_part; }
  /// The leg that began it, -1: none did.
  Eigen::Index first() const noexcept { return first_; }
  /// What broke is known: that leg.
  void began_with(Eigen::Index leg) noexcept { first_ = leg; }
  /// The last commands smoothed over some milliseconds (m, N): what to hold of forces that swing
  /// from sample to sample.
  const Eigen::VectorXd& steady_force() noexcept;
  /// Arming begins: what was met before is forgotten.
  void restart() noexcept { share_ = hurried_ = 0, since_limit_ = 1000, first_ = -1; }

  template <class Archive>
  void visit(Archive& archive) {
    archive(commands_), archive(newest_), archive(share_), archive(hurried_), archive(since_limit_);
    archive(first_);
  }

 private:
  static constexpr double restless_part = 0.12;  ///< three of twenty in a row

  double keep_, keep_hurried_, force_limit_, limited_part_;
  Eigen::VectorXd weights_, steady_;
  Eigen::MatrixXd commands_;  ///< m x as many as are smoothed over
  std::int64_t newest_ = 0;
  std::int64_t since_limit_ = 0;  ///< commands
  Eigen::Index first_ = -1;
  double share_ = 0, hurried_ = 0;
};

}  // namespace stillframe::controller

#pragma once

#include <Eigen/Core>

#include "controller/policy.hpp"

namespace stillframe::controller {

/// What is looked at before the loop takes hold: n samples of sigma, whether every sensor moves in
/// them, and the offset of each: the mean, taken for one only if it exceeds `sure` times its own
/// standard error, told by the scatter of the means of sixteen batches: a wrong offset would be
/// worse than none, because the loop gives the frame K_I / omega_l times as much. Construction is
/// set-up; the rest is hot: noexcept, no allocation.
class Arming {
 public:
  static constexpr Eigen::Index n_batches = 16;
  /// Student's t of 15 degrees of freedom is beyond it once in 9200: six legs, once in 1500
  /// armings.
  static constexpr double sure = 5.2;

  /// m legs. Errors: std::invalid_argument if the arming time has fewer samples than batches.
  Arming(Eigen::Index m, const Policy& policy, double sample_rate_hz);

  void restart() noexcept { n_ = 0; }
  void add(const Eigen::Ref<const Eigen::VectorXd>& sigma) noexcept;
  bool complete() const noexcept { return n_ >= n_needed_; }

  /// Once complete: none, not_alive or offset; writes the offsets (m, N).
  Fault judge(Eigen::Ref<Eigen::VectorXd> offset, Eigen::Ref<Eigen::VectorXd> doubt) const noexcept;

  template <class Archive>
  void visit(Archive& archive) {
    archive(n_), archive(first_), archive(moved_), archive(sums_);
  }

 private:
  std::int64_t n_needed_, n_ = 0;
  bool require_motion_;
  double offset_limit_;
  Eigen::VectorXd first_, moved_;  ///< m; moved: 1 once it has
  Eigen::MatrixXd sums_;           ///< m x n_batches
};

}  // namespace stillframe::controller

#pragma once

#include <Eigen/Core>

namespace stillframe {

/// The commands on their way from the controller to the actuators. A command u[k], computed from
/// sample k, takes effect at t_k + d T_s with d = n + phi, n whole and 0 <= phi < 1. In the
/// interval that begins at t_k this is
///   u[k-n-1] until t_k + phi T_s,   u[k-n] from there on;   zero before the first command.
/// Source: THEORY section 5. Set-up: construction. The rest is hot: noexcept, no allocation.
class CommandQueue {
 public:
  /// delay_samples: d, 0 or more. Errors: std::invalid_argument if it is negative or not finite.
  CommandQueue(Eigen::Index n_legs, double delay_samples);

  /// True if u[k] acts within the interval that begins at t_k (n = 0), so that it must be pushed
  /// before the plant goes through that interval. Otherwise u[k-1] is the newest needed there, and
  /// u[k] may be pushed behind it.
  bool needs_answer() const noexcept { return whole_ == 0; }

  /// The next command (n_legs, N).
  void push(const Eigen::VectorXd& command) noexcept;

  /// What acts at the start of the interval, from which part of it on what else (n_legs, N).
  Eigen::Ref<const Eigen::VectorXd> before() const noexcept { return behind(back_ + 1); }
  Eigen::Ref<const Eigen::VectorXd> after() const noexcept { return behind(back_); }
  double fraction() const noexcept { return fraction_; }

 private:
  Eigen::Ref<const Eigen::VectorXd> behind(Eigen::Index samples) const noexcept;

  Eigen::Index whole_;       ///< n
  double fraction_;          ///< phi
  Eigen::Index back_;        ///< how far behind the newest command after() is
  Eigen::MatrixXd pending_;  ///< n_legs x (back_ + 2), a ring
  Eigen::Index newest_ = 0;  ///< its column
};

}  // namespace stillframe

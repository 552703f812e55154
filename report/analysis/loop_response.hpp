#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>

#include "core/linear/sampled_loop.hpp"

namespace stillframe::report {

/// What a sampled loop makes of its inputs, sample by sample, from rest. Set-up.
class LoopResponse {
 public:
  explicit LoopResponse(SampledLoop loop);
  /// The next rows of inputs: the outputs of the measurements that these travel with, a row each.
  Eigen::MatrixXd follow(const Eigen::MatrixXd& inputs);
  void rest() { state_.setZero(); }
  const SampledLoop& loop() const { return loop_; }

 private:
  SampledLoop loop_;
  Eigen::VectorXd state_, next_, input_;
};

/// Forces that act on a frame besides its floor, as its scene has them.
struct ForceModel {
  SampledLoop loop;  ///< from the forces to accelerations
  /// N, held over sample k, one of each input of the loop; k may be -1, before the run.
  std::function<Eigen::VectorXd(std::int64_t)> at;
};

/// What a loop makes of forces whose whole course is known: a log's gaps are none here. Set-up.
class ForceResponse {
 public:
  explicit ForceResponse(ForceModel model);
  /// The accelerations of n measurements from seq on, a row each. Errors: std::invalid_argument for
  /// a seq before what was asked last.
  Eigen::MatrixXd at(std::int64_t seq, Eigen::Index n);

 private:
  Eigen::MatrixXd follow(Eigen::Index n);

  LoopResponse response_;
  std::function<Eigen::VectorXd(std::int64_t)> forces_;
  std::int64_t next_ = 0;
};

}  // namespace stillframe::report

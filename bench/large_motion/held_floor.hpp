#pragma once

#include <Eigen/Core>
#include <utility>

namespace stillframe::race {

/// A floor whose accelerations (inputs x samples, m/s^2) are held over each sample: the motion
/// along the inputs within one sample and its exact integrals from sample to sample.
class HeldFloor {
 public:
  HeldFloor(Eigen::MatrixXd accelerations, double sample_time)
      : a_(std::move(accelerations)),
        sample_time_(sample_time),
        position_(Eigen::VectorXd::Zero(a_.rows())),
        rate_(position_) {}

  Eigen::Index samples() const { return a_.cols(); }
  double sample_time() const { return sample_time_; }
  Eigen::VectorXd acceleration() const { return a_.col(k_); }
  /// At a time t (s) since the run began, within the present sample.
  double position(Eigen::Index input, double t) const {
    const double since = t - static_cast<double>(k_) * sample_time_;
    return position_(input) + since * (rate_(input) + 0.5 * since * a_(input, k_));
  }
  Eigen::VectorXd rate_at_end() const { return rate_ + sample_time_ * a_.col(k_); }
  void next() {
    position_ += sample_time_ * (rate_ + 0.5 * sample_time_ * a_.col(k_));
    rate_ += sample_time_ * a_.col(k_);
    ++k_;
  }

 private:
  Eigen::MatrixXd a_;
  double sample_time_;
  Eigen::VectorXd position_, rate_;
  Eigen::Index k_ = 0;
};

}  // namespace stillframe::race

#pragma once

#include <Eigen/Core>
#include <span>

namespace stillframe::live {

/// The newest samples of several channels, evenly spaced in time. Construction is set-up; push() is
/// hot: noexcept, no allocation.
class RollingWindow {
 public:
  RollingWindow() = default;
  /// Errors: std::invalid_argument for a capacity below 1 or a negative number of channels.
  RollingWindow(Eigen::Index n_channels, Eigen::Index capacity);

  /// Adds a sample, n_channels values; the oldest goes if there is no room.
  void push(std::span<const double> sample) noexcept;
  void clear() noexcept { size_ = 0; }

  Eigen::Index size() const noexcept { return size_; }
  Eigen::Index capacity() const noexcept { return samples_.cols(); }
  Eigen::Index n_channels() const noexcept { return samples_.rows(); }

  /// The newest n values of a channel, the oldest of them first.
  /// Errors: std::invalid_argument for a channel that is not there or more than size().
  Eigen::VectorXd newest(Eigen::Index channel, Eigen::Index n) const;
  /// The newest value of a channel. Hot: noexcept; there must be one.
  double last(Eigen::Index channel) const noexcept {
    return samples_(channel, next_ == 0 ? capacity() - 1 : next_ - 1);
  }

 private:
  Eigen::MatrixXd samples_;  ///< n_channels x capacity, a ring of columns
  Eigen::Index next_ = 0, size_ = 0;
};

}  // namespace stillframe::live

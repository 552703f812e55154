#include "report/live/rolling_window.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace stillframe::live {

using Eigen::Index;

RollingWindow::RollingWindow(Index n_channels, Index capacity) {
  if (n_channels < 0 || capacity < 1) {
    throw std::invalid_argument("RollingWindow: got " + std::to_string(n_channels) +
                                " channels of " + std::to_string(capacity) + " samples");
  }
  samples_.resize(n_channels, capacity);
}

void RollingWindow::push(std::span<const double> sample) noexcept {
  std::copy_n(sample.begin(), samples_.rows(), samples_.col(next_).data());
  next_ = next_ + 1 == capacity() ? 0 : next_ + 1;
  size_ = std::min(size_ + 1, capacity());
}

Eigen::VectorXd RollingWindow::newest(Index channel, Index n) const {
  if (channel < 0 || channel >= n_channels() || n < 0 || n > size_) {
    throw std::invalid_argument("RollingWindow: no " + std::to_string(n) + " samples of channel " +
                                std::to_string(channel));
  }
  Eigen::VectorXd values(n);
  const Index after = std::min(n, next_);  // of the newest, at the beginning of the ring
  values.tail(after) = samples_.row(channel).segment(next_ - after, after);
  values.head(n - after) = samples_.row(channel).segment(capacity() - (n - after), n - after);
  return values;
}

}  // namespace stillframe::live

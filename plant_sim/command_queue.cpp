#include "plant_sim/command_queue.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

namespace stillframe {

using Eigen::Index;

namespace {

double checked(double delay_samples) {
  if (!(delay_samples >= 0) || !std::isfinite(delay_samples)) {
    throw std::invalid_argument("command queue: expected a delay of 0 samples or more, got " +
                                std::to_string(delay_samples));
  }
  return delay_samples;
}

}  // namespace

CommandQueue::CommandQueue(Index n_legs, double delay_samples)
    : whole_(static_cast<Index>(std::floor(checked(delay_samples)))),
      fraction_(delay_samples - std::floor(delay_samples)),
      // In the interval from t_k the newest command is u[k] with n = 0 and u[k-1] otherwise.
      back_(whole_ == 0 ? 0 : whole_ - 1),
      pending_(Eigen::MatrixXd::Zero(n_legs, back_ + 2)) {}

void CommandQueue::push(const Eigen::VectorXd& command) noexcept {
  newest_ = (newest_ + 1) % pending_.cols();
  pending_.col(newest_) = command;
}

Eigen::Ref<const Eigen::VectorXd> CommandQueue::behind(Index samples) const noexcept {
  return pending_.col((newest_ + pending_.cols() - samples) % pending_.cols());
}

}  // namespace stillframe

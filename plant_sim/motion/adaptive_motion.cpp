#include "plant_sim/motion/adaptive_motion.hpp"

#include <algorithm>

namespace stillframe {

namespace {

/// Parts over which costs are averaged, and a trial lasts.
constexpr int trial_parts = 8;
/// Parts between two trials, at first and at most: a shock that is over soon costs some trials
/// only.
constexpr int least_wait = 32, most_wait = 1024;
/// Parts before a trial where the method for small motion has become twice as dear as it was at the
/// last one: the motion grows. At first that is a cost of twice the cheap ones.
constexpr int growth_wait = 4;
/// Evaluations a part of the method for small motion with which no other can be cheaper: two
/// sweeps. An explicit step alone takes seven.
constexpr double cheap = 6.5;

}  // namespace

AdaptiveMotion::AdaptiveMotion(std::unique_ptr<NonlinearMotion> small,
                               std::unique_ptr<NonlinearMotion> large, double large_weight,
                               Eigen::Index size)
    : small_(std::move(small)),
      large_(std::move(large)),
      large_weight_(large_weight),
      current_(small_.get()),
      wait_(least_wait),
      cost_tried_(cheap) {
  snapshot_.y = Eigen::VectorXd::Zero(size);
}

bool AdaptiveMotion::change(const Drive& drive) noexcept {
  if (!current_->hand_over(drive, snapshot_)) return false;
  current_ = is_large() ? small_.get() : large_.get();
  current_->take_over(snapshot_);
  return true;
}

Motion::Status AdaptiveMotion::advance(const Drive& drive, double duration) noexcept {
  if (change_next_ && !change(drive)) return Status::equations_failed;
  change_next_ = false;
  const long before = current_->evaluations();
  const Status status = current_->advance(drive, duration);
  if (status == Status::ok) {
    judge(weight() * static_cast<double>(current_->evaluations() - before));
    return status;
  }
  // What one method cannot do from here the other one may.
  if (!change(drive) || current_->advance(drive, duration) != Status::ok) return status;
  on_trial_ = false;
  wait_ = least_wait;
  parts_ = 0;
  return Status::ok;
}

void AdaptiveMotion::judge(double cost) noexcept {
  ++parts_;
  // The first part after a change starts from nothing, and shows too much.
  if (parts_ > 1) cost_ += (cost - cost_) / std::min(parts_ - 1, trial_parts);
  if (on_trial_) {
    // What is twice as dear for a part is not looked at for longer.
    const bool in_vain = parts_ > 1 && cost_ > 2 * cost_before_;
    if (parts_ <= trial_parts && !in_vain) return;
    on_trial_ = false;
    cost_tried_ = is_large() ? cost_before_ : cost_;
    if (cost_ < 0.9 * cost_before_) {
      wait_ = least_wait;
      return;
    }
    // Back to the other one, and there for longer.
    wait_ = std::min(2 * wait_, most_wait);
    std::swap(cost_, cost_before_);
    change_next_ = true;
    parts_ = 0;
    return;
  }
  const bool grown = !is_large() && cost_ > 2 * cost_tried_;
  if (parts_ < (grown ? growth_wait : wait_)) return;
  parts_ = trial_parts;
  if (!is_large() && cost_ <= cheap) {
    wait_ = least_wait;
    return;
  }
  on_trial_ = change_next_ = true;
  cost_before_ = cost_;
  parts_ = 0;
}

}  // namespace stillframe

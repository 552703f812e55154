#include "controller/floor_watch.hpp"

#include <algorithm>
namespace stillframe::controller {

using Eigen::Index;
using Eigen::Ref;
using Eigen::VectorXd;

namespace {

// What is not noise repeats itself no longer: a converter's step is below the noise of its sensor.
constexpr double fewest_repeats = 50, repeats_s = 0.1;
constexpr double well_s = 1;

}  // namespace

FloorWatch::FloorWatch(Index p, const Policy& policy, double sample_time)
    : sample_time_(sample_time),
      fade_s_(policy.fade_s),
      ramp_in_s_(policy.ramp_in_s),
      stuck_after_(std::max(fewest_repeats, repeats_s / sample_time)) {
  last_ = same_ = moved_ = VectorXd::Zero(p);
}

Index FloorWatch::stuck() const noexcept {
  Index found = -1;
  bool others_move = false;
  for (Index j = 0; j < same_.size(); ++j) {
    if (same_(j) < stuck_after_) {
      others_move = true;
    } else if (moved_(j) > 0 && found < 0) {
      found = j;
    }
  }
  return others_move ? found : -1;
}

void FloorWatch::hear(std::int64_t n, const Ref<const VectorXd>& w) noexcept {
  if (last_.size() == 0 || w.size() != last_.size()) return;
  const auto samples = static_cast<double>(n);
  for (Index j = 0; j < w.size(); ++j) {
    const bool changed = begun_ && w(j) != last_(j);
    same_(j) = changed ? 0 : same_(j) + samples;
    if (changed) moved_(j) = 1;
  }
  last_ = w;
  begun_ = true;
  const double passed = samples * sample_time_;
  if (const Index j = stuck(); j >= 0) {
    broken_ = j;
    well_ = 0;
    p_ = std::max(0.0, p_ - passed / fade_s_);
  } else if (broken_ >= 0) {
    well_ += passed;
    // Half gone, it goes on going: a cable that comes and goes is no sensor.
    if (well_ < well_s) {
      p_ = std::max(0.0, p_ - passed / fade_s_);
    } else {
      p_ = std::min(1.0, p_ + passed / ramp_in_s_);
    }
    if (p_ == 1) broken_ = -1;
  }
}

}  // namespace stillframe::controller

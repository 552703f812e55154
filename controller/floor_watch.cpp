#include "controller/floor_watch.hpp"

#include <algorithm>
#include <cmath>

#include "controller/slow_loops.hpp"

namespace stillframe::controller {

using Eigen::Index;
using Eigen::Ref;
using Eigen::VectorXd;

namespace {

// What is not noise repeats itself no longer: a converter's step is below the noise of its sensor.
constexpr double fewest_repeats = 50, repeats_s = 0.1;
// Second differences of white noise have six times its variance. A floor that is moved has far less
// of them, and a tone near half the rate up to 16.
constexpr double averaged_s = 0.2, fewest_averaged = 100;
constexpr double least_of_white = 3, most_of_white = 9;
constexpr double louder_than_another = 10;
// A change from sample to sample, m/s^2, and of those of the last seconds: no floor that a frame
// stands on begins so suddenly but by a blow.
constexpr double leap = 0.02, leap_over_largest = 20, remembers_s = 3;

}  // namespace

FloorWatch::FloorWatch(Index p, const Policy& policy, double sample_time)
    : sample_time_(sample_time),
      fade_s_(policy.fade_s),
      ramp_in_s_(policy.ramp_in_s),
      stuck_after_(std::max(fewest_repeats, repeats_s / sample_time)),
      keep_(std::exp(-sample_time / slowed(remembers_s, 1 / sample_time))),
      forget_(1 / std::max(fewest_averaged, averaged_s / sample_time)) {
  last_ = same_ = largest_ = moved_ = before_ = mean_ = rough_ = swing_ = VectorXd::Zero(p);
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

Index FloorWatch::noisy() const noexcept {
  if (n_averaged_ * forget_ < 1) return -1;
  Index loudest = 0;
  const double most = rough_.maxCoeff(&loudest);
  double second = 0;
  for (Index j = 0; j < rough_.size(); ++j) {
    if (j != loudest) second = std::max(second, rough_(j));
  }
  const bool alone = second > 0 && most > louder_than_another * louder_than_another * second;
  const double swing = swing_(loudest);
  const bool white = most > least_of_white * swing && most < most_of_white * swing;
  return alone && white ? loudest : -1;
}

Index FloorWatch::leaping(double samples, const Ref<const VectorXd>& w) noexcept {
  Index found = -1;
  const double kept = samples == 1 ? keep_ : std::pow(keep_, samples);
  for (Index j = 0; begun_ && j < w.size(); ++j) {
    const double change = std::abs(w(j) - last_(j)) / samples;
    const bool leaps = change > std::max(leap, leap_over_largest * largest_(j));
    if (leaps && n_averaged_ * forget_ >= 1) found = j;
    largest_(j) = std::max(kept * largest_(j), change);
  }
  return found;
}

void FloorWatch::average(std::int64_t n, const Ref<const VectorXd>& w) noexcept {
  n_in_a_row_ = n == 1 ? n_in_a_row_ + 1 : 0;
  if (n_in_a_row_ < 2) return;
  n_averaged_ += 1;
  for (Index j = 0; j < w.size(); ++j) {
    const double rough = w(j) - 2 * last_(j) + before_(j), swing = w(j) - mean_(j);
    mean_(j) += forget_ * swing;
    rough_(j) += forget_ * (rough * rough - rough_(j));
    swing_(j) += forget_ * (swing * swing - swing_(j));
  }
}

void FloorWatch::hear(std::int64_t n, const Ref<const VectorXd>& w, Index liar,
                      bool judged) noexcept {
  if (last_.size() == 0 || w.size() != last_.size()) return;
  const auto samples = static_cast<double>(n);
  for (Index j = 0; j < w.size(); ++j) {
    const bool changed = begun_ && w(j) != last_(j);
    same_(j) = changed ? 0 : same_(j) + samples;
    if (changed) moved_(j) = 1;
  }
  n_heard_ += samples;
  const Index leaps = leaping(samples, w);
  average(n, w);
  before_ = last_;
  last_ = w;
  begun_ = true;
  const double passed = samples * sample_time_;
  const Index repeats = stuck(), noise = noisy();
  if (const Index j = repeats >= 0 ? repeats
                      : noise >= 0 ? noise
                      : leaps >= 0 ? leaps
                                   : liar;
      j >= 0) {
    broken_ = j;
    well_ = 0;
    goes_ = true;
  } else if (broken_ >= 0) {
    // Half gone, it goes on going: a cable that comes and goes is no sensor.
    if (p_ == 0) well_ += passed;
    if (well_ >= well_s) goes_ = false;
  }
  if (!judged) {
    p_ = 0;
  } else if (goes_) {
    p_ = std::max(0.0, p_ - passed / fade_s_);
  } else {
    p_ = std::min(1.0, p_ + passed / ramp_in_s_);
    if (p_ == 1) broken_ = -1;
  }
}

}  // namespace stillframe::controller

#include "controller/obedience.hpp"

#include <algorithm>
#include <cmath>

#include "controller/law.hpp"
#include "controller/slow_loops.hpp"
#include "core/numerics/infinity.hpp"
#include "core/numerics/two_pi.hpp"

namespace stillframe::controller {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Ref;
using Eigen::VectorXd;

namespace {

// A piezo that swings little falls short of its gain by its hysteresis, some sixth; a quarter is
// more.
constexpr double least_short_part = 0.25;
constexpr double forgotten_s = 3;

}  // namespace

Obedience::Obedience(const Gains& gains, double part)
    : part_(part),
      short_part_(std::max(part, least_short_part)),
      sample_time_(gains.sample_time()),
      keep_(std::exp(-sample_time_ / slowed(forgotten_s, gains.sample_rate_hz))),
      follows_(1 - keep_) {
  const Index m = gains.n_legs();
  const bool lags = gains.instruments.actuator_lag_hz > 0 &&
                    gains.instruments.report == Instruments::Report::measured;
  lag_ = lags ? std::exp(-two_pi * gains.instruments.actuator_lag_hz * sample_time_) : 0;
  age_ = static_cast<Index>(std::ceil(gains.delay_samples)) + gains.instruments.report_age_samples;
  commands_ = MatrixXd::Zero(m, age_ + 1 + amplifiers_hold);
  least_ = most_ = now_least_ = now_most_ = size_ = zero_ = sure_zero_ = VectorXd::Zero(m);
  low_ = high_ = last_ = before_ = step_ = held_ = in_row_ = off_ = asked_ = mean_asked_ =
      mean_read_ = squares_ = products_ = acts_ = least_;
  constexpr double left = 0.01;      // of what was behind the lag, below what calibrations are off
  constexpr double for_ever = 1e12;  // samples, of a lag that no sample shows
  settles_ = commands_.cols();
  if (lag_ > 0) {
    const double fades = lag_ < 1 ? std::log(left) / std::log(lag_) : for_ever;
    settles_ += static_cast<std::int64_t>(std::ceil(std::min(fades, for_ever)));
  }
  restart();
}

void Obedience::restart() noexcept {
  n_listened_ = 0;
  step_.setConstant(infinity);
  begin();
}

void Obedience::listen(const Ref<const VectorXd>& applied) noexcept {
  ++n_listened_;
  for (Index i = 0; i < last_.size(); ++i) {
    const double now = applied(i), last = last_(i), before = before_(i);
    // One telegram that went wrong is in the middle of no three.
    const double middle =
        n_listened_ < 3 ? now
                        : std::max(std::min(now, last), std::min(std::max(now, last), before));
    const bool first = n_listened_ == 1 || n_listened_ == 3;
    low_(i) = first ? middle : std::min(low_(i), middle);
    high_(i) = first ? middle : std::max(high_(i), middle);
    if (n_listened_ > 1 && now != last) step_(i) = std::min(step_(i), std::abs(now - last));
  }
  before_ = last_;
  last_ = applied;
}

void Obedience::begin() noexcept {
  commands_.setZero();
  least_.setZero();
  most_.setZero();
  size_.setZero();
  zero_ = 0.5 * (low_ + high_);
  sure_zero_ = zero_;
  since_ = settles_;
  in_row_.setZero();
  for (VectorXd* each : {&asked_, &mean_asked_, &mean_read_, &squares_, &products_}) {
    each->setZero();
  }
  acts_.setOnes();
  n_learned_ = 0;
  still_ = 0;
  held_ = last_;
  held_obeyed_ = true;
  leg_ = -1;
}

void Obedience::lose_track() noexcept {
  since_ = 0;
  in_row_.setZero();
}

void Obedience::command(const Ref<const VectorXd>& force) noexcept {
  newest_ = (newest_ + 1) % commands_.cols();
  commands_.col(newest_) = force;
}

double Obedience::beyond(Index i, double read) const noexcept {
  const double off = read > most_(i) ? read - most_(i) : least_(i) - read;
  if (!(off > 0)) return 0;
  const bool falls_short = read > most_(i) ? most_(i) < 0 && read < 0 : least_(i) > 0 && read > 0;
  return off - own(i) - (falls_short ? short_part_ : part_) * size_(i);
}

double Obedience::disobeys(Index i, double applied) const noexcept {
  const double off = beyond(i, applied - zero_(i));
  return off > 0 ? std::min(off, beyond(i, applied - sure_zero_(i))) : off;
}

void Obedience::follow_commands(double passed) noexcept {
  now_least_ = commands_.rowwise().minCoeff();
  now_most_ = commands_.rowwise().maxCoeff();
  const double left = lag_ > 0 ? std::pow(lag_, passed) : 0;
  least_ = left * least_ + (1 - left) * now_least_;
  most_ = left * most_ + (1 - left) * now_most_;
  asked_ = left * asked_ +
           (1 - left) * commands_.col((newest_ + commands_.cols() - age_) % commands_.cols());
  size_ = (std::pow(keep_, passed) * size_).cwiseMax(most_.cwiseMax(-least_));
}

bool Obedience::are_held(std::int64_t n, const Ref<const VectorXd>& applied, bool obey) noexcept {
  // Of a noise the medians of three tell half the range or so, and two readings differ by all of
  // it.
  bool moves = false;
  for (Index i = 0; i < applied.size(); ++i) moves |= std::abs(applied(i) - held_(i)) > 2 * own(i);
  if (moves) {
    held_ = applied;
    held_obeyed_ = obey;
    still_ = 0;
    return false;
  }
  still_ += n;
  return held_obeyed_ && still_ <= Law::longest_gap;
}

void Obedience::learn(Index i, double applied, double part) noexcept {
  const double read = applied - zero_(i), surely = applied - sure_zero_(i);
  zero_(i) += follows_ * (read - std::clamp(read, least_(i), most_(i)));
  const double low = least_(i) * (least_(i) > 0 ? 1 - short_part_ : 1 + part_);
  const double high = most_(i) * (most_(i) < 0 ? 1 - short_part_ : 1 + part_);
  sure_zero_(i) += follows_ * (surely - std::clamp(surely, low, high));
  // Of swings alone: a zero is none.
  const double asked = asked_(i) - mean_asked_(i), said = applied - mean_read_(i);
  mean_asked_(i) += part * asked;
  mean_read_(i) += part * said;
  squares_(i) = (1 - part) * (squares_(i) + part * asked * asked);
  products_(i) = (1 - part) * (products_(i) + part * asked * said);
  // What swings no more than it reads at rest tells nothing.
  const double nothing = own(i) * own(i);
  acts_(i) =
      std::clamp((products_(i) + nothing) / (squares_(i) + nothing), 1 - least_short_part, 1.0);
}

void Obedience::hear(std::int64_t n, const Ref<const VectorXd>& applied) noexcept {
  follow_commands(static_cast<double>(n));
  since_ += n;
  for (Index i = 0; i < applied.size(); ++i) {
    const double step = std::abs(applied(i) - last_(i));
    if (step > 0) step_(i) = std::min(step_(i), step);
    off_(i) = disobeys(i, applied(i));
  }
  last_ = applied;
  const bool obey = (off_.array() <= 0).all();
  // Forces that are held while others were commanded are behind where their lag would have them.
  if (are_held(n, applied, obey) && !obey) lose_track();
  const bool compares = since_ >= settles_;
  if (compares) ++n_learned_;
  const double part =
      std::max(follows_, 1 / static_cast<double>(std::max<std::int64_t>(1, n_learned_)));
  Index leg = -1;
  double furthest = 0;
  for (Index i = 0; i < applied.size(); ++i) {
    in_row_(i) = compares && off_(i) > 0 ? in_row_(i) + 1 : 0;
    if (in_row_(i) >= enough && off_(i) > furthest) {
      furthest = off_(i);
      leg = i;
    }
    // Of what disobeys nothing is learned, nor of what was on its way when nobody followed it.
    if (compares && !(off_(i) > 0)) learn(i, applied(i), part);
  }
  if (compares) leg_ = leg;
}

}  // namespace stillframe::controller

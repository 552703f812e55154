#include "controller/obedience.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "controller/slow_loops.hpp"

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
  lag_ =
      lags ? std::exp(-2 * std::numbers::pi * gains.instruments.actuator_lag_hz * sample_time_) : 0;
  const auto delay = static_cast<Index>(std::ceil(gains.delay_samples));
  commands_ = MatrixXd::Zero(m, delay + 1 + gains.instruments.report_age_samples + amplifiers_hold);
  least_ = most_ = now_least_ = now_most_ = size_ = zero_ = low_ = high_ = last_ = step_ = in_row_ =
      VectorXd::Zero(m);
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
  step_.setConstant(std::numeric_limits<double>::infinity());
  begin();
}

void Obedience::listen(const Ref<const VectorXd>& applied) noexcept {
  if (n_listened_++ == 0) low_ = high_ = last_ = applied;
  low_ = low_.cwiseMin(applied);
  high_ = high_.cwiseMax(applied);
  for (Index i = 0; i < last_.size(); ++i) {
    const double step = std::abs(applied(i) - last_(i));
    if (step > 0) step_(i) = std::min(step_(i), step);
  }
  last_ = applied;
}

void Obedience::begin() noexcept {
  commands_.setZero();
  least_.setZero();
  most_.setZero();
  size_.setZero();
  zero_ = 0.5 * (low_ + high_);
  since_ = settles_;
  in_row_.setZero();
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
  const double own = high_(i) - low_(i) + step_(i);
  return off - own - (falls_short ? short_part_ : part_) * size_(i);
}

void Obedience::hear(std::int64_t n, const Ref<const VectorXd>& applied) noexcept {
  const auto passed = static_cast<double>(n);
  now_least_ = commands_.rowwise().minCoeff();
  now_most_ = commands_.rowwise().maxCoeff();
  const double left = lag_ > 0 ? std::pow(lag_, passed) : 0;
  least_ = left * least_ + (1 - left) * now_least_;
  most_ = left * most_ + (1 - left) * now_most_;
  size_ = (std::pow(keep_, passed) * size_).cwiseMax(most_.cwiseMax(-least_));
  since_ += n;
  Index leg = -1;
  double furthest = 0;
  for (Index i = 0; i < applied.size(); ++i) {
    const double step = std::abs(applied(i) - last_(i));
    if (step > 0) step_(i) = std::min(step_(i), step);
    const double read = applied(i) - zero_(i);
    const double off = beyond(i, read);
    in_row_(i) = off > 0 ? in_row_(i) + 1 : 0;
    if (in_row_(i) >= enough && off > furthest) {
      furthest = off;
      leg = i;
    }
    // Of what disobeys nothing is learned.
    if (!(off > 0)) zero_(i) += follows_ * (read - std::clamp(read, least_(i), most_(i)));
  }
  last_ = applied;
  // What was on its way when commands were not heard, or measurements did not come.
  if (since_ < settles_) {
    in_row_.setZero();
  } else {
    leg_ = leg;
  }
}

}  // namespace stillframe::controller

#include "plant_sim/actuators.hpp"

#include <algorithm>
#include <cmath>

#include "core/numerics/infinity.hpp"
#include "core/numerics/two_pi.hpp"

namespace stillframe {

using Eigen::Index;

namespace {

constexpr double never = infinity;

}  // namespace

Actuators::Actuators(Index n_legs, double force_limit, const Instruments& instruments)
    : limit_(force_limit),
      gain_(instruments.actuator_gain),
      rate_(two_pi * instruments.actuator_lag_hz),
      rate_limit_(instruments.force_rate_limit),
      hysteresis_(instruments.hysteresis.has_value()),
      kind_(instruments.report),
      command_(Eigen::VectorXd::Zero(n_legs)),
      force_(Eigen::VectorXd::Zero(n_legs)),
      h_(Eigen::VectorXd::Zero(n_legs)),
      report_(Eigen::VectorXd::Zero(n_legs)),
      aged_(Eigen::MatrixXd::Zero(n_legs, instruments.report_age_samples + 1)) {
  if (hysteresis_) loop_ = bouc_wen(*instruments.hysteresis);
}

void Actuators::command(const Eigen::Ref<const Eigen::VectorXd>& u) noexcept {
  command_ = u.cwiseMax(-limit_).cwiseMin(limit_);
  if (lags()) return;
  for (Index leg = 0; hysteresis_ && leg < h_.size(); ++leg) {
    h_(leg) = loop_.moved(h_(leg), way(leg));
  }
  force_ = command_;
}

double Actuators::slewing_ends(Index leg) const noexcept {
  if (!slews()) return 0;
  const double alone = std::abs(way(leg)) / rate_limit_;
  return rate_ > 0 ? std::max(0.0, alone - 1 / rate_) : alone;
}

double Actuators::moved(Index leg, double t) const noexcept {
  const double end = slewing_ends(leg);
  const double slewed = std::copysign(rate_limit_ * end, way(leg));
  if (t < end) return std::copysign(rate_limit_ * t, way(leg));
  if (rate_ == 0) return way(leg);
  if (!slews()) return -way(leg) * std::expm1(-rate_ * t);
  return slewed - (way(leg) - slewed) * std::expm1(-rate_ * (t - end));
}

double Actuators::acting(Index leg, double t) const noexcept {
  if (!lags()) return settled(leg);
  if (exponential()) return settled(leg) + transient(leg) * std::exp(-rate_ * t);
  const double by = moved(leg, t), f = force_(leg) + by;
  return gain_ * (hysteresis_ ? loop_.kappa * f - loop_.moved(h_(leg), by) : f);
}

void Actuators::finish(double duration) noexcept {
  if (!lags()) return;
  if (exponential()) {
    force_ = command_ + std::exp(-rate_ * duration) * (force_ - command_);
    return;
  }
  for (Index leg = 0; leg < force_.size(); ++leg) {
    const double by = moved(leg, duration);
    if (hysteresis_) h_(leg) = loop_.moved(h_(leg), by);
    // Exactly there, so that nothing is left to slew.
    force_(leg) = by == way(leg) ? command_(leg) : force_(leg) + by;
  }
}

double Actuators::smooth_for(double duration) const noexcept {
  const double least = 1e-9 * duration;
  double smooth = duration;
  for (Index leg = 0; slews() && leg < force_.size(); ++leg) {
    const double end = slewing_ends(leg);
    if (end > least && end < duration - least) smooth = std::min(smooth, end);
  }
  return smooth;
}

double Actuators::loop_crosses(Index leg) const noexcept {
  const double H = way(leg) < 0 ? -h_(leg) : h_(leg), whole = std::abs(way(leg));
  if (!hysteresis_ || !lags() || loop_.gamma == 0 || H >= 0) return never;
  const double length = loop_.length_to_zero(H);
  if (!(length < whole)) return never;
  const double end = slewing_ends(leg), slewed = slews() ? rate_limit_ * end : 0;
  if (length <= slewed) return length / rate_limit_;
  return end - std::log1p(-(length - slewed) / (whole - slewed)) / rate_;
}

double Actuators::fastest_rate(Index leg) const noexcept {
  const double whole = std::abs(way(leg));
  const double speed = std::min(rate_limit_, rate_ > 0 ? rate_ * whole : never);
  return rate_ + (hysteresis_ ? (loop_.beta + std::abs(loop_.gamma)) * speed : 0);
}

void Actuators::sample() noexcept {
  newest_ = (newest_ + 1) % aged_.cols();
  aged_.col(newest_) = kind_ == Instruments::Report::measured ? force_ : command_;
  report_ = aged_.col((newest_ + 1) % aged_.cols());
}

}  // namespace stillframe

#include "plant_sim/actuators.hpp"

#include <cmath>
#include <numbers>

namespace stillframe {

using Eigen::Index;

Actuators::Actuators(Index n_legs, double force_limit, const Instruments& instruments)
    : limit_(force_limit),
      gain_(instruments.actuator_gain),
      rate_(2 * std::numbers::pi * instruments.actuator_lag_hz),
      kind_(instruments.report),
      command_(Eigen::VectorXd::Zero(n_legs)),
      force_(Eigen::VectorXd::Zero(n_legs)),
      report_(Eigen::VectorXd::Zero(n_legs)),
      aged_(Eigen::MatrixXd::Zero(n_legs, instruments.report_age_samples + 1)) {}

void Actuators::command(const Eigen::Ref<const Eigen::VectorXd>& u) noexcept {
  command_ = u.cwiseMax(-limit_).cwiseMin(limit_);
  if (!lags()) force_ = command_;
}

double Actuators::acting(Index leg, double t) const noexcept {
  return lags() ? settled(leg) + transient(leg) * std::exp(-rate_ * t) : settled(leg);
}

void Actuators::finish(double duration) noexcept {
  if (!lags()) return;
  force_ = command_ + std::exp(-rate_ * duration) * (force_ - command_);
}

void Actuators::sample() noexcept {
  newest_ = (newest_ + 1) % aged_.cols();
  aged_.col(newest_) = kind_ == Instruments::Report::measured ? force_ : command_;
  report_ = aged_.col((newest_ + 1) % aged_.cols());
}

}  // namespace stillframe

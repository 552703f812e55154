#include "controller/designed_loop.hpp"

#include <algorithm>

#include "core/numerics/two_pi.hpp"

namespace stillframe::controller {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Ref;
using Eigen::VectorXd;

double floor_corner(const Gains& gains) {
  constexpr double slow = 0.1, no_target_hz = 1;
  const auto& targets = gains.target_hz;
  return two_pi * slow * (targets.empty() ? no_target_hz : *std::ranges::min_element(targets));
}

DesignedLoop::DesignedLoop(const Gains& gains)
    : plant_(sample_and_hold(gains.loop_plant(floor_corner(gains)), gains.sampling())),
      law_(law_from_gains(gains)) {
  const Index m = gains.n_legs();
  Gamma_beside_ = plant_.Gamma_0 + plant_.Gamma_u;
  x_ = x_next_ = VectorXd::Zero(plant_.Phi.rows());
  w_ = w_now_ = VectorXd::Zero(n_floor());
  before_ = beside_ = excited_ = excited_before_ = u_ = last_ = sigma_ = change_ =
      VectorXd::Zero(m);
  acts_ = VectorXd::Ones(m);
  // A gains file has one delay for all legs.
  commands_ = MatrixXd::Zero(m, plant_.whole_delay.maxCoeff() + 1);
  reports_ = MatrixXd::Zero(m, plant_.report_age + 1);
}

void DesignedLoop::reset(double gain) noexcept {
  for (VectorXd* each : {&x_, &w_, &before_, &excited_, &excited_before_}) each->setZero();
  commands_.setZero();
  reports_.setZero();
  law_.reset();
  law_.rest_floor();
  gain_ = gain;
}

void DesignedLoop::push(const VectorXd& command) noexcept {
  newest_command_ = (newest_command_ + 1) % commands_.cols();
  commands_.col(newest_command_) = command;
}

void DesignedLoop::sample(const Ref<const VectorXd>& w) noexcept {
  x_next_.noalias() = plant_.Phi * x_;
  x_next_.noalias() += plant_.Gamma_w * w;
  x_next_.noalias() += plant_.Gamma_0 * before_;
  x_next_.noalias() += Gamma_beside_ * beside_;
  before_ = acts_.cwiseProduct(commands_.col((newest_command_ + 1) % commands_.cols()));
  x_next_.noalias() += plant_.Gamma_u * before_;
  x_.swap(x_next_);
  newest_report_ = (newest_report_ + 1) % reports_.cols();
  auto report = reports_.col(newest_report_);
  report.noalias() = plant_.C_report * x_;
  report.noalias() += plant_.D_report * before_;
}

const VectorXd& DesignedLoop::step(std::int64_t n, const Ref<const VectorXd>& w,
                                   const Ref<const VectorXd>& v, double gain,
                                   double share) noexcept {
  last_ = commands_.col(newest_command_);
  const std::int64_t samples = std::clamp<std::int64_t>(n, 1, longest_step);
  for (std::int64_t j = 1; j <= samples; ++j) {
    const double part = static_cast<double>(j) / static_cast<double>(samples);
    w_now_ = w_ + part * (w - w_);
    if (j > 1) push(last_);
    sample(w_now_);
  }
  w_ = w;
  sigma_ = v;
  sigma_.noalias() += plant_.C_sigma * x_;
  sigma_.noalias() += plant_.D_sigma * before_;
  sigma_.noalias() += plant_.D_sigma * beside_;
  law_.hear_floor(samples, w, share);
  law_.step_over(samples, sigma_, reports_.col((newest_report_ + 1) % reports_.cols()), u_);
  change_ = gain_ * u_ + excited_before_ - last_;
  u_ *= gain;
  u_ += excited_;
  excited_before_ = excited_;
  gain_ = gain;
  if (!change_.allFinite() || !x_.allFinite()) {
    reset(gain);
    change_.setZero();
    return change_;
  }
  push(u_);
  return change_;
}

}  // namespace stillframe::controller

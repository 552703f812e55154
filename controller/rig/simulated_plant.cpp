#include "controller/rig/simulated_plant.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/numerics/two_pi.hpp"

namespace stillframe::controller {

namespace {

constexpr Eigen::Index n_sines = 12;
constexpr double lowest_hz = 2, highest_hz = 50;

}  // namespace

SimulatedPlant::SimulatedPlant(const Gains& gains, double floor_rms)
    : SimulatedPlant(sample_and_hold(gains.loop_plant(), gains.sampling()), floor_rms) {
  has_frame_ = false;
}

SimulatedPlant::SimulatedPlant(SampledPlant plant, double floor_rms)
    : plant_(std::move(plant)), floor_rms_(floor_rms), has_frame_(true) {
  const Eigen::Index m = plant_.Gamma_u.cols();
  x_ = next_ = Eigen::VectorXd::Zero(plant_.Phi.rows());
  w_ = Eigen::VectorXd::Zero(plant_.Gamma_w.cols());
  y_ = Eigen::VectorXd::Zero(plant_.C_y.rows());
  before_ = Eigen::VectorXd::Zero(m);
  on_its_way_ = Eigen::MatrixXd::Zero(m, plant_.whole_delay(0) + 1);
  reports_ = Eigen::MatrixXd::Zero(m, plant_.report_age + 1);
  const Eigen::ArrayXd step = Eigen::ArrayXd::LinSpaced(n_sines, 0, 1);
  turn_ = two_pi * plant_.sample_time * lowest_hz * (step * std::log(highest_hz / lowest_hz)).exp();
  phase_.resize(n_sines, w_.size());
  // No two of them move together.
  for (Eigen::Index i = 0; i < phase_.size(); ++i) {
    phase_(i) = two_pi * std::fmod(0.6180339887498949 * static_cast<double>(i * i + i + 1), 1.0);
  }
}

void SimulatedPlant::read(Measurement& m) noexcept {
  m.sigma.noalias() = plant_.C_sigma * x_;
  m.sigma.noalias() += plant_.D_sigma * before_;
  m.applied.noalias() = plant_.C_report * x_;
  m.applied.noalias() += plant_.D_report * before_;
  reports_.col(k_ % reports_.cols()) = m.applied;
  m.applied = reports_.col((k_ + 1) % reports_.cols());
  m.floor.setZero();
  const Eigen::Index n = std::min(m.floor.size(), w_.size());
  m.floor.head(n) = w_.head(n);
  m.frame.setZero();
  if (has_frame_) {
    const Eigen::Index n_frame = std::min(m.frame.size(), y_.size());
    m.frame.head(n_frame) = y_.head(n_frame);
  }
}

void SimulatedPlant::advance(const Eigen::VectorXd& force) noexcept {
  const double size = floor_rms_ * std::sqrt(2.0 / n_sines);
  for (Eigen::Index i = 0; i < w_.size(); ++i) {
    w_(i) = size * (phase_.col(i) + turn_ * static_cast<double>(k_)).sin().sum();
  }
  on_its_way_.col(k_ % on_its_way_.cols()) = force;
  const auto now = on_its_way_.col((k_ + 1) % on_its_way_.cols());
  y_.noalias() = plant_.C_y * x_;
  y_.noalias() += plant_.D_yw * w_;
  y_.noalias() += plant_.D_0 * before_;
  y_.noalias() += plant_.D_yu * now;
  next_.noalias() = plant_.Phi * x_;
  next_.noalias() += plant_.Gamma_w * w_;
  next_.noalias() += plant_.Gamma_0 * before_;
  next_.noalias() += plant_.Gamma_u * now;
  x_.swap(next_);
  before_ = now;
  ++k_;
}

}  // namespace stillframe::controller

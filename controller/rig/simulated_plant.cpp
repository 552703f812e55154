#include "controller/rig/simulated_plant.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/numerics/two_pi.hpp"

namespace stillframe::controller {

namespace {

constexpr double lowest_hz = 2, highest_hz = 50, settled_s = 5;

}  // namespace

Tremor::Tremor(double rms, Eigen::Index n, double sample_time, unsigned seed)
    : follows_(1 - std::exp(-two_pi * highest_hz * sample_time)),
      rests_(1 - std::exp(-two_pi * lowest_hz * sample_time)),
      random_(seed),
      states_(Eigen::ArrayXXd::Zero(n, 3)) {
  // The sum of squares after one unit of noise.
  double squares = 0;
  Eigen::ArrayXXd one = Eigen::ArrayXXd::Zero(1, 3);
  for (Eigen::Index k = 0; k < static_cast<Eigen::Index>(settled_s / sample_time) + 100; ++k) {
    const double value = step(one.row(0), k == 0 ? 1 : 0);
    squares += value * value;
  }
  size_ = rms / std::sqrt(squares);
}

double Tremor::step(
    Eigen::Ref<Eigen::Array<double, 1, Eigen::Dynamic>, 0, Eigen::InnerStride<>> state,
    double noise) const noexcept {
  state(0) += follows_ * (noise - state(0));
  state(1) += follows_ * (state(0) - state(1));
  state(2) += rests_ * (state(1) - state(2));
  return state(1) - state(2);
}

void Tremor::advance(Eigen::VectorXd& w) noexcept {
  for (Eigen::Index i = 0; i < w.size(); ++i) w(i) = step(states_.row(i), size_ * normal_(random_));
}

SimulatedPlant::SimulatedPlant(const Gains& gains, double floor_rms)
    : SimulatedPlant(sample_and_hold(gains.loop_plant(), gains.sampling()), floor_rms) {
  has_frame_ = false;
}

SimulatedPlant::SimulatedPlant(SampledPlant plant, double floor_rms, unsigned seed)
    : plant_(std::move(plant)),
      floor_(floor_rms, plant_.Gamma_w.cols(), plant_.sample_time, seed),
      has_frame_(true) {
  const Eigen::Index m = plant_.Gamma_u.cols();
  x_ = next_ = Eigen::VectorXd::Zero(plant_.Phi.rows());
  w_ = Eigen::VectorXd::Zero(plant_.Gamma_w.cols());
  y_ = Eigen::VectorXd::Zero(plant_.C_y.rows());
  before_ = Eigen::VectorXd::Zero(m);
  on_its_way_ = Eigen::MatrixXd::Zero(m, plant_.whole_delay(0) + 1);
  reports_ = Eigen::MatrixXd::Zero(m, plant_.report_age + 1);
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
  floor_.advance(w_);
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

#include "tests/plant_sim/nodal_reference.hpp"

#include <gtest/gtest.h>

namespace stillframe::test {

using Eigen::VectorXd;

HeldInputs::HeldInputs(const Model& model)
    : position(model.q_r_0),
      rate(model.q_r_dot_0),
      acceleration(model.q_r_ddot_0),
      sigma_a(VectorXd::Zero(model.n_e)) {}

void HeldInputs::at(double t, VectorXd& q_r, VectorXd& q_r_dot, VectorXd& q_r_ddot,
                    VectorXd& sigma) const noexcept {
  q_r = position + t * (rate + 0.5 * t * acceleration);
  q_r_dot = rate + t * acceleration;
  q_r_ddot = acceleration;
  sigma = sigma_a;
}

void HeldInputs::finish(double duration) {
  position += duration * (rate + 0.5 * duration * acceleration);
  rate += duration * acceleration;
}

MinimalMotion::MinimalMotion(const Model& model, const MotionState& state, const VectorXd& x)
    : model_(model), data_(model), state_(state), y_(2 * model.n_d) {
  data_.x = x;
  y_ << state.q_d, state.q_d_dot;
  const HeldInputs inputs(model);
  rate(y_, 0, inputs);
}

VectorXd MinimalMotion::rate(const VectorXd& y, double t, const HeldInputs& inputs) {
  const Index n = model_.n_d;
  state_.q_d = y.head(n);
  state_.q_d_dot = y.tail(n);
  VectorXd sigma_a(model_.n_e), q_d_ddot(n);
  inputs.at(t, state_.q_r, state_.q_r_dot, state_.q_r_ddot, sigma_a);
  EXPECT_EQ(accelerations(model_, data_, state_, sigma_a, q_d_ddot), DynamicsStatus::ok);
  VectorXd result(2 * n);
  result << state_.q_d_dot, q_d_ddot;
  return result;
}

void MinimalMotion::advance(const HeldInputs& inputs, double duration, int steps) {
  const double h = duration / steps;
  for (int k = 0; k < steps; ++k) {
    const double t = k * h;
    const VectorXd k1 = rate(y_, t, inputs), k2 = rate(y_ + 0.5 * h * k1, t + 0.5 * h, inputs),
                   k3 = rate(y_ + 0.5 * h * k2, t + 0.5 * h, inputs),
                   k4 = rate(y_ + h * k3, t + h, inputs);
    y_ += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }
  rate(y_, duration, inputs);
  reaction_stresses(model_, data_);
}

double MinimalMotion::energy() const {
  return kinetic_energy(model_, data_) + potential_energy(model_, data_);
}

}  // namespace stillframe::test

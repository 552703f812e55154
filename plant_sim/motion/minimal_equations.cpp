#include "plant_sim/motion/minimal_equations.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

#include "core/yaml/input_error.hpp"

namespace stillframe {

double largest_stiffness(const Model& model, const std::vector<Index>& rows) {
  double largest = 0;
  for (const Index row : rows) {
    const auto [element, i] = model.owner_of_row(row);
    const LocalStiffness& S = model.elements[element].S;
    if (S.size() > 0) largest = std::max(largest, S(i, i));
  }
  return largest > 0 ? largest : 1;
}

MinimalEquations::MinimalEquations(const Model& model, const Equilibrium& rest,
                                   std::vector<Index> legs, double filter_rate)
    : model_(model),
      legs_(std::move(legs)),
      filter_rate_(filter_rate),
      stress_scale_(largest_stiffness(model, legs_)),
      data_(model),
      state_(model),
      q_0_(rest.motion.state.q_d),
      sigma_a_(Eigen::VectorXd::Zero(model.n_e)),
      q_d_ddot_(Eigen::VectorXd::Zero(model.n_d)) {
  data_.x = rest.motion.x;
  accelerations(model, data_, rest.motion.state, sigma_a_, q_d_ddot_);
  rest_acceleration_ = q_d_ddot_.lpNorm<Eigen::Infinity>();
  sigma_0_ = data_.sigma;
  q_d_ddot_.setZero();
}

bool MinimalEquations::evaluate(const Inputs& inputs, double t,
                                const Eigen::Ref<const Eigen::VectorXd>& y,
                                Eigen::Ref<Eigen::VectorXd> dy_dt) noexcept {
  const Index n = n_d();
  ++evaluations_;
  state_.q_d = q_0_ + y.head(n);
  state_.q_d_dot = y.segment(n, n);
  inputs.at(t, state_.q_r, state_.q_r_dot, state_.q_r_ddot, sigma_a_);
  data_.external = inputs.external().size() > 0 ? &inputs.external() : nullptr;
  if (accelerations(model_, data_, state_, sigma_a_, q_d_ddot_) != DynamicsStatus::ok) return false;
  dy_dt.head(n) = state_.q_d_dot;
  dy_dt.segment(n, n) = q_d_ddot_;
  for (Index i = 0; i < n_filtered(); ++i) {
    dy_dt(2 * n + i) = filter_rate_ * (elastic_stress(i) / stress_scale_ - y(2 * n + i));
  }
  // What is not finite would go round in an integrator until it gives up without a reason.
  return dy_dt.allFinite();
}

bool MinimalEquations::jacobian(Eigen::MatrixXd& J) {
  const Index n = n_d();
  if (!lineariser_) {
    lineariser_ = std::make_unique<Lineariser>(model_, std::vector<SceneSignal>{}, leg_outputs());
  }
  NominalMotion nominal(model_);
  nominal.state = state_;
  nominal.q_d_ddot = q_d_ddot_;
  nominal.x = data_.x;
  const LinearModel* model = nullptr;
  try {
    model = &lineariser_->about(nominal);
  } catch (const Refusal&) {  // a position that evaluate() reached and Newton's method did not
    return false;
  }
  const LinearModel& linear = *model;
  const Eigen::LLT<Eigen::MatrixXd> M(linear.M);
  if (M.info() != Eigen::Success) return false;
  J.setZero(size(), size());
  J.block(0, n, n, n).setIdentity();
  J.block(n, 0, n, n) = -M.solve(linear.stiffness());
  J.block(n, n, n, n) = -M.solve(linear.damping());
  if (n_filtered() == 0) return true;
  const double gain = filter_rate_ / stress_scale_;
  J.block(2 * n, 0, n_filtered(), n) = gain * linear.Y_p;
  J.block(2 * n, n, n_filtered(), n) = gain * linear.Y_v;
  J.bottomRightCorner(n_filtered(), n_filtered()).diagonal().setConstant(-filter_rate_);
  return true;
}

std::vector<SceneSignal> MinimalEquations::leg_outputs() const {
  std::vector<SceneSignal> signals;
  for (const Index row : legs_) {
    const auto [element, i] = model_.owner_of_row(row);
    SceneSignal signal;
    signal.name = signal.element = model_.elements[element].name;
    signal.quantity = Quantity::stress;
    signal.mode = static_cast<int>(i) + 1;
    signals.push_back(signal);
  }
  return signals;
}

double MinimalEquations::stress(Index leg) const noexcept {
  const Index row = legs_[static_cast<size_t>(leg)];
  return data_.sigma(row) - sigma_0_(row);
}

double MinimalEquations::elastic_stress(Index leg) const noexcept {
  return stress(leg) - sigma_a_(legs_[static_cast<size_t>(leg)]);
}

}  // namespace stillframe

#include "plant_sim/motion/minimal_equations.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/dynamics.hpp"

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

MinimalEquations::MinimalEquations(const Model& model, const NominalMotion& nominal,
                                   std::vector<Index> legs, double filter_rate)
    : model_(model),
      legs_(std::move(legs)),
      filter_rate_(filter_rate),
      stress_scale_(largest_stiffness(model, legs_)),
      data_(model),
      state_(model),
      q_0_(nominal.state.q_d),
      q_dot_0_(nominal.state.q_d_dot),
      sigma_a_(Eigen::VectorXd::Zero(model.n_e)),
      q_d_ddot_(Eigen::VectorXd::Zero(model.n_d)) {
  nominal.place(data_);
  accelerations(model, data_, nominal.state, sigma_a_, q_d_ddot_);
  // Where the forces happen to cancel to the last bit, the next position has their rounding.
  Eigen::VectorXd stresses = data_.sigma.cwiseAbs();
  for (const ModelElement& item : model.elements) {
    for (Index i = 0; i < item.S.rows(); ++i) {
      for (Index k = 0; k < item.S.cols(); ++k) {
        stresses(item.row[static_cast<size_t>(i)]) +=
            std::abs(item.S(i, k) * data_.e(item.row[static_cast<size_t>(k)]));
      }
    }
  }
  Eigen::VectorXd forces = data_.DF_e.cwiseAbs().transpose() * stresses.tail(model.n_redundant) +
                           data_.DF.cwiseAbs().transpose() * data_.f.cwiseAbs();
  for (Index i = 0; i < model.n_d; ++i) {
    const Model::Dof& dof = model.dofs[static_cast<size_t>(i)];
    if (dof.is_deformation) forces(i) += stresses(dof.index);
  }
  const Eigen::VectorXd rounding =
      std::numeric_limits<double>::epsilon() *
      (data_.M_dd.llt().solve(Eigen::MatrixXd::Identity(model.n_d, model.n_d)).cwiseAbs() * forces);
  rest_acceleration_ = std::max((q_d_ddot_ - nominal.q_d_ddot).lpNorm<Eigen::Infinity>(),
                                rounding.lpNorm<Eigen::Infinity>());
  see_rounding_on_the_way(nominal);
  sigma_0_ = data_.sigma;
  reached_x_ = before_x_ = data_.x;
  reached_e_ = before_e_ = data_.e;
  q_d_ddot_ = nominal.q_d_ddot;
}

/// Beside a rotor the accelerations round anew at each of its angles, also where no force acts. All
/// that they are there besides those of the operating point, which is stationary, is rounding, or
/// what the equilibrium has left, which is not.
void MinimalEquations::see_rounding_on_the_way(const NominalMotion& nominal) {
  const MotionState& begin = nominal.state;
  const double fastest = begin.q_r_dot.size() > 0 ? begin.q_r_dot.lpNorm<Eigen::Infinity>() : 0.0;
  if (model_.operating_point == OperatingPoint::as_written || fastest == 0 ||
      !begin.q_d_dot.isZero(0)) {
    return;
  }
  MotionState at = begin;
  for (const double angle : {0.3, 0.8, 1.7, 2.9}) {  // no two of them alike for a rotor's blades
    MotionState next = begin;
    next.q_r += angle / fastest * begin.q_r_dot;
    if (!travel(model_, data_, at, next)) break;
    at = next;
    if (accelerations(model_, data_, at, sigma_a_, q_d_ddot_) != DynamicsStatus::ok) break;
    const double seen = (q_d_ddot_ - nominal.q_d_ddot).lpNorm<Eigen::Infinity>();
    constexpr double most = 1e-11;  // of a rotor's accelerations, by way of an ill-conditioned J
    rest_acceleration_ = std::max(
        rest_acceleration_, std::min(seen, most * data_.x_ddot.lpNorm<Eigen::Infinity>()));
  }
  nominal.place(data_);
  accelerations(model_, data_, begin, sigma_a_, q_d_ddot_);
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
  if (accelerations(model_, data_, state_, sigma_a_, q_d_ddot_) != DynamicsStatus::ok) {
    go_back();  // where the shorter step begins that is tried next
    return false;
  }
  reached_x_ = data_.x;
  reached_e_ = data_.e;
  dy_dt.head(n) = state_.q_d_dot;
  dy_dt.segment(n, n) = q_d_ddot_;
  for (Index i = 0; i < n_filtered(); ++i) {
    dy_dt(2 * n + i) = filter_rate_ * (elastic_stress(i) / stress_scale_ - y(2 * n + i));
  }
  // What is not finite would go round in an integrator until it gives up without a reason.
  return dy_dt.allFinite();
}

bool MinimalEquations::look(const Inputs& inputs, double t,
                            const Eigen::Ref<const Eigen::VectorXd>& y,
                            Eigen::Ref<Eigen::VectorXd> dy_dt) noexcept {
  before_x_ = reached_x_;
  before_e_ = reached_e_;
  const bool found = evaluate(inputs, t, y, dy_dt);
  reached_x_ = before_x_;
  reached_e_ = before_e_;
  go_back();
  return found;
}

void MinimalEquations::go_back() noexcept {
  data_.x = reached_x_;
  data_.e = reached_e_;
  geometric_transfer_functions(model_, data_);
}

Eigen::VectorXd MinimalEquations::start() const {
  Eigen::VectorXd y = Eigen::VectorXd::Zero(size());
  y.segment(n_d(), n_d()) = q_dot_0_;
  return y;
}

bool MinimalEquations::hand_over(const Drive& drive, const Eigen::VectorXd& y,
                                 MotionSnapshot& to) noexcept {
  to.y = y;
  Eigen::VectorXd rate(y.size());
  if (!evaluate(drive, 0.0, y, rate)) return false;
  to.x = data_.x;
  to.x_dot = data_.x_dot;
  to.e = data_.e;
  return true;
}

void MinimalEquations::take_over(const MotionSnapshot& from) noexcept {
  reached_x_ = data_.x = from.x;
  reached_e_ = data_.e = from.e;
  q_d_ddot_.setZero();
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

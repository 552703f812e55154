#include "plant_sim/motion/minimal_equations.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/mechanics/dynamics.hpp"
#include "core/mechanics/model/local.hpp"

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
  const Eigen::VectorXd of_stresses = accelerations_of_rounding(stress_sizes(false));
  rest_acceleration_ = std::max((q_d_ddot_ - nominal.q_d_ddot).lpNorm<Eigen::Infinity>(),
                                of_stresses.lpNorm<Eigen::Infinity>());
  rounding_ = accelerations_of_rounding(stress_sizes(true));
  see_rounding_on_the_way(nominal);
  sigma_0_ = data_.sigma;
  branch_ = data_.J.sign();
  reached_x_ = before_x_ = kept_x_ = data_.x;
  reached_e_ = before_e_ = kept_e_ = data_.e;
  q_d_ddot_ = nominal.q_d_ddot;
}

/// What stresses are sums of (n_e, N): themselves, what each deformation makes of them, and, if
/// asked for, what each displacement of a node does, of which a light and stiff element leaves
/// little where both its ends have come far.
Eigen::VectorXd MinimalEquations::stress_sizes(bool of_displacements) const {
  Eigen::VectorXd sizes = data_.sigma.cwiseAbs();
  LocalVector u;
  for (size_t k = 0; k < model_.elements.size(); ++k) {
    const ModelElement& item = model_.elements[k];
    if (item.S.size() == 0) continue;
    Eigen::VectorXd e(item.S.cols());
    for (Index j = 0; j < e.size(); ++j) e(j) = std::abs(data_.e(item.row[static_cast<size_t>(j)]));
    if (of_displacements) {
      gather(item.parts, data_.x, u);
      e += data_.D[k].cwiseAbs() * u.cwiseAbs();
    }
    const Eigen::VectorXd of_element = item.S.cwiseAbs() * e;
    for (Index i = 0; i < e.size(); ++i) sizes(item.row[static_cast<size_t>(i)]) += of_element(i);
  }
  return sizes;
}

/// Of stresses of these sizes (n_e): of each q''^d (n_d).
Eigen::VectorXd MinimalEquations::accelerations_of_rounding(const Eigen::VectorXd& stresses) const {
  Eigen::VectorXd forces = data_.DF_e.cwiseAbs().transpose() * stresses.tail(model_.n_redundant) +
                           data_.DF.cwiseAbs().transpose() * data_.f.cwiseAbs();
  for (Index i = 0; i < model_.n_d; ++i) {
    const Model::Dof& dof = model_.dofs[static_cast<size_t>(i)];
    if (dof.is_deformation) forces(i) += stresses(dof.index);
  }
  const auto identity = Eigen::MatrixXd::Identity(model_.n_d, model_.n_d);
  return std::numeric_limits<double>::epsilon() *
         (data_.M_dd.llt().solve(identity).cwiseAbs() * forces);
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
    rest_acceleration_ =
        std::max(rest_acceleration_, std::min(seen, most * data_.x_ddot.lpNorm<Eigen::Infinity>()));
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
  if (!solve()) {
    // What an attempt that came to nothing has found may be far from the motion.
    go_back();
    if (!solve()) {
      go_back();  // where the shorter step begins that is tried next
      return false;
    }
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
  return_to(reached_x_, reached_e_);
  return found;
}

bool MinimalEquations::solve() noexcept {
  // Newton's method may find the same dofs on the other side of a dead point, where J is singular.
  return accelerations(model_, data_, state_, sigma_a_, q_d_ddot_) == DynamicsStatus::ok &&
         data_.J.sign() == branch_;
}

void MinimalEquations::keep() noexcept {
  kept_x_ = reached_x_;
  kept_e_ = reached_e_;
}

void MinimalEquations::go_back() noexcept { return_to(kept_x_, kept_e_); }

void MinimalEquations::return_to(const Eigen::VectorXd& x, const Eigen::VectorXd& e) noexcept {
  data_.x = x;
  data_.e = e;
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
  reached_x_ = kept_x_ = from.x;
  reached_e_ = kept_e_ = from.e;
  // Another formulation may have gone through a dead point.
  go_back();
  branch_ = data_.J.sign();
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

#include "core/equilibrium.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/dynamics.hpp"
#include "core/newton_solver.hpp"
#include "core/yaml/input_error.hpp"

namespace stillframe {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

bool is_moving(const MotionState& state) {
  return !state.q_d_dot.isZero(0) || !state.q_r_dot.isZero(0) || !state.q_r_ddot.isZero(0);
}

NominalMotion prescribed_motion(const Model& model, double factor) {
  NominalMotion motion(model);
  motion.state.q_r = factor * model.q_r_0;
  motion.state.q_r_dot = factor * model.q_r_dot_0;
  motion.state.q_r_ddot = factor * model.q_r_ddot_0;
  motion.moving = is_moving(motion.state);
  return motion;
}

/// f_dd and its Jacobian for one load factor. Goes from one position to the next by travel().
class Balance {
 public:
  explicit Balance(const Model& model)
      : model_(model),
        data_(model),
        lineariser_(model, {}, {}, {.mass = false, .damping = false, .stiffness = true}),
        motion_(model),
        zero_(VectorXd::Zero(model.n_e)) {}

  void set_factor(double factor) {
    data_.load_factor = factor;
    factor_ = factor;
  }
  /// f_dd at q; false if the position cannot be reached.
  bool forces(const VectorXd& q, VectorXd& f_dd) {
    NominalMotion next = prescribed_motion(model_, factor_);
    next.state.q_d = q;
    if (!travel(model_, data_, motion_.state, next.state)) return false;
    next.x = data_.x;
    motion_ = next;
    if (!generalised_forces(model_, data_, motion_.state, zero_)) return false;
    f_dd = data_.f_dd;
    return f_dd.allFinite();
  }
  /// d f_dd / d q = -(K + N + G).
  MatrixXd jacobian(const VectorXd& q) {
    VectorXd f_dd;
    if (!forces(q, f_dd)) throw Refusal("a position that was reached before cannot be reached");
    return -lineariser_.about(motion_, factor_).stiffness();
  }
  /// Where forces() was last asked for.
  const NominalMotion& motion() const { return motion_; }
  /// The largest force among those that have to balance: of loads, of stresses and of inertia. The
  /// latter as if it had its full lever on a dof: in a straight rotor none has any but rounding.
  double reference() {
    VectorXd stresses = data_.DF_e.transpose() * data_.sigma.tail(model_.n_redundant);
    for (Index i = 0; i < model_.n_d; ++i) {
      const Model::Dof& dof = model_.dofs[static_cast<size_t>(i)];
      if (dof.is_deformation) stresses(i) += data_.sigma(dof.index);
    }
    const VectorXd loads = data_.DF.transpose() * data_.f;
    const double at_rest =
        std::max(stresses.lpNorm<Eigen::Infinity>(), loads.lpNorm<Eigen::Infinity>());
    if (!motion_.moving) return at_rest;
    complete_accelerations(data_, VectorXd::Zero(model_.n_d));
    const double inertia = inertia_forces(model_, data_).head(model_.n_x).lpNorm<Eigen::Infinity>();
    return std::max(at_rest, inertia * data_.DF.lpNorm<Eigen::Infinity>());
  }

 private:
  const Model& model_;
  Data data_;
  Lineariser lineariser_;
  NominalMotion motion_;
  VectorXd zero_;
  double factor_ = 1;
};

/// One load factor: KINSOL, then plain Newton steps while they still reduce the residual.
bool balance_at(Balance& balance, double factor, VectorXd& q, int& iterations) {
  balance.set_factor(factor);
  VectorXd trial = q;
  const auto forces = [&](const VectorXd& at, VectorXd& f) { return balance.forces(at, f); };
  const auto jacobian = [&](const VectorXd& at) { return balance.jacobian(at); };
  VectorXd f(q.size());
  if (!balance.forces(trial, f)) return false;
  const double scale = std::max(balance.reference(), f.lpNorm<Eigen::Infinity>());
  if (f.lpNorm<Eigen::Infinity>() > 1e-10 * scale) {
    if (!solve_nonlinear(forces, jacobian, scale, trial, iterations)) return false;
    if (!balance.forces(trial, f)) return false;
  }
  double residual = f.lpNorm<Eigen::Infinity>();
  for (int k = 0; k < 10 && residual > 0; ++k) {
    const VectorXd next = trial - balance.jacobian(trial).partialPivLu().solve(f);
    VectorXd f_next(q.size());
    if (!next.allFinite() || !balance.forces(next, f_next)) break;
    const double left = f_next.lpNorm<Eigen::Infinity>();
    if (!(left < residual)) break;
    trial = next;
    f = f_next;
    residual = left;
    ++iterations;
  }
  // Rounding of stiff elements leaves 1e-10 of the largest force at worst; more is no equilibrium.
  if (!(residual <= 1e-7 * std::max(balance.reference(), scale))) return false;
  q = trial;
  return true;
}

}  // namespace

Equilibrium solve_equilibrium(const Model& model) {
  Balance balance(model);
  Equilibrium result{NominalMotion(model)};
  VectorXd q = VectorXd::Zero(model.n_d);
  double reached = 0, step = 1;
  // 2^-12 of the load is far below what a limit point leaves; below it the path has ended.
  while (reached < 1 && step >= 1.0 / 4096) {
    const double factor = std::min(1.0, reached + step);
    VectorXd trial = q;
    if (balance_at(balance, factor, trial, result.iterations)) {
      q = trial;
      reached = factor;
      step *= 1.5;
      if (reached < 1) ++result.load_steps;
    } else {
      step *= step == 1.0 ? 0.125 : 0.5;
    }
  }
  if (reached < 1) {
    char text[64];
    std::snprintf(text, sizeof text, "%.4g", reached);
    throw Refusal(std::string("no equilibrium found: the loads can be followed up to ") + text +
                  " of their size; beyond, the configuration collapses (a limit or buckling load) "
                  "or nothing resists");
  }
  VectorXd f(model.n_d);
  balance.forces(q, f);
  result.motion = balance.motion();
  result.residual = f.lpNorm<Eigen::Infinity>();
  result.reference = balance.reference();
  return result;
}

NominalMotion nominal_motion(const Scene& scene, const Model& model) {
  if (scene.operating_point == OperatingPoint::equilibrium) {
    return solve_equilibrium(model).motion;
  }
  NominalMotion motion = prescribed_motion(model, 1);
  motion.state.q_d = model.q_0;
  motion.state.q_d_dot = model.q_dot_0;
  Data data(model);
  if (!travel(model, data, MotionState(model), motion.state)) {
    throw Refusal(
        "the operating point as written cannot be reached from the positions of the "
        "nodes; choose smaller values");
  }
  motion.x = data.x;
  switch (accelerations(model, data, motion.state, VectorXd::Zero(model.n_e), motion.q_d_ddot)) {
    case DynamicsStatus::position_not_found:
      throw Refusal("the operating point as written cannot be reached");
    case DynamicsStatus::mass_matrix_singular:
      throw Refusal("the mass matrix is singular at the operating point: a dof moves no mass");
    case DynamicsStatus::ok:
      break;
  }
  motion.moving = is_moving(motion.state) || !motion.q_d_ddot.isZero(0);
  return motion;
}

}  // namespace stillframe

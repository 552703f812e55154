#include "core/mechanics/equilibrium.hpp"

#include <algorithm>
#include <cmath>

#include "core/errors/input_error.hpp"
#include "core/mechanics/dynamics.hpp"
#include "core/mechanics/force_balance.hpp"
#include "core/mechanics/load_path.hpp"
#include "core/mechanics/stationarity.hpp"
#include "core/numerics/worst.hpp"

namespace stillframe {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// What is out of balance and its Jacobian for one load factor, as load_path.hpp asks for it. Goes
/// from one position to the next by travel(). G is that of the stresses which the last step was to
/// lead to, as if they were unknowns as well (as in the mixed form, core/mechanics/sparse): where a
/// stiff element turns, it is not that it is strained on the way which decides how far a step may
/// go.
class ForceBalance {
 public:
  struct State {
    VectorXd q;
    NominalMotion motion;
  };
  /// loads: of loads, gravity and preloads at the full load factor; rates: of the prescribed
  /// motion.
  ForceBalance(const Model& model, double loads, double rates)
      : model_(model),
        data_(model),
        lineariser_(model, {}, {}, {.mass = false, .damping = false, .stiffness = true}),
        at_{VectorXd::Zero(model.n_d), NominalMotion(model)},
        f_(model.n_d),
        ahead_(VectorXd::Zero(model.n_e)),
        loads_(loads),
        rates_(rates),
        along_{VectorXd::Zero(model.n_d), VectorXd::Zero(model.n_d)} {}

  void set_factor(double factor) {
    data_.load_factor = factor * loads_;
    factor_ = factor;
    ahead_.setZero();
  }
  void go_along(const Rates& rates) { along_ = rates; }
  bool forces() {
    NominalMotion next(model_);
    next.state.q_d = at_.q;
    next.state.q_d_dot = along_.velocity;
    next.state.q_r = factor_ * model_.q_r_0;
    next.state.q_r_dot = factor_ * rates_ * model_.q_r_dot_0;
    next.state.q_r_ddot = factor_ * rates_ * model_.q_r_ddot_0;
    next.q_d_ddot = along_.acceleration;
    if (!travel(model_, data_, at_.motion.state, next.state)) return false;
    next.x = data_.x;
    next.e = data_.e;
    at_.motion = std::move(next);
    return out_of_balance(model_, data_, at_.motion, f_);
  }
  bool solve() {
    K_ = lineariser_.about(at_.motion, data_.load_factor, ahead_).stiffness();
    step_ = motion_against(K_, f_);
    return true;
  }
  /// By the last step's stiffness, which was short where Newton's method has contracted.
  Index n_negative() const { return stillframe::n_negative(K_); }
  double length() const { return largest_move(model_, data_.DF * step_); }
  double length_now() const {
    return largest_move(model_, data_.DF * step_, scene_size(model_, data_.x));
  }
  static const VectorXd& position(const State& state) { return state.motion.x; }
  double way(const VectorXd& x) const { return largest_move(model_, x); }
  bool take() {
    VectorXd strains = VectorXd::Zero(model_.n_e), expected = data_.sigma;
    strains.tail(model_.n_redundant) = data_.DF_e * step_;
    add_element_stresses(model_, strains, VectorXd::Zero(model_.n_e), expected);
    at_.q += step_;
    if (!forces()) return false;
    ahead_.tail(model_.n_redundant) = (expected - data_.sigma).tail(model_.n_redundant);
    return true;
  }
  bool holds() {
    const double work = largest_work(model_, data_, f_);
    return work <= 1e-7 * largest_balanced_work(model_, data_, at_.motion) ||
           work <= work_of_rounding(model_, data_, linear().stiffness());
  }
  const State& state() const { return at_; }
  void return_to(const State& state) {
    at_ = state;
    at_.motion.place(data_);
  }
  /// K + N + G = -d f / d q where forces() was last asked for.
  const LinearModel& linear() { return lineariser_.about(at_.motion, data_.load_factor); }
  const NominalMotion& motion() const { return at_.motion; }
  const VectorXd& out() const { return f_; }
  double reference() { return largest_balanced_force(model_, data_, at_.motion); }

 private:
  const Model& model_;
  Data data_;
  Lineariser lineariser_;
  State at_;
  VectorXd f_, step_, ahead_;
  MatrixXd K_;
  double loads_, rates_;
  Rates along_;
  double factor_ = 1;
};

/// Follows the loads from zero, all of them or not at all.
LoadPath follow(const Model& model, ForceBalance& balance) {
  const LoadPath path = follow_loads(balance);
  if (path.reached == 1) return path;
  if (path.reached > 0) {
    const bool bends = std::any_of(model.dofs.begin(), model.dofs.end(),
                                   [](const Model::Dof& dof) { return dof.is_deformation; });
    refuse_load(path, largest_move_in_words(model, balance.motion().x) +
                          (bends ? "; a beam that is a dof cannot bend by a quarter turn: divide "
                                   "it more finely, or let dofs be auto"
                                 : ""));
  }
  const std::string dof = unresisted_dof(model, -ForceBalance(model, 0, 0).linear().stiffness());
  refuse_any_load(dof.empty() ? "" : "dof " + dof);
}

/// Where positions are dofs, the balance at q'^d = 0 is not that of what goes along: it strains and
/// shears the springs and dampers between them.
void go_along(const Model& model, ForceBalance& balance, int& iterations) {
  if (model.q_r_dot_0.isZero(0) && model.q_r_ddot_0.isZero(0)) return;
  Rates before{VectorXd::Zero(model.n_d), VectorXd::Zero(model.n_d)};
  // The rates are linear in themselves but for what they do to the balance; what has not settled
  // after a few rounds is no stationary motion, which is found out afterwards.
  for (int k = 0; k < 10; ++k) {
    const Rates rates = rates_along(model, balance.motion());
    const double change = worst_of(worst_of(rates.velocity - before.velocity),
                                   worst_of(rates.acceleration - before.acceleration)),
                 size = worst_of(worst_of(rates.velocity), worst_of(rates.acceleration));
    if (change <= 1e-12 * size) return;
    balance.go_along(rates);
    if (!balance_at(balance, 1, iterations)) return;
    before = rates;
  }
}

}  // namespace

Equilibrium solve_equilibrium(const Model& model) {
  ForceBalance balance(model, 1, 1);
  const LoadPath path = follow(model, balance);
  Equilibrium result{NominalMotion(model)};
  result.iterations = path.iterations;
  result.load_steps = path.load_steps;
  balance.forces();
  go_along(model, balance, result.iterations);
  balance.forces();
  result.motion = balance.motion();
  result.residual = worst_of(balance.out());
  result.reference = balance.reference();
  require_stationary(model, result.motion, {}, {});
  return result;
}

NominalMotion unloaded_position(const Model& model) {
  ForceBalance balance(model, 0, 0);
  follow(model, balance);
  balance.forces();
  return balance.motion();
}

}  // namespace stillframe

#include "core/mechanics/equilibrium.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "core/errors/input_error.hpp"
#include "core/mechanics/force_balance.hpp"
#include "core/mechanics/stationarity.hpp"
#include "core/numerics/worst.hpp"

namespace stillframe {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// What is out of balance and its Jacobian for one load factor. Goes from one position to the next
/// by travel().
class ForceBalance {
 public:
  /// loads: of loads, gravity and preloads at the full load factor; rates: of the prescribed
  /// motion.
  ForceBalance(const Model& model, double loads, double rates)
      : model_(model),
        data_(model),
        lineariser_(model, {}, {}, {.mass = false, .damping = false, .stiffness = true}),
        motion_(model),
        loads_(loads),
        rates_(rates),
        along_{VectorXd::Zero(model.n_d), VectorXd::Zero(model.n_d)} {}

  void set_factor(double factor) {
    data_.load_factor = factor * loads_;
    factor_ = factor;
  }
  void go_along(const Rates& rates) { along_ = rates; }
  /// What is out of balance at q; false if the position cannot be reached.
  bool forces(const VectorXd& q, VectorXd& f) {
    NominalMotion next(model_);
    next.state.q_d = q;
    next.state.q_d_dot = along_.velocity;
    next.state.q_r = factor_ * model_.q_r_0;
    next.state.q_r_dot = factor_ * rates_ * model_.q_r_dot_0;
    next.state.q_r_ddot = factor_ * rates_ * model_.q_r_ddot_0;
    next.q_d_ddot = along_.acceleration;
    if (!travel(model_, data_, motion_.state, next.state)) return false;
    next.x = data_.x;
    next.e = data_.e;
    motion_ = std::move(next);
    return out_of_balance(model_, data_, motion_, f);
  }
  /// K + N + G = -d f / d q where forces() was last asked for.
  const LinearModel& linear() { return lineariser_.about(motion_, data_.load_factor); }
  /// How far the nodes go in a step of the dofs, beside the size of the scene as written and as it
  /// is now.
  double length(const VectorXd& step) const { return largest_move(model_, data_.DF * step); }
  double length_now(const VectorXd& step) const {
    return largest_move(model_, data_.DF * step, scene_size(model_, data_.x));
  }
  /// Nothing but rounding is out of balance.
  bool holds(const VectorXd& f) {
    const double work = largest_work(model_, data_, f);
    return work <= 1e-7 * largest_balanced_work(model_, data_, motion_) ||
           work <= work_of_rounding(model_, data_, linear().stiffness());
  }
  const NominalMotion& motion() const { return motion_; }
  void return_to(const NominalMotion& motion) {
    motion_ = motion;
    motion_.place(data_);
  }
  double reference() { return largest_balanced_force(model_, data_, motion_); }

 private:
  const Model& model_;
  Data data_;
  Lineariser lineariser_;
  NominalMotion motion_;
  double loads_, rates_;
  Rates along_;
  double factor_ = 1;
};

/// Newton's method at one load factor, from the balance's position. The second step may be a
/// twentieth of the first at most: then all that is not linear on the way is small beside what is,
/// and no other equilibrium, nor a load at which this one ends, lies between; after that, each may
/// be a quarter of the one before (Newton and Kantorovich). Lengths are those of the nodes, so that
/// units and the choice of dofs do not matter. The first step may grow with the scene, so that a
/// long pull takes no more of them than its logarithm; the second may not.
bool contracts(ForceBalance& balance, VectorXd& q, int& iterations) {
  constexpr double at_first = 0.05, most = 0.25;
  constexpr double farthest = 0.5;   // rad, or of the scene's size: more is a guess
  constexpr double rounding = 1e-7;  // as far as rounding may leave an ill-conditioned balance
  VectorXd f(q.size());
  if (!balance.forces(q, f)) return false;
  double longest = 0;
  for (int k = 0;; ++k) {
    const VectorXd step = motion_against(balance.linear().stiffness(), f);
    if (k == 0 && !(balance.length_now(step) <= farthest)) return false;
    const double length = balance.length(step);
    if (k > 0 && !(length <= longest)) return longest <= rounding && balance.holds(f);
    q += step;
    ++iterations;
    if (!balance.forces(q, f)) return false;
    if (length == 0) return balance.holds(f);
    longest = k == 0 ? at_first * std::min(length, farthest) : most * length;
  }
}

/// One load factor; the balance stays where it was if there is no equilibrium near.
bool balance_at(ForceBalance& balance, double factor, VectorXd& q, int& iterations) {
  const NominalMotion start = balance.motion();
  balance.set_factor(factor);
  VectorXd trial = q;
  if (contracts(balance, trial, iterations)) {
    q = trial;
    return true;
  }
  balance.return_to(start);
  return false;
}

/// The dof with the largest part in a motion that nothing resists at a position, K scaled to a unit
/// diagonal so that metres and radians compare; empty if there is none.
std::string unresisted_dof(const Model& model, const MatrixXd& jacobian) {
  const VectorXd scale = jacobian.diagonal().unaryExpr(
      [](double k) { return k != 0 ? 1 / std::sqrt(std::abs(k)) : 1.0; });
  const MatrixXd K = scale.asDiagonal() * jacobian * scale.asDiagonal();
  if (!K.allFinite()) return "";
  const Eigen::BDCSVD<MatrixXd> svd(K, Eigen::ComputeFullV);
  if (svd.singularValues()(model.n_d - 1) > unresisted) return "";
  Index largest = 0;
  svd.matrixV().col(model.n_d - 1).cwiseAbs().maxCoeff(&largest);
  return model.dofs[static_cast<size_t>(largest)].name;
}

/// A share below 1 in four digits, rounded down: what was not reached is not said to be.
std::string shown_share(double share) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", share);
  if (std::strtod(text, nullptr) <= share) return text;
  const double digit = std::pow(10, std::floor(std::log10(share)) - 3);
  std::snprintf(text, sizeof text, "%.4g", share - digit);
  return text;
}

/// Attempts at a load. The hardest paths that lead somewhere take some hundred.
constexpr int most_attempts = 1000;

/// moved: n_x, at the last equilibrium.
[[noreturn]] void refuse_load(const Model& model, double reached, const VectorXd& moved,
                              int attempts) {
  if (reached > 0) {
    const std::string move = largest_move_in_words(model, moved);
    throw Refusal(
        "no equilibrium found: the loads can be followed up to " + shown_share(reached) +
        " of their size" +
        (attempts < most_attempts
             ? "; beyond, the configuration collapses (a limit or buckling load) or nothing resists"
             : " in " + std::to_string(most_attempts) +
                   " steps, and are far too large for what has to bear them (a wrong power of "
                   "ten?)") +
        (move.empty() ? "" : "; there, " + move));
  }
  const std::string dof = unresisted_dof(model, -ForceBalance(model, 0, 0).linear().stiffness());
  if (dof.empty()) {
    throw Refusal(
        "no equilibrium found: not even a small part of the loads can be balanced, from the scene "
        "as written or near it");
  }
  throw Refusal("no equilibrium found: the scene is a mechanism, nothing resists a motion of dof " +
                dof +
                ", and the loads push it; hold it, give it a stiffness, or write the scene where "
                "it hangs");
}

/// Follows the loads from zero. Adds to iterations and load_steps.
void follow(const Model& model, ForceBalance& balance, VectorXd& q, Equilibrium& result) {
  double reached = 0, step = 1;
  int attempts = 0;
  // Towards a limit load steps shrink as what is left of it does, to a tenth or so; 2^-16 of the
  // load is where the path has ended. The first step may be as small as a load is large.
  while (reached < 1 && step >= (reached > 0 ? 0x1p-16 * reached : 0x1p-40) &&
         attempts < most_attempts) {
    ++attempts;
    const double factor = std::min(1.0, reached + step);
    VectorXd trial = q;
    if (balance_at(balance, factor, trial, result.iterations)) {
      q = trial;
      reached = factor;
      step *= 2;
      if (reached < 1) ++result.load_steps;
    } else {
      step *= step == 1.0 ? 0.125 : 0.5;
    }
  }
  if (reached < 1) refuse_load(model, reached, balance.motion().x, attempts);
}

/// Where positions are dofs, the balance at q'^d = 0 is not that of what goes along: it strains and
/// shears the springs and dampers between them.
void go_along(const Model& model, ForceBalance& balance, VectorXd& q, Equilibrium& result) {
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
    VectorXd trial = q;
    if (!balance_at(balance, 1, trial, result.iterations)) return;
    q = trial;
    before = rates;
  }
}

}  // namespace

Equilibrium solve_equilibrium(const Model& model) {
  ForceBalance balance(model, 1, 1);
  Equilibrium result{NominalMotion(model)};
  VectorXd q = VectorXd::Zero(model.n_d), f(model.n_d);
  follow(model, balance, q, result);
  balance.forces(q, f);
  go_along(model, balance, q, result);
  balance.forces(q, f);
  result.motion = balance.motion();
  result.residual = worst_of(f);
  result.reference = balance.reference();
  require_stationary(model, result.motion, {}, {});
  return result;
}

NominalMotion unloaded_position(const Model& model) {
  ForceBalance balance(model, 0, 0);
  Equilibrium result{NominalMotion(model)};
  VectorXd q = VectorXd::Zero(model.n_d), f(model.n_d);
  follow(model, balance, q, result);
  balance.forces(q, f);
  return balance.motion();
}

}  // namespace stillframe

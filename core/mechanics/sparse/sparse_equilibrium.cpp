#include "core/mechanics/sparse/sparse_equilibrium.hpp"

#include "core/mechanics/load_path.hpp"
#include "core/mechanics/node_moves.hpp"
#include "core/mechanics/sparse/mixed_factors.hpp"
#include "core/mechanics/sparse/unresisted.hpp"
#include "core/numerics/worst.hpp"

namespace stillframe {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// As load_path.hpp asks for it.
class MixedBalance {
 public:
  using State = MixedState;
  explicit MixedBalance(const MixedModel& mixed)
      : mixed_(mixed), at_{mixed.written(0), VectorXd::Zero(mixed.n_rows())} {}

  void set_factor(double factor) {
    at_.load_factor = factor;
    at_.x.tail(mixed_.model().n_rx) = mixed_.written(factor).tail(mixed_.model().n_rx);
  }
  bool forces() {
    E_ = mixed_.strain_rows(at_.x);
    strained_ = mixed_.compliance().cwiseProduct(at_.s) - mixed_.strains(at_.x, at_.load_factor);
    applied_ = mixed_.forces(at_.x, at_.load_factor);
    out_ = applied_ - E_.transpose() * at_.s;
    return strained_.allFinite() && out_.allFinite();
  }
  bool solve() {
    if (strained_.isZero(0) && out_.isZero(0)) {  // nor need anything resist
      s_step_.setZero(strained_.size());
      x_step_.setZero(out_.size());
      return true;
    }
    factorised_ = true;
    const SparseMatrix G = mixed_.geometric_stiffness(at_);
    if (!factors_.compute(E_, mixed_.compliance(), G) &&
        !factors_.compute(E_, mixed_.compliance(), SparseMatrix(G + foundation()))) {
      return false;
    }
    factors_.solve(strained_, out_, s_step_, x_step_);
    return x_step_.allFinite();
  }
  Index n_negative() const { return factorised_ ? factors_.n_negative() : 0; }
  double length() const { return largest_move(mixed_.model(), moved()); }
  double length_now() const {
    return largest_move(mixed_.model(), moved(), scene_size(mixed_.model(), at_.x));
  }
  static const VectorXd& position(const State& state) { return state.x; }
  double way(const VectorXd& x) const { return largest_move(mixed_.model(), x); }
  bool take() {
    at_.s += s_step_;
    at_.x.head(x_step_.size()) += x_step_;
    return forces();
  }
  bool holds() const {
    return largest_work(out_) <= 1e-7 * std::max(largest_work(applied_), largest_work(borne()));
  }
  const State& state() const { return at_; }
  void return_to(const State& state) { at_ = state; }
  double residual() const { return worst_of(out_); }
  double reference() const { return std::max(worst_of(applied_), worst_of(borne())); }

 private:
  /// A stiffness of coordinates that no element touches, which leaves them in place if nothing
  /// pushes them; what is out of balance knows nothing of it.
  SparseMatrix foundation() const {
    const VectorXd own = E_.cwiseAbs2().transpose() * mixed_.stiffness();
    SparseMatrix diagonal(own.size(), own.size());
    for (Index i = 0; i < own.size(); ++i) {
      if (own(i) == 0) diagonal.insert(i, i) = own.maxCoeff();
    }
    return diagonal;
  }
  VectorXd moved() const {
    VectorXd x = VectorXd::Zero(mixed_.model().n_x);
    x.head(x_step_.size()) = x_step_;
    return x;
  }
  /// The largest of the stresses' forces on each coordinate.
  VectorXd borne() const { return E_.cwiseAbs().transpose() * at_.s.cwiseAbs(); }
  double largest_work(const VectorXd& forces) const {
    VectorXd all = VectorXd::Zero(mixed_.model().n_x);
    all.head(forces.size()) = forces;
    return largest_nodal_work(mixed_.model(), all);
  }

  const MixedModel& mixed_;
  State at_;
  SparseMatrix E_;
  VectorXd strained_, applied_, out_, s_step_, x_step_;
  MixedFactors<double> factors_;
  bool factorised_ = false;
};

}  // namespace

SparseEquilibrium sparse_equilibrium(const MixedModel& mixed) {
  MixedBalance balance(mixed);
  const LoadPath path = follow_loads(balance);
  if (path.reached == 0) {
    const MixedState start{mixed.written(0), VectorXd::Zero(mixed.n_rows())};
    refuse_any_load(
        unresisted_coordinate(mixed, mixed.strain_rows(start.x), mixed.geometric_stiffness(start)));
  }
  if (path.reached < 1) {
    refuse_load(path, largest_move_in_words(mixed.model(), balance.state().x));
  }
  balance.forces();
  return {balance.state(), balance.residual(), balance.reference(), path.iterations,
          path.load_steps};
}

}  // namespace stillframe

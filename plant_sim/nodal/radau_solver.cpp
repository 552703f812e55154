#include "plant_sim/nodal/radau_solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stillframe::nodal {

namespace {

constexpr int max_steps = 100'000;  // within one part
constexpr int max_iterations = 8;
// Part of the tolerance that Newton's method may leave.
constexpr double newton_share = 0.01;
// Steps of an undamped mode err alike and add up: each may err by its share of the part. One of
// less than that follows something that is over soon.
constexpr double least_share = 0.01;
// What an acceleration does in a part, in units of how far the rates really went: as in
// exponential_motion.cpp.
constexpr double of_change = 3;
// Contraction from which new derivatives pay: each iteration costs a residual a stage.
constexpr double slow_contraction = 0.02;

/// Of an expression, without making it a matrix first.
template <class Values>
double largest(const Eigen::MatrixBase<Values>& v) noexcept {
  return v.size() > 0 ? v.cwiseAbs().maxCoeff() : 0.0;
}

}  // namespace

RadauSolver::RadauSolver(Equations& equations, double relative_tolerance, Index stages)
    : equations_(equations),
      method_(stages),
      relative_tolerance_(relative_tolerance),
      real_(equations.factors<double>()),
      unknowns_(Eigen::MatrixXd::Zero(equations.size(), stages)),
      residuals_(unknowns_),
      before_(unknowns_),
      update_(unknowns_),
      rates_(Eigen::MatrixXd::Zero(equations.n_free(), stages)),
      moves_(rates_),
      ahead_(Eigen::MatrixXd::Zero(stages, stages)),
      r_(Eigen::VectorXd::Zero(equations.size())),
      dx_(Eigen::VectorXd::Zero(equations.n_free())),
      dv_(dx_),
      begin_rates_(dx_),
      z_(Eigen::VectorXcd::Zero(equations.size())),
      stage_(equations.zero_state()) {
  for (size_t k = 0; k < method_.mu.size(); ++k) {
    pairs_.push_back(equations.factors<std::complex<double>>());
  }
}

bool RadauSolver::renew(const NodalState& state, double h, bool derivatives) noexcept {
  if (derivatives) equations_.differentiate(state, true);
  fresh_ = derivatives;
  has_derivatives_ = true;
  factored_h_ = 0;
  if (!equations_.factorise(real_, h * method_.gamma)) return false;
  for (size_t k = 0; k < pairs_.size(); ++k) {
    if (!equations_.factorise(pairs_[k], h * method_.mu[k])) return false;
  }
  factored_h_ = h;
  return true;
}

/// The polynomial of the last step goes on, moved by the jump since its end.
void RadauSolver::predict(const NodalState& state, double h) noexcept {
  const Index n = equations_.n_free(), s = method_.c.size();
  r_ << state.x_ddot.head(n), state.lambda;
  // Further ahead than that the polynomial says nothing.
  if (previous_h_ == 0 || h > 1.5 * previous_h_) {
    unknowns_.colwise() = r_;
    return;
  }
  const double ratio = h / previous_h_;
  if (ratio != ahead_ratio_) {
    for (Index i = 0; i < s; ++i) method_.extrapolate(1 + ratio * method_.c(i), ahead_.row(i));
    ahead_ratio_ = ratio;
  }
  r_ -= before_.col(s - 1);
  unknowns_.noalias() = before_ * ahead_.transpose();
  unknowns_.colwise() += r_;
}

void RadauSolver::stage_residuals(const NodalState& start, const Inputs& inputs, double t, double h,
                                  LowPass* seen) noexcept {
  const Index n = equations_.n_free(), s = method_.c.size();
  rates_.noalias() = h * unknowns_.topRows(n) * method_.A.transpose();
  moves_.noalias() = (h * h) * unknowns_.topRows(n) * method_.A_2.transpose();
  for (Index i = 0; i < s; ++i) {
    const double since = h * method_.c(i);
    stage_.x.head(n) = start.x.head(n) + (since * start.x_dot.head(n) + moves_.col(i));
    stage_.x_dot.head(n) = start.x_dot.head(n) + rates_.col(i);
    stage_.x_ddot.head(n) = unknowns_.col(i).head(n);
    stage_.lambda = unknowns_.col(i).tail(equations_.n_held());
    equations_.take_inputs(inputs, t + since, stage_);
    equations_.residual(stage_, r_);
    residuals_.col(i) = r_;
    if (seen) seen->see(i, equations_.sigma(), equations_.sigma_a());
  }
  evaluations_ += s;
}

double RadauSolver::weigh(double position, double rate, double acceleration,
                          double change) const noexcept {
  // The smallest normal numbers keep it finite for a frame at rest on a floor at rest.
  const double scale =
      std::max(least_ * duration_, std::min(acceleration * duration_, of_change * change)) + 1e-290;
  return std::max(position / (scale * duration_ + 1e-290), rate / scale) /
         (share_ * relative_tolerance_);
}

/// How far the rates of the free coordinates went from where the part began, at the stages.
double RadauSolver::change_of_rates(const NodalState& start, double h) noexcept {
  const Index n = equations_.n_free();
  rates_.noalias() = h * unknowns_.topRows(n) * method_.A.transpose();
  dv_ = start.x_dot.head(n) - begin_rates_;
  double most = 0;
  for (Index i = 0; i < rates_.cols(); ++i) most = std::max(most, largest(rates_.col(i) + dv_));
  return most;
}

/// One step of the simplified Newton method; its size against the tolerance.
double RadauSolver::correct(const NodalState& start, double h) noexcept {
  r_.noalias() = residuals_ * method_.T_inverse_real.transpose();
  equations_.solve(real_, r_);
  update_.noalias() = r_ * method_.T_real.transpose();
  for (size_t k = 0; k < pairs_.size(); ++k) {
    const auto j = static_cast<Index>(k);
    z_.noalias() = residuals_ * method_.T_inverse.row(j).transpose();
    equations_.solve(pairs_[k], z_);
    for (Index i = 0; i < update_.cols(); ++i) {
      const std::complex<double> factor = 2.0 * method_.T(i, j);
      update_.col(i) += factor.real() * z_.real() - factor.imag() * z_.imag();
    }
  }
  unknowns_ -= update_;
  const double a = largest(update_.topRows(equations_.n_free()));
  // Where all was at rest, what these stages have found is all there is to compare with.
  const double seen = largest(unknowns_.topRows(equations_.n_free()));
  return weigh(h * h * a, h * a, std::max(acceleration_, seen),
               std::max(change_, change_of_rates(start, h)));
}

/// Local error against the tolerance: the difference to the embedded formula, whose stiff part the
/// real factors take out.
double RadauSolver::error(const NodalState& start, double h) noexcept {
  const Index n = equations_.n_free();
  const double c = h * method_.gamma;
  dv_.noalias() = h * unknowns_.topRows(n) * method_.d;
  dv_ += c * start.x_ddot.head(n);
  dx_.noalias() = (h * h) * unknowns_.topRows(n) * method_.d_A;
  r_.setZero();
  equations_.add_mass_product(dv_, r_);
  equations_.add_stiffness_product(-c, dx_, r_);
  equations_.solve(real_, r_);
  return weigh(largest(dx_ + c * r_.head(n)), largest(r_.head(n)), acceleration_, change_);
}

bool RadauSolver::solve_stages(const NodalState& start, const Inputs& inputs, double t,
                               double h) noexcept {
  predict(start, h);
  double last = 0;
  // What rounding of the accelerations leaves of the tolerance.
  const double least = std::max(
      newton_share, 64 * std::numeric_limits<double>::epsilon() / (share_ * relative_tolerance_));
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    stage_residuals(start, inputs, t, h, nullptr);
    const double size = correct(start, h);
    if (!std::isfinite(size)) return false;
    // How fast it converges is known from this step alone: matrices and motion may have changed
    // since any other. A first iteration that changes no more than may be left needs no second.
    contraction_ = iteration > 0 ? size / last : 0;
    if (size <= least) return true;
    if (iteration > 0) {
      // With the right matrices only rounding keeps it from shrinking so close to the solution.
      if (!(contraction_ < 0.9)) return fresh_ && size * share_ * relative_tolerance_ <= 1e-11;
      if (size * contraction_ / (1 - contraction_) <= newton_share) return true;
    }
    last = size;
  }
  return false;
}

RadauSolver::Outcome RadauSolver::step(NodalState& state, const Inputs& inputs, double t,
                                       double h) noexcept {
  const Index n = equations_.n_free(), s = method_.c.size();
  share_ = std::clamp(h / duration_, least_share, 1.0);
  const bool slow = contraction_ > slow_contraction && !fresh_;
  if (!has_derivatives_ || slow || std::abs(factored_h_ - h) > 1e-12 * h) {
    if (!renew(state, h, !has_derivatives_ || slow)) return Outcome::singular;
  }
  if (!solve_stages(state, inputs, t, h)) {
    if (fresh_) return Outcome::no_convergence;
    if (!renew(state, h, true)) return Outcome::singular;
    if (!solve_stages(state, inputs, t, h)) return Outcome::no_convergence;
  }
  acceleration_ = std::max(acceleration_, largest(unknowns_.topRows(n)));
  change_ = std::max(change_, change_of_rates(state, h));
  error_ = error(state, h);
  if (!(error_ <= 1)) return Outcome::too_large;
  fresh_ = false;
  if (low_pass_) {
    // Newton's method left the stresses of its last but one iterate.
    stage_residuals(state, inputs, t, h, &*low_pass_);
    low_pass_->step(h);
  }
  rates_.noalias() = h * unknowns_.topRows(n) * method_.A.transpose();
  moves_.noalias() = (h * h) * unknowns_.topRows(n) * method_.A_2.transpose();
  state.x.head(n) += h * state.x_dot.head(n) + moves_.col(s - 1);
  state.x_dot.head(n) += rates_.col(s - 1);
  state.x_ddot.head(n) = unknowns_.col(s - 1).head(n);
  state.lambda = unknowns_.col(s - 1).tail(equations_.n_held());
  before_ = unknowns_;
  previous_h_ = h;
  return Outcome::accepted;
}

Status RadauSolver::advance(NodalState& state, const Inputs& inputs, double duration,
                            double least) noexcept {
  const Index s = method_.c.size();
  duration_ = duration;
  least_ = least;
  acceleration_ = largest(state.x_ddot.head(equations_.n_free()));
  change_ = 0;
  begin_rates_ = state.x_dot.head(equations_.n_free());
  if (suggested_h_ == 0) suggested_h_ = duration;
  double t = 0;
  for (int k = 0; k < max_steps; ++k) {
    // Equal steps up to the end; 1e-9 of a step more is not worth another one.
    const double left = duration - t;
    const double parts = std::ceil(left / suggested_h_ - 1e-9);
    const double h = parts > 1 ? left / parts : left;
    if (!(h > 1e-13 * duration)) return Status::failed;
    const Outcome outcome = step(state, inputs, t, h);
    if (outcome == Outcome::singular) return Status::equations_failed;
    if (outcome == Outcome::no_convergence) {
      suggested_h_ = 0.25 * h;
      continue;
    }
    const double best =
        h * std::clamp(0.9 * std::pow(error_, -1.0 / static_cast<double>(s + 1)), 0.2, 5.0);
    if (outcome == Outcome::too_large || !std::isfinite(error_)) {
      suggested_h_ = std::isfinite(error_) ? std::min(best, 0.8 * h) : 0.25 * h;
      continue;
    }
    ++steps_;
    // A step that is a little longer is not worth new factors.
    suggested_h_ = best > 1.4 * h ? best : h;
    if (parts <= 1) return Status::ok;
    t += h;
    equations_.take_inputs(inputs, t, state);
  }
  return Status::too_many_steps;
}

}  // namespace stillframe::nodal

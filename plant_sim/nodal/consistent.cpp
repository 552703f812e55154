#include "plant_sim/nodal/consistent.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/numerics/infinity.hpp"

namespace stillframe::nodal {

namespace {

constexpr double least = 1e-30;  // m, rad and their rates, far below all that counts

double largest(const Eigen::Ref<const Eigen::VectorXd>& v) {
  return v.size() > 0 ? v.lpNorm<Eigen::Infinity>() : 0.0;
}

}  // namespace

Consistency::Consistency(Equations& equations)
    : equations_(equations),
      factors_(equations.factors<double>()),
      r_(Eigen::VectorXd::Zero(equations.size())) {}

bool Consistency::renew(const NodalState& state) noexcept {
  equations_.differentiate(state, false);
  factorised_ = equations_.factorise(factors_, 0.0);
  return factorised_;
}

/// Newton's method: errors() writes the residual, subtract() takes the step.
template <class Errors, class Subtract>
bool Consistency::iterate(const NodalState& state, const Errors& errors, const Subtract& subtract,
                          const Eigen::VectorXd& size_of, double rounding, bool linear) noexcept {
  constexpr double epsilon = std::numeric_limits<double>::epsilon();
  const Index n = equations_.n_free();
  bool fresh = false;
  if (!factorised_) {
    if (!renew(state)) return false;
    fresh = true;
  }
  double last_step = infinity;
  for (int iteration = 0; iteration < 50; ++iteration) {
    errors();
    equations_.solve(factors_, r_);
    subtract();
    const double step = largest(r_.head(n)), size = largest(size_of.head(n));
    if (!std::isfinite(step)) {
      factorised_ = false;
      return false;
    }
    // What is iterated carries a few epsilon of rounding.
    if (step <= 8 * epsilon * size || step <= rounding) return true;
    if (step > 0.1 * last_step) {
      // Where steps no longer shrink so close to the solution, they are rounding; with the right
      // factors a linear problem has nothing else that would keep them from shrinking.
      if (step <= 1e-11 * size || (fresh && (linear || step <= 1e-9 * size))) return true;
      if (!renew(state)) return false;
      fresh = true;
    }
    last_step = step;
  }
  return false;
}

bool Consistency::positions(NodalState& state) noexcept {
  if (equations_.n_held() == 0) return true;
  return iterate(
      state, [&] { equations_.position_errors(state, r_); },
      [&] { state.x.head(equations_.n_free()) -= r_.head(equations_.n_free()); }, state.x, least,
      false);
}

bool Consistency::rates(NodalState& state) noexcept {
  if (equations_.n_held() == 0) return true;
  return iterate(
      state, [&] { equations_.rate_errors(state, r_); },
      [&] { state.x_dot.head(equations_.n_free()) -= r_.head(equations_.n_free()); }, state.x_dot,
      least, true);
}

bool Consistency::accelerations(NodalState& state) noexcept {
  return iterate(
      state, [&] { equations_.residual(state, r_); },
      [&] {
        state.x_ddot.head(equations_.n_free()) -= r_.head(equations_.n_free());
        state.lambda -= r_.tail(equations_.n_held());
      },
      state.x_ddot, std::max(least, rounding_), true);
}

double Consistency::measure_rounding(const NodalState& state) {
  r_.setZero();
  r_.head(equations_.n_free()) = equations_.rounding(state);
  equations_.solve(factors_, r_);
  rounding_ = largest(r_.head(equations_.n_free()));
  return rounding_;
}

}  // namespace stillframe::nodal

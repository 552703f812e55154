#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>

#include "core/numerics/worst.hpp"

namespace stillframe::test {

namespace detail {

/// Richardson's extrapolation of values whose error is a series in h^2, h halved from one to the
/// next.
template <size_t levels>
Eigen::VectorXd extrapolate(std::array<Eigen::VectorXd, levels>& values) {
  double factor = 1;
  for (size_t order = 1; order < levels; ++order) {
    factor *= 4;
    for (size_t i = levels - 1; i >= order; --i) {
      values[i] += (values[i] - values[i - 1]) / (factor - 1);
    }
  }
  return values[levels - 1];
}

}  // namespace detail

/// df/dt at 0 by central differences with steps h, h/2, h/4, h/8, extrapolated: error of order h^8,
/// and rounding of about 8 eps |f| / h.
template <class F>
Eigen::VectorXd derivative(const F& f, double h) {
  std::array<Eigen::VectorXd, 4> values;
  for (auto& value : values) {
    value = (Eigen::VectorXd(f(h)) - Eigen::VectorXd(f(-h))) / (2 * h);
    h /= 2;
  }
  return detail::extrapolate(values);
}

/// d2f/dt2 at 0 in the same way; rounding of about 250 eps |f| / h^2.
template <class F>
Eigen::VectorXd second_derivative(const F& f, double h) {
  std::array<Eigen::VectorXd, 4> values;
  const Eigen::VectorXd middle = f(0.0);
  for (auto& value : values) {
    value = (Eigen::VectorXd(f(h)) - 2 * middle + Eigen::VectorXd(f(-h))) / (h * h);
    h /= 2;
  }
  return detail::extrapolate(values);
}

/// Largest entry of a - b against the largest of b; NaN if an entry is NaN.
template <class A, class B>
double relative_error(const A& a, const B& b) {
  return worst_of(a - b) / worst_of(b);
}

}  // namespace stillframe::test

#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "core/numerics/infinity.hpp"

namespace stillframe {

/// A derivative, and how well each entry of it is known.
struct Extrapolated {
  Eigen::VectorXd value, known_to;
};

/// d f(t)/dt at 0 of a vector function by central differences with the steps h, h / 2, ..., h / 128
/// and Richardson's extrapolation; of every entry the value in the tableau whose neighbours differ
/// least (C. J. F. Ridders, Advances in Engineering Software 4 (1982) 75-76). Error near 1e-12 of f
/// over h where f is smooth over h. The least difference may be a chance: known to is ten times
/// that, or what the rounding of f, as the three shortest steps show it, makes at the step that was
/// taken.
template <class F>
Extrapolated extrapolated_derivative(const F& f, double h) {
  constexpr int levels = 8;
  Eigen::VectorXd row[levels], previous[levels], best, error, noise, longer;
  for (int i = 0; i < levels; ++i, h /= 2) {
    const Eigen::VectorXd ahead = f(h), behind = f(-h);
    row[0] = (ahead - behind) / (2 * h);
    if (i == 0) {
      best = row[0];
      error = Eigen::VectorXd::Constant(best.size(), infinity);
      longer = Eigen::VectorXd::Ones(best.size());
    }
    double factor = 1;
    for (int k = 1; k <= i; ++k) {
      factor *= 4;
      row[k] = row[k - 1] + (row[k - 1] - previous[k - 1]) / (factor - 1);
      for (Eigen::Index j = 0; j < best.size(); ++j) {
        const double spread =
            std::max(std::abs(row[k](j) - row[k - 1](j)), std::abs(row[k](j) - previous[k - 1](j)));
        if (spread <= error(j)) {
          error(j) = spread;
          best(j) = row[k](j);
          longer(j) = std::ldexp(1.0, levels - 1 - i);
        }
      }
    }
    // Rounding is what the longest extrapolations differ by, and twice as much a level further.
    if (i >= levels - 3) {
      const Eigen::VectorXd differ = (row[i] - previous[i - 1]).cwiseAbs();
      noise = i == levels - 3 ? differ : (2 * noise).cwiseMax(differ).eval();
    }
    for (int k = 0; k <= i; ++k) previous[k] = row[k];
  }
  return {best, 10 * error.cwiseMax(noise.cwiseQuotient(longer))};
}

}  // namespace stillframe

#pragma once

#include <Eigen/Core>

namespace stillframe {

/// d f(t)/dt at 0 of a vector function by central differences with the steps h, h / 2, ..., h / 128
/// and Richardson's extrapolation; of every entry the value in the tableau whose neighbours differ
/// least (C. J. F. Ridders, Advances in Engineering Software 4 (1982) 75-76). Error near 1e-12 of f
/// over h where f is smooth over h.
template <class F>
Eigen::VectorXd extrapolated_derivative(const F& f, double h) {
  constexpr int levels = 8;
  Eigen::VectorXd row[levels], previous[levels], best, error;
  for (int i = 0; i < levels; ++i, h /= 2) {
    const Eigen::VectorXd ahead = f(h), behind = f(-h);
    row[0] = (ahead - behind) / (2 * h);
    if (i == 0) {
      best = row[0];
      error = Eigen::VectorXd::Constant(best.size(), std::numeric_limits<double>::infinity());
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
        }
      }
    }
    for (int k = 0; k <= i; ++k) previous[k] = row[k];
  }
  return best;
}

}  // namespace stillframe

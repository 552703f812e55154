#pragma once

#include <Eigen/Core>
#include <vector>

#include "tests/design_cases/case.hpp"

// The nonlinear plant of a case under its law, in one process. Nothing here looks at the
// prediction.
namespace stillframe::test {

/// How a loop goes on, on a floor that stands still again after three samples.
struct Aftermath {
  double growth = 0;  ///< 1/s, of forces and accelerations, from the third quarter to the last
  double seconds = 0;

  bool stable() const { return growth < 0; }
};

/// Goes on for `seconds`, or until the loop has run away.
Aftermath kick(const Case& made, double seconds);

/// Singular values of T at some frequencies (whole multiples of 10 Hz, below half the rate), from a
/// multisine experiment: n_f x 6, largest first.
Eigen::MatrixXd measure(const Case& made, const std::vector<double>& frequencies_hz);

}  // namespace stillframe::test

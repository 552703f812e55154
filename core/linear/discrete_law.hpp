#pragma once

#include <Eigen/Core>

namespace stillframe {

/// A sampled feedback law as plain matrices:
///   e[k] = sigma[k] - (subtract_applied ? sigma_a,applied[k] : 0)
///   u[k] = C x[k] + D e[k],   x[k+1] = A x[k] + B e[k].
/// A: n x n, B: n x m, C: m x n, D: m x m for m legs; u and e in N. Linear, before any saturation.
struct DiscreteLaw {
  Eigen::MatrixXd A, B, C, D;
  bool subtract_applied = true;
};

}  // namespace stillframe

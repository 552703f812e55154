#include "core/numerics/stein.hpp"

#include <limits>

namespace stillframe {

using Eigen::MatrixXd;

MatrixXd solve_stein(MatrixXd A, const MatrixXd& Q) {
  constexpr int most = 60;  // a radius of 1 - 1e-16 has decayed after 2^60 samples
  MatrixXd X = Q;
  for (int k = 0; k < most; ++k) {
    const MatrixXd more = A.transpose() * X * A;
    X += more;
    if (!X.allFinite()) break;
    // What is to come is no more than about this again.
    if (more.norm() <= std::numeric_limits<double>::epsilon() / 8 * X.norm()) return X;
    A = (A * A).eval();
  }
  X.setConstant(std::numeric_limits<double>::quiet_NaN());
  return X;
}

}  // namespace stillframe

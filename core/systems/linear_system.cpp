#include "core/systems/linear_system.hpp"

#include <Eigen/LU>
#include <stdexcept>
#include <string>

namespace stillframe {

using Eigen::Index;
using Eigen::MatrixXd;

LinearSystem tustin(const LinearSystem& continuous, double sample_time) {
  if (!(sample_time > 0)) {
    throw std::invalid_argument("tustin: sample_time must be positive, got " +
                                std::to_string(sample_time));
  }
  const Index n = continuous.A.rows();
  const double half = sample_time / 2;
  const MatrixXd I = MatrixXd::Identity(n, n);
  const Eigen::PartialPivLU<MatrixXd> lu(I - half * continuous.A);
  const MatrixXd C_L = continuous.C * lu.inverse();
  return {.A = lu.solve(I + half * continuous.A),
          .B = lu.solve(continuous.B),
          .C = sample_time * C_L,
          .D = continuous.D + half * C_L * continuous.B};
}

LinearSystem in_series(const LinearSystem& first, const LinearSystem& second) {
  const Index n_1 = first.A.rows(), n_2 = second.A.rows();
  if (second.B.cols() != first.C.rows()) {
    throw std::invalid_argument("in_series: second takes " + std::to_string(second.B.cols()) +
                                " inputs, first has " + std::to_string(first.C.rows()) +
                                " outputs");
  }
  LinearSystem out;
  out.A = MatrixXd::Zero(n_1 + n_2, n_1 + n_2);
  out.A.topLeftCorner(n_1, n_1) = first.A;
  out.A.bottomLeftCorner(n_2, n_1) = second.B * first.C;
  out.A.bottomRightCorner(n_2, n_2) = second.A;
  out.B.resize(n_1 + n_2, first.B.cols());
  out.B << first.B, second.B * first.D;
  out.C.resize(second.C.rows(), n_1 + n_2);
  out.C << second.D * first.C, second.C;
  out.D = second.D * first.D;
  return out;
}

}  // namespace stillframe

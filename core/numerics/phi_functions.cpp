#include "core/numerics/phi_functions.hpp"

#include <cmath>
#include <stdexcept>

#include "core/numerics/balance.hpp"

namespace stillframe {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

/// 1 / k!
double inverse_factorial(int k) {
  double value = 1;
  for (int i = 2; i <= k; ++i) value /= i;
  return value;
}

/// phi_0 ... phi_p of a matrix of norm at most 1 / 2: phi_p from its series, the others from
/// phi_(k-1) = X phi_k + 1 / (k-1)!.
std::vector<MatrixXd> series(const MatrixXd& X, int p) {
  // 0.5^j / (j + p)! is below 1e-18 of the first term from j = 14 on.
  constexpr int terms = 14;
  const Index n = X.rows();
  const MatrixXd I = MatrixXd::Identity(n, n);
  std::vector<MatrixXd> phi(static_cast<size_t>(p) + 1);
  MatrixXd& last = phi.back();
  last = inverse_factorial(terms + p) * I;
  for (int j = terms - 1; j >= 0; --j) last = X * last + inverse_factorial(j + p) * I;
  for (int k = p; k > 0; --k) {
    const auto at = static_cast<size_t>(k);
    phi[at - 1] = X * phi[at] + inverse_factorial(k - 1) * I;
  }
  return phi;
}

/// Those of 2 X from those of X: phi_k(2 X) = 2^-k (phi_0 phi_k + sum_(j=1..k) phi_j / (k - j)!).
void double_argument(std::vector<MatrixXd>& phi) {
  const MatrixXd phi_0 = phi[0];
  for (int k = static_cast<int>(phi.size()) - 1; k >= 1; --k) {
    const auto at = static_cast<size_t>(k);
    MatrixXd sum = phi_0 * phi[at];
    for (int j = 1; j <= k; ++j) sum += inverse_factorial(k - j) * phi[static_cast<size_t>(j)];
    phi[at] = std::ldexp(1.0, -k) * sum;
  }
  phi[0] = phi_0 * phi_0;
}

}  // namespace

std::vector<MatrixXd> phi_functions(const MatrixXd& X, int p) {
  if (X.rows() != X.cols() || !X.allFinite()) {
    throw std::invalid_argument("phi_functions: expected a square matrix of finite numbers");
  }
  const Eigen::VectorXd scales = balancing_scales(X);
  const MatrixXd balanced = scales.cwiseInverse().asDiagonal() * X * scales.asDiagonal();
  const double norm = X.size() > 0 ? balanced.cwiseAbs().colwise().sum().maxCoeff() : 0;
  const int doublings = norm > 0.5 ? static_cast<int>(std::ceil(std::log2(norm / 0.5))) : 0;
  std::vector<MatrixXd> phi = series(std::ldexp(1.0, -doublings) * balanced, p);
  for (int i = 0; i < doublings; ++i) double_argument(phi);
  for (MatrixXd& matrix : phi) {
    matrix = (scales.asDiagonal() * matrix * scales.cwiseInverse().asDiagonal()).eval();
  }
  return phi;
}

MatrixXd decay_response(const MatrixXd& A, const MatrixXd& B, double rate, double tau) {
  const Index n = A.rows(), m = B.cols();
  MatrixXd X = MatrixXd::Zero(n + m, n + m);
  X.topLeftCorner(n, n) = tau * A;
  X.topRightCorner(n, m) = tau * B;
  X.bottomRightCorner(m, m).diagonal().setConstant(-rate * tau);
  return phi_functions(X, 0)[0].topRightCorner(n, m);
}

}  // namespace stillframe

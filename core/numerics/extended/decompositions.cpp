#include "core/numerics/extended/decompositions.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <complex>
#include <stdexcept>

namespace stillframe {

using Eigen::Index;

std::optional<ExtendedMatrix> cholesky_factor(const ExtendedMatrix& A) {
  const Eigen::LLT<ExtendedMatrix> factor(A);
  if (factor.info() != Eigen::Success) return std::nullopt;
  return ExtendedMatrix(factor.matrixL());
}

ExtendedMatrix forward_solve(const ExtendedMatrix& L, const ExtendedMatrix& B) {
  return L.triangularView<Eigen::Lower>().solve(B);
}

ExtendedMatrix backward_solve(const ExtendedMatrix& L, const ExtendedMatrix& B) {
  return L.transpose().triangularView<Eigen::Upper>().solve(B);
}

ExtendedMatrix solve(const ExtendedMatrix& A, const ExtendedMatrix& B) {
  return Eigen::PartialPivLU<ExtendedMatrix>(A).solve(B);
}

Orthogonalised orthogonalised(const ExtendedMatrix& A) {
  const Eigen::HouseholderQR<ExtendedMatrix> qr(A);
  const Index n = A.cols();
  return {.Q = qr.householderQ() * ExtendedMatrix::Identity(A.rows(), n),
          .R = qr.matrixQR().topRows(n).triangularView<Eigen::Upper>()};
}

SymmetricEigen symmetric_eigen(const ExtendedMatrix& A) {
  const Eigen::SelfAdjointEigenSolver<ExtendedMatrix> solver(A);
  return {.values = solver.eigenvalues(), .V = solver.eigenvectors()};
}

Eigen::VectorXcd eigenvalues(const ExtendedMatrix& A) {
  const Eigen::RealSchur<ExtendedMatrix> schur(A, false);
  if (schur.info() != Eigen::Success) {
    throw std::runtime_error("eigenvalues: the QR iterations did not converge");
  }
  const ExtendedMatrix& T = schur.matrixT();
  const Index n = T.rows();
  Eigen::VectorXcd values(n);
  for (Index i = 0; i < n; ++i) {
    if (i + 1 == n || T(i + 1, i) == 0) {
      values(i) = double(T(i, i));
      continue;
    }
    const DoubleDouble half = (T(i, i) - T(i + 1, i + 1)) / 2;
    const DoubleDouble square = half * half + T(i, i + 1) * T(i + 1, i);
    values(i) = {double(T(i + 1, i + 1) + half), double(sqrt(abs(square)))};
    values(i + 1) = std::conj(values(i));
    ++i;
  }
  std::stable_sort(values.begin(), values.end(),
                   [](auto a, auto b) { return std::abs(a) < std::abs(b); });
  return values;
}

}  // namespace stillframe

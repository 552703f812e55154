#include "core/mechanics/sparse/mixed_factors.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

namespace stillframe {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// Of a chain of rigid beams some 1e-2 of the largest, of conditions that are not independent
/// rounding.
constexpr double least_pivot = 1e-14;

/// Whether the rows without compliance are linearly independent.
template <class Vector>
bool independent(const SparseMatrix& E, const Vector& compliance) {
  std::vector<Index> number(static_cast<size_t>(E.rows()), -1);
  Index n = 0;
  for (Index i = 0; i < E.rows(); ++i) {
    if (compliance(i) == typename Vector::Scalar(0)) number[static_cast<size_t>(i)] = n++;
  }
  VectorXd squares = VectorXd::Zero(n);
  std::vector<Eigen::Triplet<long double>> entries;
  for (Index j = 0; j < E.cols(); ++j) {
    for (SparseMatrix::InnerIterator it(E, j); it; ++it) {
      const Index row = number[static_cast<size_t>(it.row())];
      if (row < 0) continue;
      squares(row) += it.value() * it.value();
      entries.emplace_back(row, j, it.value());
    }
  }
  if (n == 0) return true;
  if (squares.minCoeff() == 0) return false;
  using Long = Eigen::SparseMatrix<long double>;
  Long rows(n, E.cols());
  rows.setFromTriplets(entries.begin(), entries.end());
  rows = (squares.cwiseSqrt().cwiseInverse().cast<long double>().asDiagonal() * rows).eval();
  const Eigen::SimplicialLDLT<Long> factors(Long(rows * rows.transpose()));
  return factors.info() == Eigen::Success && factors.vectorD().minCoeff() > least_pivot;
}

/// A stiffness for every compliance: where there is none, that of a fraction of the others', or
/// what a thousandth of it would still hold together against inertia, `largest` of A.
template <class Vector>
Vector stiffness_of(const Vector& compliance, double largest) {
  std::vector<double> sizes;
  for (const auto& c : compliance) {
    if (std::abs(c) > 0) sizes.push_back(std::abs(c));
  }
  double nearly_rigid = std::min(1.0, 1e-3 / std::max(largest, 1e-300));
  if (!sizes.empty()) {
    // Half of the digits are for what this does to the others, half for their own.
    constexpr double fraction = 1e-7;
    const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
    std::nth_element(sizes.begin(), middle, sizes.end());
    nearly_rigid = std::min(fraction * *middle, nearly_rigid);
  }
  return compliance.unaryExpr([&](const typename Vector::Scalar& c) {
    return typename Vector::Scalar(1) / (std::abs(c) > 0 ? c : nearly_rigid);
  });
}

/// As LDL^T takes it: of complex entries the symmetric matrix [re, im; im, -re] of (re x, -im x).
template <class Real>
Eigen::SparseMatrix<Real> as_real(Eigen::SparseMatrix<Real> K) {
  return K;
}
template <class Real>
Eigen::SparseMatrix<Real> as_real(const Eigen::SparseMatrix<std::complex<Real>>& K) {
  std::vector<Eigen::Triplet<Real>> entries;
  entries.reserve(static_cast<size_t>(4 * K.nonZeros()));
  for (Index j = 0; j < K.cols(); ++j) {
    for (typename Eigen::SparseMatrix<std::complex<Real>>::InnerIterator it(K, j); it; ++it) {
      const Index i = 2 * it.row(), k = 2 * j;
      entries.emplace_back(i, k, it.value().real());
      entries.emplace_back(i + 1, k, it.value().imag());
      entries.emplace_back(i, k + 1, it.value().imag());
      entries.emplace_back(i + 1, k + 1, -it.value().real());
    }
  }
  Eigen::SparseMatrix<Real> real(2 * K.rows(), 2 * K.cols());
  real.setFromTriplets(entries.begin(), entries.end());
  return real;
}

template <class Real, class Scalar>
struct With {
  using type = Real;
};
template <class Real, class Double>
struct With<Real, std::complex<Double>> {
  using type = std::complex<Real>;
};

}  // namespace

template <class Scalar>
template <class Real>
bool MixedFactors<Scalar>::factorise(Factors<Real>& factors) const {
  using Entry = typename With<Real, Scalar>::type;
  using Matrix = Eigen::SparseMatrix<Entry>;
  const Matrix E = E_.template cast<Entry>();
  const Eigen::Matrix<Entry, Eigen::Dynamic, 1> stiffness = stiffness_.template cast<Entry>();
  Matrix sum = Matrix(E.transpose()) * stiffness.asDiagonal() * E;
  sum += A_.template cast<Entry>();
  const auto K = as_real(std::move(sum));
  const auto n_starts = static_cast<size_t>(K.outerSize() + 1),
             n_rows = static_cast<size_t>(K.nonZeros());
  const std::vector<int> starts(K.outerIndexPtr(), K.outerIndexPtr() + n_starts),
      rows(K.innerIndexPtr(), K.innerIndexPtr() + n_rows);
  if (starts != factors.starts || rows != factors.rows) {
    factors.of.analyzePattern(K);
    factors.starts = starts;
    factors.rows = rows;
  }
  factors.of.factorize(K);
  return factors.of.info() == Eigen::Success && factors.of.vectorD().allFinite();
}

template <class Scalar>
template <class Real>
auto MixedFactors<Scalar>::solved(const Factors<Real>& factors, const Vector& right) -> Vector {
  using RealVector = Eigen::Matrix<Real, Eigen::Dynamic, 1>;
  if constexpr (std::is_same_v<Scalar, double>) {
    const RealVector x = factors.of.solve(RealVector(right.template cast<Real>()));
    return x.template cast<double>();
  } else {
    RealVector parts(2 * right.size());
    for (Index i = 0; i < right.size(); ++i) {
      parts(2 * i) = right(i).real();
      parts(2 * i + 1) = right(i).imag();
    }
    const RealVector x = factors.of.solve(parts);
    Vector found(right.size());
    for (Index i = 0; i < right.size(); ++i) {
      found(i) = {static_cast<double>(x(2 * i)), -static_cast<double>(x(2 * i + 1))};
    }
    return found;
  }
}

template <class Scalar>
auto MixedFactors<Scalar>::step(const Vector& right) const -> Vector {
  return in_long_double_ ? solved(long_double_, right) : solved(double_, right);
}

template <class Scalar>
auto MixedFactors<Scalar>::refine(const Vector& e, const Vector& f, Vector& s, Vector& x) const
    -> Refined {
  constexpr double rounding = 1e-16;
  // Of a singular matrix none of it is left; complex ones are asked for beside their eigenvalues,
  // where rounding is magnified, for a direction.
  constexpr double known = std::is_same_v<Scalar, double> ? 1e-12 : 1e-6;
  constexpr int most = 40;
  s.setZero(E_.rows());
  x.setZero(E_.cols());
  Vector strained, forces = f;
  double last = 0;
  Refined refined;
  for (int k = 0; k < most; ++k) {
    strained.noalias() = compliance_.cwiseProduct(s) - E_ * x;
    if (e.size() > 0) strained += e;
    if (k > 0) {
      forces = f;
      forces.noalias() -= E_.transpose() * s;
      forces.noalias() -= A_ * x;
    }
    const Vector d_x = step(forces + E_.transpose() * stiffness_.cwiseProduct(strained));
    const Vector d_s = stiffness_.cwiseProduct(E_ * d_x - strained);
    const double length = d_x.norm(), size = (x + d_x).norm();
    if (!std::isfinite(length)) return refined;
    // No longer shorter: rounding is all that is left, or this leads nowhere.
    if (k > 1 && !(length < 0.5 * last)) {
      refined.done = length <= known * size;
      return refined;
    }
    s += d_s;
    x += d_x;
    if (k > 0) refined.rate = std::max(refined.rate, length / last);
    if (length == 0 || (k > 0 && length * length / last <= rounding * size)) {
      refined.done = true;
      return refined;
    }
    last = length;
  }
  return refined;
}

template <class Scalar>
void MixedFactors<Scalar>::take_rows(const SparseMatrix& E, const Vector& compliance) {
  const auto same = [](const auto& a, const auto& b) {
    return a.rows() == b.rows() && a.cols() == b.cols() && a.nonZeros() == b.nonZeros();
  };
  const auto zeros = [](const Vector& c) { return (c.array() == Scalar(0)).eval(); };
  const bool known = independent_ && same(E, E_) && (E - E_).norm() == 0 &&
                     (zeros(compliance) == zeros(compliance_)).all();
  E_ = E;
  compliance_ = compliance;
  if (!known) independent_ = independent(E, compliance);
}

template <class Scalar>
bool MixedFactors<Scalar>::compute(const SparseMatrix& E, const Vector& compliance,
                                   const Eigen::SparseMatrix<Scalar>& A) {
  take_rows(E, compliance);
  A_ = A;
  stiffness_ = stiffness_of(compliance, A.rows() > 0 ? A.diagonal().cwiseAbs().maxCoeff() : 0);
  if (!independent_) return false;
  // What moves most easily has most of a solution, and is least known to the factors.
  Vector force(E.cols()), s, x;
  for (Index i = 0; i < force.size(); ++i)
    force(i) = 1 + 0.5 * std::sin(1.7 * static_cast<double>(i));
  // Two more steps of a solution cost less than factors of long double.
  constexpr double fast = 0.02;
  in_long_double_ = false;
  if (factorise(double_)) {
    const Refined refined = refine({}, force, s, x);
    if (refined.done && refined.rate <= fast) return true;
  }
  in_long_double_ = true;
  return factorise(long_double_) && refine({}, force, s, x).done;
}

template <class Scalar>
void MixedFactors<Scalar>::solve(const Vector& e, const Vector& f, Vector& s, Vector& x) const {
  refine(e, f, s, x);
}

template class MixedFactors<double>;
template class MixedFactors<std::complex<double>>;

}  // namespace stillframe

#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <initializer_list>

namespace stillframe {

/// The larger of two errors; NaN if one of them is NaN, where std::max drops it. What gathers
/// errors gathers them with this, so that what could not be computed is not certified.
inline double worst_of(double a, double b) {
  return std::isnan(a) ? a : std::isnan(b) ? b : std::max(a, b);
}

inline double worst_of(std::initializer_list<double> errors) {
  double largest = 0;
  for (const double error : errors) largest = worst_of(largest, error);
  return largest;
}

/// The largest modulus of a matrix, NaN if an entry is NaN (maxCoeff and lpNorm<Infinity> leave
/// that open), 0 if it has none.
template <class Derived>
double worst_of(const Eigen::MatrixBase<Derived>& matrix) {
  double largest = 0;
  for (Eigen::Index j = 0; j < matrix.cols(); ++j) {
    for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
      largest = worst_of(largest, std::abs(matrix(i, j)));
    }
  }
  return largest;
}

}  // namespace stillframe

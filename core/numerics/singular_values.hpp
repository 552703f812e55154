#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/numerics/lanes.hpp"

namespace stillframe {

/// Singular values of many small complex matrices of one shape, largest first: bidiagonal form by
/// reflections, then the differential qd algorithm. Several matrices go through at once, one in
/// each lane of a vector register. Rows and columns are put in order of falling size first, so that
/// small values that come from rows and columns of small scale (metres beside m/s^2) keep most of
/// their digits; otherwise the error is rounding times the largest value, as in LAPACK.
/// Values below 1e-140 of the largest entry count as zero. Source: Golub and Kahan, SIAM Journal
/// on Numerical Analysis 2 (1965) 205-224.
class SingularValues {
 public:
  /// Set-up. Errors: std::invalid_argument for a negative size.
  SingularValues(Eigen::Index rows, Eigen::Index columns);

  /// Column i of values, min(rows, columns) x count, from G[i], rows x columns; NaN where G[i] has
  /// an entry that is not finite. Fastest with count a multiple of `lanes`. Hot: noexcept, no
  /// allocation; not for two threads at once.
  void compute(const Eigen::MatrixXcd* G, Eigen::Index count,
               Eigen::Ref<Eigen::MatrixXd> values) noexcept;

 private:
  double load(const Eigen::Ref<const Eigen::MatrixXcd>& G, Eigen::Index lane) noexcept;

  void reduce_here() noexcept;
  void reduce_plain() noexcept;
  void reduce_wide() noexcept;
  void finish(Eigen::Index lane, double* values) noexcept;

  /// What the lanes left to be done one by one: rows 0 to end of q and e.
  struct Rest {
    Number *q, *e;
    Eigen::Index end;
    Number taken;
  };

  Eigen::Index m_, n_;  ///< m_ >= n_: the wide are transposed
  bool transposed_, wide_;
  Rest rest_{};
  std::vector<ComplexNumber> work_;      ///< m_ x n_, then m_
  std::vector<Number> scalars_, found_;  ///< 4 n_, n_
  std::vector<double> work_of_rest_, sizes_;
  std::vector<Eigen::Index> rows_, columns_;
};

/// The singular values of one matrix.
Eigen::VectorXd singular_values(const Eigen::MatrixXcd& matrix);

}  // namespace stillframe

#include "report/spectra/fourier.hpp"

#include <complex>
#include <kissfft/kissfft.hh>

namespace stillframe::report {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::VectorXcd;

MatrixXcd fourier(const Eigen::Ref<const Eigen::MatrixXd>& columns) {
  const Index n = columns.rows();
  MatrixXcd result(n / 2 + 1, columns.cols());
  if (n == 0) return result;
  const kissfft<double> transform(static_cast<std::size_t>(n), false);
  VectorXcd column(n), spectrum(n);
  // One by one: two real columns in one complex transform would round the smaller by the larger.
  for (Index c = 0; c < columns.cols(); ++c) {
    column = columns.col(c).cast<std::complex<double>>();
    transform.transform(column.data(), spectrum.data());
    result.col(c) = spectrum.head(n / 2 + 1);
  }
  return result;
}

Index fast_length(Index n) {
  for (; n > 1; --n) {
    Index rest = n;
    for (const Index factor : {2, 3, 5}) {
      while (rest % factor == 0) rest /= factor;
    }
    if (rest == 1) break;
  }
  return n;
}

}  // namespace stillframe::report

#include "tests/octave/difference.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <vector>

#include "core/numerics/worst.hpp"

namespace stillframe::octave {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::VectorXcd;

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

bool comparable(const MatrixXcd& a, const MatrixXcd& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() && a.allFinite() && b.allFinite();
}

/// |a - b| over `scale`, 0 where both are the same.
double relative(std::complex<double> a, std::complex<double> b, double scale) {
  return a == b ? 0 : std::abs(a - b) / scale;
}

}  // namespace

double matrix_difference(const MatrixXcd& a, const MatrixXcd& b) {
  if (!comparable(a, b)) return infinite;
  if (a.size() == 0) return 0;
  const double difference = (a - b).cwiseAbs().maxCoeff();
  return difference == 0 ? 0 : difference / b.cwiseAbs().maxCoeff();
}

double column_difference(const MatrixXcd& a, const MatrixXcd& b) {
  if (!comparable(a, b)) return infinite;
  double worst = 0;
  for (Index j = 0; j < b.cols(); ++j) {
    worst = worst_of(worst, matrix_difference(a.col(j), b.col(j)));
  }
  return worst;
}

double value_difference(const MatrixXcd& a, const MatrixXcd& b) {
  if (!comparable(a, b)) return infinite;
  double worst = 0;
  for (Index j = 0; j < b.cols(); ++j) {
    const double floor = b.rows() > 0 ? small_part * b.col(j).cwiseAbs().maxCoeff() : 0;
    for (Index i = 0; i < b.rows(); ++i) {
      worst = worst_of(worst, relative(a(i, j), b(i, j), std::max(std::abs(b(i, j)), floor)));
    }
  }
  return worst;
}

double pole_difference(const VectorXcd& a, const VectorXcd& b, double part) {
  if (!comparable(a, b)) return infinite;
  if (b.size() == 0) return 0;
  const double largest = b.cwiseAbs().maxCoeff();
  const double zero = 2 * std::sqrt(std::numeric_limits<double>::epsilon()) * largest;
  std::vector<std::complex<double>> left(a.begin(), a.end()), wanted(b.begin(), b.end());
  std::sort(wanted.begin(), wanted.end(),
            [](auto one, auto other) { return std::abs(one) > std::abs(other); });
  double worst = 0;
  for (const auto& pole : wanted) {
    const auto nearest = std::min_element(left.begin(), left.end(), [&](auto one, auto other) {
      return std::abs(one - pole) < std::abs(other - pole);
    });
    if (std::abs(pole) > zero || std::abs(*nearest) > zero) {
      const double scale = std::max(std::abs(pole), part * largest);
      worst = worst_of(worst, relative(*nearest, pole, scale));
    }
    left.erase(nearest);
  }
  return worst;
}

}  // namespace stillframe::octave

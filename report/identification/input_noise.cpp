#include "report/identification/input_noise.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <limits>

#include "core/numerics/infinity.hpp"

namespace stillframe::report {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// How many times as large a power may be as an estimate with so many complex degrees of freedom,
/// but for one estimate in a thousand: there are a hundred or so in a response.
double most_of_estimate(double dof) {
  constexpr double missed = 1e-3;
  return 2 * dof / boost::math::quantile(boost::math::chi_squared(2 * dof), missed);
}

/// The largest variance, alike in all inputs, that what the outputs leave over allows.
double largest_variance(const MatrixXcd& T, const MatrixXcd& C, const MatrixXcd& unit_share) {
  // Hermitian but for how the slopes of T go into it.
  const MatrixXcd symmetric = 0.5 * (unit_share + unit_share.adjoint());
  const Eigen::SelfAdjointEigenSolver<MatrixXcd> eigen(symmetric);
  const VectorXd u = eigen.eigenvalues();
  if (!(u.maxCoeff() > 0)) return 0;
  const MatrixXd along = (T * eigen.eigenvectors()).cwiseAbs2();
  const double all = 1 / u.maxCoeff();  // the weakest direction is noise alone
  double least = all;
  for (Index i = 0; i < T.rows(); ++i) {
    const auto left_over = [&](double q) {
      return q * (along.row(i).transpose().array() / (1 - q * u.array())).sum();
    };
    double low = 0, high = all;
    // To a part in 2^40: what is left over is known to a third at best.
    for (int n = 0; n < 40; ++n) {
      const double middle = 0.5 * (low + high);
      (left_over(middle) < C(i, i).real() ? low : high) = middle;
    }
    least = std::min(least, high);
  }
  return least;
}

}  // namespace

void find_input_share(FrequencyResponse& response, std::optional<double> density,
                      double sample_rate_hz) {
  response.input_share.clear();
  for (std::size_t l = 0; l < response.unit_noise_share.size(); ++l) {
    const MatrixXcd& unit = response.unit_noise_share[l];
    const bool known = unit.allFinite() && response.T[l].allFinite();
    double variance = std::numeric_limits<double>::quiet_NaN();
    if (known) {
      const double most = most_of_estimate(response.dof(static_cast<Index>(l)));
      variance = density ? most * *density * *density * 0.5 * sample_rate_hz
                         : largest_variance(response.T[l], most * response.noise[l], unit);
    }
    response.input_share.push_back(variance * unit);
  }
}

VectorXd input_noise_error(const FrequencyResponse& response, Index frequency) {
  const auto at = static_cast<std::size_t>(frequency);
  VectorXd error = VectorXd::Zero(response.singular_values.cols());
  if (at >= response.input_share.size()) return error;
  const MatrixXcd &S = response.input_share[at], &T = response.T[at];
  error.setConstant(infinity);
  if (!S.allFinite() || !T.allFinite()) return error;
  if (!(Eigen::JacobiSVD<MatrixXcd>(S).singularValues()(0) < largest_noise_share)) return error;
  const MatrixXcd rest = MatrixXcd::Identity(S.rows(), S.cols()) - S;
  const MatrixXcd whole = rest.transpose().partialPivLu().solve(T.transpose()).transpose();
  return (Eigen::JacobiSVD<MatrixXcd>(whole).singularValues() -
          response.singular_values.row(frequency).transpose())
      .cwiseAbs();
}

}  // namespace stillframe::report

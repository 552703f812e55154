#include "report/identification/frequency_response.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <limits>

namespace stillframe::report {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;

namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// 1 - noise / power, within 0 and 1: an estimate of nothing can come out below.
double share_explained(double noise, double power) {
  return power > 0 ? std::clamp(1 - noise / power, 0.0, 1.0) : 0.0;
}

double along(const VectorXcd& u, const MatrixXcd& covariance) {
  return (u.adjoint() * covariance * u).value().real();
}

}  // namespace

MatrixXd singular_values(const std::vector<MatrixXcd>& matrices) {
  if (matrices.empty()) return {};
  const Index n = std::min(matrices.front().rows(), matrices.front().cols());
  MatrixXd values(static_cast<Index>(matrices.size()), n);
  for (std::size_t l = 0; l < matrices.size(); ++l) {
    auto row = values.row(static_cast<Index>(l));
    if (matrices[l].allFinite()) {
      row = Eigen::JacobiSVD<MatrixXcd>(matrices[l]).singularValues().transpose();
    } else {
      row.setConstant(unknown);
    }
  }
  return values;
}

void complete(FrequencyResponse& response, double density) {
  response.singular_values = singular_values(response.T);
  const Index n_f = response.n_frequencies();
  if (n_f == 0) return;
  const Index n_y = response.T.front().rows();
  response.coherence.resize(n_f, n_y);
  response.directional_coherence.resize(n_f, response.singular_values.cols());
  response.noise_density.resize(n_f, n_y);
  for (Index l = 0; l < n_f; ++l) {
    const auto at = static_cast<std::size_t>(l);
    const MatrixXcd &C = response.noise[at], &P = response.output_power[at];
    response.noise_density.row(l) = density * C.diagonal().real().transpose();
    if (!response.T[at].allFinite()) {
      response.coherence.row(l).setConstant(unknown);
      response.directional_coherence.row(l).setConstant(unknown);
      continue;
    }
    for (Index i = 0; i < n_y; ++i) {
      response.coherence(l, i) = share_explained(C(i, i).real(), P(i, i).real());
    }
    const Eigen::JacobiSVD<MatrixXcd, Eigen::FullPivHouseholderQRPreconditioner> svd(
        response.T[at], Eigen::ComputeFullU);
    for (Index i = 0; i < response.directional_coherence.cols(); ++i) {
      const VectorXcd u = svd.matrixU().col(i);
      response.directional_coherence(l, i) = share_explained(along(u, C), along(u, P));
    }
  }
}

FrequencyResponse about_model(const FrequencyResponse& residual,
                              const std::vector<MatrixXcd>& model, double density) {
  FrequencyResponse response = residual;
  for (std::size_t l = 0; l < model.size(); ++l) {
    const Index n_y = model[l].rows(), n = n_y + model[l].cols();
    MatrixXcd answer(n_y, n);  // y less the model's answer to the inputs
    answer << MatrixXcd::Identity(n_y, n_y), -model[l];
    response.T[l] = model[l] + answer * residual.T[l].topRows(n);
    response.noise[l] = answer * residual.noise[l].topLeftCorner(n, n) * answer.adjoint();
    response.output_power[l] = residual.output_power[l].bottomRightCorner(n_y, n_y);
  }
  complete(response, density);
  return response;
}

}  // namespace stillframe::report

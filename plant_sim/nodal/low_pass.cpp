#include "plant_sim/nodal/low_pass.hpp"

#include <cmath>
#include <utility>

namespace stillframe::nodal {

using Eigen::Index;

LowPass::LowPass(std::vector<Index> rows, double rate, const Collocation& method)
    : rows_(std::move(rows)),
      rate_(rate),
      method_(method),
      stages_(Eigen::MatrixXd::Zero(static_cast<Index>(rows_.size()), method.c.size())),
      moments_(Eigen::RowVectorXd::Zero(method.c.size())),
      weights_(moments_),
      state_(Eigen::VectorXd::Zero(stages_.rows())) {}

void LowPass::see(Index i, const Eigen::VectorXd& sigma, const Eigen::VectorXd& sigma_a) noexcept {
  for (size_t k = 0; k < rows_.size(); ++k) {
    stages_(static_cast<Index>(k), i) = sigma(rows_[k]) - sigma_a(rows_[k]);
  }
}

void LowPass::start_at(const Eigen::VectorXd& sigma, const Eigen::VectorXd& sigma_a) noexcept {
  for (size_t k = 0; k < rows_.size(); ++k) {
    state_(static_cast<Index>(k)) = sigma(rows_[k]) - sigma_a(rows_[k]);
  }
}

/// Moments I_k = z int_0^1 exp(-z (1 - t)) t^k dt: I_k = 1 - k I_(k-1) / z, or while z is so small
/// that this cancels, their series z k! sum_m (-z)^m / (k + m + 1)!.
void LowPass::weigh(double z) noexcept {
  for (Index k = 0; k < moments_.size(); ++k) {
    const auto degree = static_cast<double>(k);
    if (z > 2) {
      moments_(k) = k == 0 ? -std::expm1(-z) : 1 - degree / z * moments_(k - 1);
      continue;
    }
    double term = z / (degree + 1), sum = 0;
    for (int m = 1; m <= 40; ++m) {
      sum += term;
      term *= -z / (degree + 1 + m);
    }
    moments_(k) = sum;
  }
  weights_.noalias() = moments_ * method_.coefficients;
  weighed_ = z;
}

void LowPass::step(double h) noexcept {
  const double z = rate_ * h;
  if (z != weighed_) weigh(z);
  state_ *= std::exp(-z);
  state_.noalias() += stages_ * weights_.transpose();
}

}  // namespace stillframe::nodal

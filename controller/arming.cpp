#include "controller/arming.hpp"

#include <cmath>
#include <stdexcept>

namespace stillframe::controller {

using Eigen::Index;
using Eigen::Ref;
using Eigen::VectorXd;

Arming::Arming(Index m, const Policy& policy, double sample_rate_hz)
    : n_needed_(std::llround(policy.arming_s * sample_rate_hz)),
      require_motion_(policy.require_motion),
      offset_limit_(policy.offset_limit_n),
      first_(VectorXd::Zero(m)),
      moved_(VectorXd::Zero(m)),
      sums_(Eigen::MatrixXd::Zero(m, n_batches)) {
  n_needed_ -= n_needed_ % n_batches;
  if (n_needed_ < n_batches) {
    throw std::invalid_argument("Arming: " + std::to_string(policy.arming_s) +
                                " s have fewer than " + std::to_string(n_batches) + " samples");
  }
}

void Arming::add(const Ref<const VectorXd>& sigma) noexcept {
  if (complete()) return;
  if (n_ == 0) {
    first_ = sigma;
    moved_.setZero();
    sums_.setZero();
  }
  sums_.col(n_ * n_batches / n_needed_) += sigma;
  for (Index i = 0; i < sigma.size(); ++i) {
    if (sigma(i) != first_(i)) moved_(i) = 1;
  }
  ++n_;
}

Fault Arming::judge(Ref<VectorXd> offset, Ref<VectorXd> doubt) const noexcept {
  const double batch = static_cast<double>(n_needed_) / n_batches;
  for (Index i = 0; i < offset.size(); ++i) {
    offset(i) = 0;
    if (require_motion_ && moved_(i) == 0) return Fault::not_alive;
    const double mean = sums_.row(i).mean() / batch;
    const double scatter = (sums_.row(i).array() / batch - mean).square().sum();
    const double standard_error = std::sqrt(scatter / (n_batches * (n_batches - 1)));
    doubt(i) = sure * standard_error;
    if (std::abs(mean) <= doubt(i)) continue;
    if (std::abs(mean) > offset_limit_) return Fault::offset;
    offset(i) = mean;
  }
  return Fault::none;
}

}  // namespace stillframe::controller

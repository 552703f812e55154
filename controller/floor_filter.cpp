#include "controller/floor_filter.hpp"

#include <Eigen/LU>
#include <stdexcept>

namespace stillframe::controller {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Ref;
using Eigen::VectorXd;

FloorFilter::FloorFilter(const LinearSystem& system, Index m)
    : A_(system.A.sparseView()), B_(system.B.sparseView()), C_(system.C), D_(system.D) {
  const Index n = system.A.rows(), p = system.D.cols();
  const bool fits =
      p == 0 || (system.A.cols() == n && system.B.rows() == n && system.B.cols() == p &&
                 system.C.rows() == m && system.C.cols() == n && system.D.rows() == m);
  if (!fits) throw std::invalid_argument("FloorFilter: the matrices are not those of one system");
  at_rest_ = (MatrixXd::Identity(n, n) - system.A).partialPivLu().solve(system.B);
  x_ = x_next_ = VectorXd::Zero(n);
  last_ = w_ = VectorXd::Zero(p);
  force_ = VectorXd::Zero(m);
}

void FloorFilter::hear_as(const FloorFilter& other) noexcept {
  x_ = other.x_;
  last_ = other.last_;
  force_ = other.force_;
  begun_ = other.begun_;
}

void FloorFilter::rest() noexcept {
  x_.setZero();
  last_.setZero();
  force_.setZero();
  begun_ = true;
}

void FloorFilter::step(const VectorXd& w) noexcept {
  x_next_.noalias() = A_ * x_;
  x_next_.noalias() += B_ * w;
  x_.swap(x_next_);
}

void FloorFilter::hear(std::int64_t n, const Ref<const VectorXd>& w) noexcept {
  if (n_floor() == 0 || w.size() != n_floor()) return;
  if (!begun_ || n > longest_gap) {
    last_ = w;
    x_.noalias() = at_rest_ * last_;
    begun_ = true;
  } else {
    for (std::int64_t j = 1; j < n; ++j) {
      const double part = static_cast<double>(j) / static_cast<double>(n);
      w_ = last_ + part * (w - last_);
      step(w_);
    }
    last_ = w;
  }
  force_.noalias() = C_ * x_;
  force_.noalias() += D_ * last_;
  step(last_);
}

}  // namespace stillframe::controller

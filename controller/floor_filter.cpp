#include "controller/floor_filter.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <stdexcept>

namespace stillframe::controller {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Ref;
using Eigen::VectorXd;

namespace {

constexpr double longest_mean = 1000;  // samples
// Of the force in a sample where the floor is not believed. A force that is held would be a load on
// a frame that its feedback has made soft, and a step of a few samples is one of a passive frame.
constexpr double kept = 0.9;

}  // namespace

FloorFilter::FloorFilter(const LinearSystem& system, Index m) : n_floor_(system.D.cols()) {
  const Index n = system.A.rows(), p = n_floor_;
  const bool fits =
      p == 0 || (system.A.cols() == n && system.B.rows() == n && system.B.cols() == p &&
                 system.C.rows() == m && system.C.cols() == n && system.D.rows() == m);
  if (!fits) throw std::invalid_argument("FloorFilter: the matrices are not those of one system");
  at_rest_ = (MatrixXd::Identity(n, n) - system.A).partialPivLu().solve(system.B);
  MatrixXd dynamics(n, n + p);
  if (p > 0) dynamics << system.A, system.B;
  outputs_.resize(m, n + p);
  if (p > 0) outputs_ << system.C, system.D;
  for (Index i = 0; p > 0 && i < n; ++i) {
    Index from = 0;
    const double largest = dynamics.row(i).cwiseAbs().maxCoeff(&from);
    const bool hands_on =
        largest == 1 && dynamics(i, from) == 1 && (dynamics.row(i).array() != 0).count() == 1;
    if (!hands_on) {
      summed_.push_back(i);
      for (Index j = 0; j < n + p; ++j) {
        if (dynamics(i, j) != 0) terms_.push_back({i, j, dynamics(i, j)});
      }
    } else if (!moves_.empty() && moves_.back().to + moves_.back().n == i &&
               moves_.back().from + moves_.back().n == from) {
      ++moves_.back().n;
    } else {
      moves_.push_back({i, from, 1});
    }
  }
  z_ = next_ = VectorXd::Zero(n + p);
  last_ = rest_ = VectorXd::Zero(p);
  force_ = VectorXd::Zero(m);
}

void FloorFilter::hear_as(const FloorFilter& other) noexcept {
  z_ = other.z_;
  force_ = other.force_;
  begun_ = other.begun_;
}

void FloorFilter::rest() noexcept {
  z_.setZero();
  force_.setZero();
  begun_ = true;
}

void FloorFilter::step() noexcept {
  for (const Move& move : moves_) {
    next_.segment(move.to, move.n) = z_.segment(move.from, move.n);
  }
  for (const Index row : summed_) next_(row) = 0;
  for (const Term& term : terms_) next_(term.to) += term.factor * z_(term.from);
  next_.tail(n_floor_) = z_.tail(n_floor_);
  z_.swap(next_);
}

// Between two calls x is that of the sample to come, and the floor that of the last one.
void FloorFilter::hear(std::int64_t n, const Ref<const VectorXd>& w, bool believed) noexcept {
  if (n_floor() == 0 || w.size() != n_floor()) return;
  if (!believed) {
    n_rest_ = begun_ ? 1 : std::min(n_rest_ + 1, longest_mean);
    begun_ = false;
    rest_ += (w - rest_) / n_rest_;
    force_ *= kept;
    return;
  }
  if (!begun_ || n > longest_gap) {
    if (begun_ || n_rest_ == 0) rest_ = w;
    z_.head(n_states()).noalias() = at_rest_ * rest_;
    begun_ = true;
    n_rest_ = 0;
  } else if (n > 1) {
    last_ = z_.tail(n_floor());
    for (std::int64_t j = 1; j < n; ++j) {
      const double part = static_cast<double>(j) / static_cast<double>(n);
      z_.tail(n_floor()) = last_ + part * (w - last_);
      step();
    }
  }
  z_.tail(n_floor()) = w;
  force_.noalias() = outputs_ * z_;
  step();
}

}  // namespace stillframe::controller

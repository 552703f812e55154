#include "controller/law.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace stillframe::controller {

using Eigen::Index;
using Eigen::Ref;
using Eigen::VectorXd;

DiscreteLaw law_from_gains(const Gains& gains) {
  DiscreteLaw law = gains.law ? own_law(gains.law->matrices, gains.legs, gains.law->floor)
                              : sample_law(gains.feedback(), gains.law_sampling());
  if (!gains.feed_forward.filter.empty()) {
    law.feed_forward = feed_forward_system(gains.feed_forward.filter);
  }
  return law;
}

namespace {

/// The diagonal blocks beside which A has only zeros, as (first row, rows), none but the last of
/// fewer than 8 rows: shorter products take no less time. A law of a frame is made of its modes'.
std::vector<std::pair<Index, Index>> diagonal_blocks(const Eigen::MatrixXd& A) {
  std::vector<std::pair<Index, Index>> blocks;
  const Index n = A.rows();
  Index begin = 0, reach = 0;
  for (Index i = 0; i < n; ++i) {
    for (Index j = n - 1; j > reach; --j) {
      if (A(i, j) == 0 && A(j, i) == 0) continue;
      reach = j;
      break;
    }
    if (reach > i || (i + 1 < begin + 8 && i + 1 < n)) {
      reach = std::max(reach, i + 1);
      continue;
    }
    blocks.emplace_back(begin, i + 1 - begin);
    begin = reach = i + 1;
  }
  return blocks;
}

}  // namespace

Law::Law(DiscreteLaw matrices)
    : matrices_(std::move(matrices)), floor_(matrices_.feed_forward, matrices_.D.rows()) {
  const Index n = matrices_.A.rows(), m = matrices_.D.rows(), n_in = matrices_.D.cols();
  const bool fits = matrices_.A.cols() == n && matrices_.B.rows() == n &&
                    matrices_.B.cols() == n_in && matrices_.C.rows() == m &&
                    matrices_.C.cols() == n &&
                    (n_in == m || (n_in == 2 * m && !matrices_.subtract_applied));
  if (!fits) throw std::invalid_argument("Law: the matrices are not those of one law");
  blocks_ = diagonal_blocks(matrices_.A);
  x_ = VectorXd::Zero(n);
  x_next_ = VectorXd::Zero(n);
  e_ = e_now_ = e_last_ = VectorXd::Zero(n_in);
  r_ = VectorXd::Zero(m);
}

void Law::advance() noexcept {
  for (const auto& [first, rows] : blocks_) {
    x_next_.segment(first, rows).noalias() =
        matrices_.A.block(first, first, rows, rows) * x_.segment(first, rows);
  }
  x_next_.noalias() += matrices_.B * e_;
  x_.swap(x_next_);
}

void Law::step(const Ref<const VectorXd>& sigma, const Ref<const VectorXd>& applied,
               Ref<VectorXd> force) noexcept {
  step_over(1, sigma, applied, force);
}

void Law::step_over(std::int64_t n_samples, const Ref<const VectorXd>& sigma,
                    const Ref<const VectorXd>& applied, Ref<VectorXd> force) noexcept {
  const std::int64_t n = std::clamp<std::int64_t>(n_samples, 1, longest_gap);
  e_now_.head(sigma.size()) = sigma;
  if (matrices_.hears_applied()) e_now_.tail(applied.size()) = applied;
  if (matrices_.subtract_applied) {
    // Where samples were missed, the force last reported is taken for theirs.
    const double memory = matrices_.applied_memory > 0
                              ? std::pow(matrices_.applied_memory, static_cast<double>(n))
                              : 0.0;
    r_ = memory * r_ + (1 - memory) * applied;
    e_now_ -= r_;
  }
  for (std::int64_t j = 1; j < n; ++j) {
    const double part = static_cast<double>(j) / static_cast<double>(n);
    e_ = e_last_ + part * (e_now_ - e_last_);
    advance();
  }
  e_ = e_now_;
  force.noalias() = matrices_.C * x_;
  force.noalias() += matrices_.D * e_;
  if (floor_.n_floor() > 0) force += share_ * floor_.force();
  advance();
  e_last_ = e_now_;
}

}  // namespace stillframe::controller

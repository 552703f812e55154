#include "report/analysis/loop_response.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "core/linear/smooth_step.hpp"

namespace stillframe::report {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

LoopResponse::LoopResponse(SampledLoop loop) : loop_(std::move(loop)) {
  state_.setZero(loop_.A.rows());
}

MatrixXd LoopResponse::follow(const MatrixXd& inputs) {
  MatrixXd outputs(inputs.rows(), loop_.C.rows());
  for (Index k = 0; k < inputs.rows(); ++k) {
    input_ = inputs.row(k).transpose();
    outputs.row(k).noalias() = (loop_.C * state_ + loop_.D * input_).transpose();
    next_.noalias() = loop_.A * state_;
    next_.noalias() += loop_.B * input_;
    state_.swap(next_);
  }
  return outputs;
}

double Takeover::share(std::int64_t seq) const {
  if (seq <= from) return 0;
  if (seq >= full) return 1;
  return smooth_step(static_cast<double>(seq - from) / static_cast<double>(full - from));
}

ForceResponse::ForceResponse(ForceModel model)
    : response_(std::move(model.loop)), forces_(std::move(model.at)), late_(std::move(model.late)) {
  if (!late_) return;
  response_ = LoopResponse(late_->loop.closed);
  heard_.setZero(late_->loop.C_e.rows());
}

MatrixXd ForceResponse::at(std::int64_t seq, Index n) {
  if (seq < next_) throw std::invalid_argument("ForceResponse: samples do not follow");
  // What forces did longer ago than any run lasts to be looked at is not gone after.
  constexpr std::int64_t at_once = 4096, longest_gap = 100'000'000;
  if (seq - next_ > longest_gap) {
    response_.rest();
    next_ = seq;
  }
  while (next_ < seq) follow(std::min(seq - next_, at_once));
  return follow(n);
}

/// What the law hears it answers but for what was taken for offsets of its sensors, which are one
/// more input, of 1.
void ForceResponse::take_hold(std::int64_t seq) {
  const auto& [when, loop] = *late_;
  if (seq <= when.from + 1) response_.rest_behind(loop.n_plant);
  if (seq >= when.heard_from && seq <= when.heard_to) heard_ += loop.C_e * response_.state();
  const double share = when.share(seq);
  if (share == share_) return;
  share_ = share;
  SampledLoop now = loop.at(share);
  VectorXd offset = VectorXd::Zero(now.B_v.cols());
  if (share > 0 && when.heard_to >= when.heard_from) {
    offset =
        heard_.cwiseProduct(when.offset) / static_cast<double>(when.heard_to - when.heard_from + 1);
  }
  const auto with_column = [](const MatrixXd& M, const VectorXd& column) {
    MatrixXd result(M.rows(), M.cols() + 1);
    result << M, column;
    return result;
  };
  now.B = with_column(now.B, -now.B_v * offset);
  now.D = with_column(now.D, -now.D_v * offset);
  response_.change(std::move(now));
}

MatrixXd ForceResponse::follow(Index n) {
  const Index n_forces = (late_ ? late_->loop.closed : response_.loop()).B.cols();
  MatrixXd forces = MatrixXd::Ones(n, n_forces + (late_ ? 1 : 0));
  // A measurement shows what was held up to it.
  for (Index k = 0; k < n; ++k) {
    forces.row(k).head(n_forces) = forces_(next_ + k - 1).transpose();
  }
  next_ += n;
  if (!late_) return response_.follow(forces);
  const std::int64_t first = next_ - n - 1;
  MatrixXd outputs(n, response_.loop().C.rows());
  Index k = 0;
  for (; k < n && (first + k <= late_->when.full || share_ != 1); ++k) {
    take_hold(first + k);
    outputs.row(k) = response_.follow(forces.row(k));
  }
  outputs.bottomRows(n - k) = response_.follow(forces.bottomRows(n - k));
  return outputs;
}

}  // namespace stillframe::report

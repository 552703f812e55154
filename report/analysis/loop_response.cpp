#include "report/analysis/loop_response.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "core/numerics/smooth_step.hpp"

namespace stillframe::report {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

double Takeover::share(std::int64_t seq) const {
  if (seq <= from) return 0;
  if (seq >= full) return 1;
  return smooth_step(static_cast<double>(seq - from) / static_cast<double>(full - from));
}

LoopResponse::LoopResponse(SampledLoop loop) : loop_(std::move(loop)) {
  state_.setZero(loop_.A.rows());
}

LoopResponse::LoopResponse(LateLoop loop) : LoopResponse(loop.loop.closed) {
  late_ = std::move(loop);
  heard_.setZero(late_->loop.C_e.rows());
}

MatrixXd LoopResponse::follow(const MatrixXd& inputs) {
  const std::int64_t first = next_ - 1;  // a measurement shows what was held up to it
  next_ += inputs.rows();
  if (!late_) return step(inputs);
  MatrixXd with_one(inputs.rows(), inputs.cols() + 1), outputs(inputs.rows(), loop_.C.rows());
  with_one << inputs, VectorXd::Ones(inputs.rows());
  Index k = 0;
  for (; k < inputs.rows() && (first + k <= late_->when.full || share_ != 1); ++k) {
    take_hold(first + k);
    outputs.row(k) = step(with_one.row(k));
  }
  outputs.bottomRows(inputs.rows() - k) = step(with_one.bottomRows(inputs.rows() - k));
  return outputs;
}

void LoopResponse::rest_until(std::int64_t seq) {
  state_.setZero();
  next_ = seq;
}

MatrixXd LoopResponse::step(const MatrixXd& inputs) {
  MatrixXd outputs(inputs.rows(), loop_.C.rows());
  for (Index k = 0; k < inputs.rows(); ++k) {
    input_ = inputs.row(k).transpose();
    outputs.row(k).noalias() = (loop_.C * state_ + loop_.D * input_).transpose();
    scratch_.noalias() = loop_.A * state_;
    scratch_.noalias() += loop_.B * input_;
    state_.swap(scratch_);
  }
  return outputs;
}

/// Offsets are one more input, of 1.
void LoopResponse::take_hold(std::int64_t seq) {
  const auto& [when, loop] = *late_;
  if (seq <= when.from + 1) state_.tail(state_.size() - loop.n_plant).setZero();
  if (seq >= when.heard_from && seq <= when.heard_to) heard_ += loop.C_e * state_;
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
  loop_ = std::move(now);
}

ForceResponse::ForceResponse(ForceModel model)
    : n_forces_(model.loop.B.cols()),
      response_(model.late ? LoopResponse(std::move(*model.late))
                           : LoopResponse(std::move(model.loop))),
      forces_(std::move(model.at)) {}

MatrixXd ForceResponse::at(std::int64_t seq, Index n) {
  if (seq < response_.next()) throw std::invalid_argument("ForceResponse: samples do not follow");
  // What forces did longer ago than any run lasts to be looked at is not gone after.
  constexpr std::int64_t at_once = 4096, longest_gap = 100'000'000;
  if (seq - response_.next() > longest_gap) response_.rest_until(seq);
  while (response_.next() < seq) follow(std::min(seq - response_.next(), at_once));
  return follow(n);
}

MatrixXd ForceResponse::follow(Index n) {
  MatrixXd forces(n, n_forces_);
  for (Index k = 0; k < n; ++k) forces.row(k) = forces_(response_.next() + k - 1).transpose();
  return response_.follow(forces);
}

}  // namespace stillframe::report

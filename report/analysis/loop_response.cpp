#include "report/analysis/loop_response.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace stillframe::report {

using Eigen::Index;
using Eigen::MatrixXd;

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

ForceResponse::ForceResponse(ForceModel model)
    : response_(std::move(model.loop)), forces_(std::move(model.at)) {}

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

MatrixXd ForceResponse::follow(Index n) {
  MatrixXd forces(n, response_.loop().B.cols());
  // A measurement shows what was held up to it.
  for (Index k = 0; k < n; ++k) forces.row(k) = forces_(next_ + k - 1).transpose();
  next_ += n;
  return response_.follow(forces);
}

}  // namespace stillframe::report

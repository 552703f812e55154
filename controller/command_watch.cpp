#include "controller/command_watch.hpp"

#include <algorithm>
#include <cmath>

#include "controller/slow_loops.hpp"
#include "core/numerics/two_pi.hpp"

namespace stillframe::controller {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double share_s = 1;
// No floor makes a sound loop hurry, so it is soon believed: three samples in a row are more than
// the part that is allowed.
constexpr double hurried_samples = 20;
constexpr double forgotten_part = 0.001;
constexpr std::int64_t most_catching_up = 50;
// Over which forces are smoothed that a fault holds: longer than the swings of a loop that has too
// much gain at high frequencies, shorter than what the frame needs at its target.
constexpr double steady_s = 0.006;

}  // namespace

CommandWatch::CommandWatch(Index m, double sample_time, double force_limit, double limited_part)
    : keep_(std::exp(-sample_time / slowed(share_s, 1 / sample_time))),
      keep_hurried_(std::exp(-1 / hurried_samples)),
      force_limit_(force_limit),
      limited_part_(limited_part),
      steady_(VectorXd::Zero(m)) {
  // Of Hann, whose sum over whole samples is one; no shorter than two swings of two samples.
  const auto n = std::max<Index>(5, std::llround(steady_s / sample_time));
  weights_ = VectorXd::NullaryExpr(n, [n](Index j) {
    const double angle = two_pi * static_cast<double>(j + 1);
    return (1 - std::cos(angle / static_cast<double>(n + 1))) / static_cast<double>(n + 1);
  });
  commands_ = MatrixXd::Zero(m, n);
}

void CommandWatch::command(const Eigen::Ref<const VectorXd>& force, bool driving,
                           Index hurries) noexcept {
  newest_ = (newest_ + 1) % commands_.cols();
  commands_.col(newest_) = force;
  const bool at_limit = driving && force.cwiseAbs().maxCoeff() >= force_limit_;
  share_ += (1 - keep_) * ((at_limit ? 1.0 : 0.0) - share_);
  // A sound loop that leaves its limit catches up with what it could not do.
  since_limit_ = at_limit ? 0 : since_limit_ + 1;
  const bool counts = driving && hurries >= 0 && since_limit_ > most_catching_up;
  // After a second of rest it is another beginning.
  if (counts && hurried_ < forgotten_part) first_ = hurries;
  hurried_ += (1 - keep_hurried_) * ((counts ? 1.0 : 0.0) - hurried_);
}

const VectorXd& CommandWatch::steady_force() noexcept {
  steady_.setZero();
  for (Index j = 0; j < weights_.size(); ++j) {
    steady_ += weights_(j) * commands_.col((newest_ + commands_.cols() - j) % commands_.cols());
  }
  return steady_;
}

}  // namespace stillframe::controller

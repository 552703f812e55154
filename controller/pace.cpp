#include "controller/pace.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stillframe::controller {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Ref;
using Eigen::VectorXd;

namespace {

// Standard deviations: six are met once in days by one leg at 1 kHz, and calibrations, masses and
// stiffnesses, by which more noise may come back, are not those of the model. What the floor may
// ask for needs no such margin: real floors ask for a quarter of it.
constexpr double sure = 9;
constexpr double forgotten_s = 3;
// By how much of what any floor may ask for a sound loop differs from the designed one: no floor
// that was met asks for more, so that a frame with other masses, stiffnesses, calibrations and
// clocks than the model's stays within it whatever it does.
constexpr double not_as_designed = 0.25;
// Responses are followed in pieces, of a quarter of a second or a quarter of the slowest target's
// period, two at least, until what swings in a piece is so small a part of all. A drift, which the
// leak makes, counts no further: floors do not go on being accelerated one way.
constexpr double piece_s = 0.25, piece_periods = 0.25, still = 0.01;
// Fewer fourth differences tell no noise.
constexpr std::int64_t fewest_differences = 50;
constexpr int most_samples = 50'000;
// The sum of squares of 1, -4, 6, -4, 1.
constexpr double squares_of_a_difference = 70;

/// The smallest memory with which 2 max |h| memory^k is at least |h[k]| for every sample k and leg.
double memory_of(const MatrixXd& changes, Index n) {
  double memory = 0;
  for (Index i = 0; i < changes.rows(); ++i) {
    const double peak = changes.row(i).head(n).cwiseAbs().maxCoeff();
    if (!(peak > 0)) continue;
    for (Index k = 1; k < n; ++k) {
      memory = std::max(
          memory, std::pow(std::abs(changes(i, k)) / (2 * peak), 1 / static_cast<double>(k)));
    }
  }
  return memory;
}

}  // namespace

Pace::Pace(const Gains& gains, double free)
    : designed_(gains), free_(free), keep_(std::exp(-gains.sample_time() / forgotten_s)) {
  const Index m = gains.n_legs(), p = designed_.n_floor();
  per_floor_ = per_lost_ = MatrixXd::Zero(m, p);
  per_noise_ = per_offset_ = MatrixXd::Zero(m, m);
  const double slowest_hz = gains.target_hz.empty()
                                ? std::numeric_limits<double>::infinity()
                                : *std::min_element(gains.target_hz.begin(), gains.target_hz.end());
  const int piece = std::max(
      1,
      static_cast<int>(std::min<double>(
          most_samples / 2, std::max(piece_s, piece_periods / slowest_hz) * gains.sample_rate_hz)));
  const VectorXd rest_w = VectorXd::Zero(p), rest_v = VectorXd::Zero(m);
  MatrixXd changes;
  for (Index j = 0; j < p + m; ++j) {
    designed_.reset();
    VectorXd after = rest_v, before = rest_v, all = rest_v, of_piece = rest_v;
    Index n = 0;
    while (n < most_samples) {
      VectorXd w = rest_w, v = rest_v;
      if (n == 0) (j < p ? w(j) : v(j - p)) = 1;
      const VectorXd change = designed_.step(1, w, v, 1);
      if (n == changes.cols()) changes.conservativeResize(m, n + piece);
      changes.col(n++) = change;
      after += change;
      of_piece += change.cwiseAbs();
      if (j < p) {
        per_floor_.col(j) += change.cwiseAbs();
      } else {
        per_noise_.col(j - p) += change.cwiseAbs2();
        per_offset_.col(j - p) = per_offset_.col(j - p).cwiseMax(after.cwiseAbs());
      }
      if (n % piece != 0) continue;
      all += of_piece;
      // What goes one way is as much as it gets anywhere.
      const VectorXd swings = of_piece - (after - before).cwiseAbs();
      if (n > piece && (swings.array() <= still * all.array()).all()) break;
      before = after;
      of_piece.setZero();
    }
    if (j < p) {
      per_lost_.col(j) = 2 * changes.leftCols(n).cwiseAbs().rowwise().maxCoeff();
      keep_lost_ = std::max(keep_lost_, memory_of(changes, n));
    }
  }
  largest_ = before_ = believed_ = doubted_ = beyond_ = VectorXd::Zero(p);
  last_ = MatrixXd::Zero(m, 5);
  squares_ = swing_ = doubt_ = most_ = wanted_ = lost_ = quiet_ = VectorXd::Zero(m);
  restart();
}

void Pace::restart() noexcept {
  squares_.setZero();
  swing_.setZero();
  doubt_.setZero();
  smallest_ = VectorXd::Constant(squares_.size(), std::numeric_limits<double>::max());
  n_squares_ = n_in_row_ = 0;
}

void Pace::listen(std::int64_t seq, const Ref<const VectorXd>& sigma) noexcept {
  n_in_row_ = n_in_row_ > 0 && seq == seq_ + 1 ? n_in_row_ + 1 : 1;
  seq_ = seq;
  const auto at = [&](std::int64_t age) { return last_.col((seq + 5 - age) % 5); };
  last_.col(seq % 5) = sigma;
  if (n_in_row_ < 5) return;
  ++n_squares_;
  for (Index i = 0; i < sigma.size(); ++i) {
    const double step = std::abs(at(0)(i) - at(1)(i));
    swing_(i) = std::max(swing_(i), step);
    if (step > 0) smallest_(i) = std::min(smallest_(i), step);
    const double fourth = at(0)(i) - 4 * at(1)(i) + 6 * at(2)(i) - 4 * at(3)(i) + at(4)(i);
    squares_(i) += fourth * fourth;
  }
}

void Pace::begin(const Ref<const VectorXd>& doubt) noexcept {
  doubt_.noalias() = per_offset_ * doubt;
  designed_.reset();
  wanted_.setZero();
  lost_.setZero();
}

void Pace::forget(std::int64_t n_elapsed) noexcept {
  const double kept = n_elapsed == 1 ? keep_ : std::pow(keep_, static_cast<double>(n_elapsed));
  largest_ *= kept;
  doubt_ *= kept;
  if (floor_known_) swing_ *= kept;
}

void Pace::floor(const Ref<const VectorXd>& w) noexcept {
  floor_known_ = largest_.size() > 0 && w.size() == largest_.size();
  if (!floor_known_) return;
  largest_ = largest_.cwiseMax(w.cwiseAbs().cwiseMin(before_));
  before_ = w.cwiseAbs();
  doubted_ = believed_;
  believed_ = w.cwiseMin(largest_).cwiseMax(-largest_);
  // Between two samples that were heard a floor is on the line between them but for about as much
  // as they differ.
  doubted_ = (doubted_ - believed_).cwiseAbs();
  beyond_ = (w - believed_).cwiseAbs();
}

void Pace::expect(std::int64_t n, double gain) noexcept {
  if (!floor_known_) return;
  wanted_ = designed_.step(n, believed_, quiet_, gain).cwiseAbs();
  lost_ *= n == 1 ? keep_lost_ : std::pow(keep_lost_, static_cast<double>(n));
  if (n > DesignedLoop::longest_step) return lose_track();
  lost_.noalias() += per_lost_ * beyond_;
  if (n > 1) lost_.noalias() += static_cast<double>(n - 1) * (per_lost_ * doubted_);
}

void Pace::lose_track() noexcept {
  if (floor_known_) lost_.noalias() = per_floor_ * largest_;
}

const VectorXd& Pace::most(std::int64_t n) noexcept {
  if (n_squares_ < fewest_differences) {
    most_.setConstant(std::numeric_limits<double>::infinity());
    return most_;
  }
  for (Index i = 0; i < most_.size(); ++i) {
    double square = 0;
    for (Index k = 0; k < most_.size(); ++k) {
      // The steps of a converter are noise too, and those of one at rest are not met while arming.
      const double converter = smallest_(k) < std::numeric_limits<double>::max() ? smallest_(k) : 0;
      const double noise =
          squares_(k) /
          (squares_of_a_difference * static_cast<double>(std::max<std::int64_t>(1, n_squares_)));
      square += per_noise_(i, k) * (noise + converter * converter / 12);
    }
    most_(i) = sure * std::sqrt(square) + doubt_(i) + free_;
    if (!floor_known_) {
      most_(i) += 4 * swing_(i);
      continue;
    }
    const double any_floor = per_floor_.row(i).dot(largest_);
    most_(i) += 2 * swing_(i) +
                std::min(any_floor, wanted_(i) + not_as_designed * any_floor + lost_(i));
  }
  // After a longer gap the loop has let go meanwhile, and nothing is to be caught up with.
  if (n > 1 && n <= DesignedLoop::longest_step) most_ *= static_cast<double>(n);
  return most_;
}

}  // namespace stillframe::controller

#include "controller/pace.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>

#include "controller/law.hpp"
#include "core/linear/sampled_plant.hpp"

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
// Responses are followed in pieces, of a quarter of a second or a quarter of the slowest target's
// period, two at least, until what swings in a piece is so small a part of all. A drift, which the
// leak makes, counts no further: floors do not go on being accelerated one way.
constexpr double piece_s = 0.25, piece_periods = 0.25, still = 0.01;
// Fewer fourth differences tell no noise.
constexpr std::int64_t fewest_differences = 50;
constexpr int most_samples = 50'000;
// The sum of squares of 1, -4, 6, -4, 1.
constexpr double squares_of_a_difference = 70;

/// The designed loop, sample by sample, from rest.
class DesignedLoop {
 public:
  explicit DesignedLoop(const Gains& gains)
      : plant_(sample_and_hold({.A = gains.plant.A,
                                .B_w = gains.plant.B_w,
                                .B_u = gains.plant.B,
                                .C_y = MatrixXd::Zero(0, gains.plant.A.rows()),
                                .D_yw = MatrixXd::Zero(0, gains.plant.B_w.cols()),
                                .D_yu = MatrixXd::Zero(0, gains.n_legs()),
                                .C_sigma = gains.plant.C},
                               gains.sampling())),
        law_(law_from_gains(gains)),
        x_(VectorXd::Zero(plant_.Phi.rows())),
        u_(VectorXd::Zero(gains.n_legs())) {
    // A gains file has one delay for all legs.
    commands_.assign(static_cast<std::size_t>(plant_.whole_delay.maxCoeff()) + 1, u_);
    reports_.assign(static_cast<std::size_t>(plant_.report_age) + 1, u_);
  }

  /// One sample under w, with noise v on the sensors; the change of the command.
  VectorXd step(const VectorXd& w, const VectorXd& v) {
    const VectorXd before = commands_.back(), last = u_;
    reports_.push_front(plant_.C_report * x_ + plant_.D_report * before);
    reports_.pop_back();
    law_.step(plant_.C_sigma * x_ + plant_.D_sigma * before + v, reports_.back(), u_);
    commands_.push_front(u_);
    commands_.pop_back();
    const VectorXd& now = commands_.back();
    x_ = (plant_.Phi * x_ + plant_.Gamma_w * w + plant_.Gamma_0 * before + plant_.Gamma_u * now)
             .eval();
    return u_ - last;
  }

 private:
  SampledPlant plant_;
  Law law_;
  VectorXd x_, u_;
  std::deque<VectorXd> commands_, reports_;  ///< newest first
};

}  // namespace

Pace::Pace(const Gains& gains, double free)
    : free_(free), keep_(std::exp(-gains.sample_time() / forgotten_s)) {
  const Index m = gains.n_legs(), p = gains.plant.B_w.cols();
  per_floor_ = MatrixXd::Zero(m, p);
  per_noise_ = per_offset_ = MatrixXd::Zero(m, m);
  const double slowest_hz = gains.target_hz.empty()
                                ? std::numeric_limits<double>::infinity()
                                : *std::min_element(gains.target_hz.begin(), gains.target_hz.end());
  const int piece = std::max(
      1,
      static_cast<int>(std::min<double>(
          most_samples / 2, std::max(piece_s, piece_periods / slowest_hz) * gains.sample_rate_hz)));
  for (Index j = 0; j < p + m; ++j) {
    DesignedLoop loop(gains);
    const VectorXd rest_w = VectorXd::Zero(p), rest_v = VectorXd::Zero(m);
    VectorXd after = rest_v, before = rest_v, all = rest_v, of_piece = rest_v;
    for (int k = 0; k < most_samples; ++k) {
      VectorXd w = rest_w, v = rest_v;
      if (k == 0) (j < p ? w(j) : v(j - p)) = 1;
      const VectorXd change = loop.step(w, v);
      after += change;
      of_piece += change.cwiseAbs();
      if (j < p) {
        per_floor_.col(j) += change.cwiseAbs();
      } else {
        per_noise_.col(j - p) += change.cwiseAbs2();
        per_offset_.col(j - p) = per_offset_.col(j - p).cwiseMax(after.cwiseAbs());
      }
      if ((k + 1) % piece != 0) continue;
      all += of_piece;
      // What goes one way is as much as it gets anywhere.
      const VectorXd swings = of_piece - (after - before).cwiseAbs();
      if (k >= piece && (swings.array() <= still * all.array()).all()) break;
      before = after;
      of_piece.setZero();
    }
  }
  largest_ = before_ = VectorXd::Zero(p);
  last_ = MatrixXd::Zero(m, 5);
  squares_ = swing_ = doubt_ = most_ = VectorXd::Zero(m);
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
}

const VectorXd& Pace::most() noexcept {
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
    most_(i) += floor_known_ ? per_floor_.row(i).dot(largest_) + 2 * swing_(i) : 4 * swing_(i);
  }
  return most_;
}

}  // namespace stillframe::controller

#include "controller/pace.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "controller/slow_loops.hpp"
#include "core/numerics/infinity.hpp"
#include "core/numerics/smooth_step.hpp"
#include "core/numerics/worst.hpp"

namespace stillframe::controller {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Ref;
using Eigen::VectorXd;

namespace {

// s, for which the changes of commands are remembered: none, and two within which a loop that grows
// does more than noise and less than harm.
constexpr double memories_s[] = {0, 0.004, 0.03};
constexpr double largest_forgotten_s = 3;
// Responses are followed in pieces, of a quarter of a second or a quarter of the slowest target's
// period, two at least, until what swings in a piece is so small a part of all. A drift, which the
// leak makes, counts no further: floors do not go on being accelerated one way.
constexpr double piece_s = 0.25, piece_periods = 0.25, still = 0.01;
// Fewer fourth differences tell no noise.
constexpr std::int64_t fewest_differences = 50;
constexpr std::int64_t longest_loss = 10;
// Below a tenth of a hertz floors move frames by next to nothing; sensors tilt and drift.
constexpr double rest_s = 3;
// What is remembered of the floor is of so many samples at least: with a fifth of them loops of
// slow targets met floors that moved slowly, and took what they had forgotten for a fault.
constexpr double fewest_samples = 3000;
constexpr int most_samples = 50'000;
// A sensor is as good as its neighbours, or it is another's, or broken.
constexpr double noisier = 10;
// The sum of squares of 1, -4, 6, -4, 1.
constexpr double squares_of_a_difference = 70;
// The sum of products of 1, -4, 6, -4, 1 with itself a sample later is less than nothing: so noise
// is told from a motion, which below a quarter of the sample rate has a sum above it.
constexpr double products_of_differences = -56;

/// The changes of a loop's commands (m x n, N) after one sample of floor channel j, or of sensor
/// j - p, or of the excitation of leg j - p - m, until it no longer swings. squares: m, N^2, of the
/// forces of the legs meanwhile.
MatrixXd changes_of(DesignedLoop& loop, Index m, Index j, Index piece, Ref<VectorXd> squares) {
  const Index p = loop.n_floor();
  const VectorXd rest_w = VectorXd::Zero(p), rest_v = VectorXd::Zero(m);
  VectorXd after = rest_v, before = rest_v, all = rest_v, of_piece = rest_v;
  MatrixXd changes;
  loop.reset(1);
  squares.setZero();
  for (Index n = 0; n < most_samples;) {
    VectorXd w = rest_w, v = rest_v;
    if (n == 0 && j < p) w(j) = 1;
    if (n == 0 && j >= p && j < p + m) v(j - p) = 1;
    if (n <= 1 && j >= p + m)
      loop.excite((1.0 - static_cast<double>(n)) * VectorXd::Unit(m, j - p - m));
    if (n == changes.cols()) changes.conservativeResize(m, n + piece);
    const VectorXd change = loop.step(1, w, v, 1);
    changes.col(n++) = change;
    squares += (loop.sigma() - v).cwiseAbs2();
    after += change;
    of_piece += change.cwiseAbs();
    if (n % piece != 0) continue;
    all += of_piece;
    // What goes one way is as much as it gets anywhere.
    const VectorXd swings = of_piece - (after - before).cwiseAbs();
    if (n > piece && (swings.array() <= still * all.array()).all()) return changes;
    before = after;
    of_piece.setZero();
  }
  return changes.leftCols(most_samples);
}

/// The changes of its commands (m x n, N) while the gain comes up within so many samples, and as
/// many again, with sensor k constantly off by one.
MatrixXd changes_by_offset(DesignedLoop& loop, Index m, Index k, Index ramp) {
  const VectorXd w = VectorXd::Zero(loop.n_floor()), v = VectorXd::Unit(m, k);
  MatrixXd changes(m, 2 * ramp);
  loop.reset();
  for (Index n = 0; n < changes.cols(); ++n) {
    const double passed = static_cast<double>(n + 1) / static_cast<double>(ramp);
    changes.col(n) = loop.step(1, w, v, smooth_step(std::min(1.0, passed)));
  }
  return changes;
}

/// The same after that, while the gain goes down within so many samples.
MatrixXd changes_by_letting_go(DesignedLoop& loop, Index m, Index k, Index ramp) {
  const VectorXd w = VectorXd::Zero(loop.n_floor()), v = VectorXd::Unit(m, k);
  MatrixXd changes(m, ramp);
  for (Index n = 0; n < ramp; ++n) {
    const double left = static_cast<double>(ramp - n - 1) / static_cast<double>(ramp);
    changes.col(n) = loop.step(1, w, v, smooth_step(left));
  }
  return changes;
}

}  // namespace

Pace::Pace(const Gains& gains, const Settings& settings)
    : designed_(gains),
      keep_(std::exp(-gains.sample_time() /
                     std::max(largest_forgotten_s, fewest_samples * gains.sample_time()))),
      rests_(gains.sample_time() / std::max(rest_s, fewest_samples * gains.sample_time())) {
  const Index m = gains.n_legs(), p = designed_.n_floor();
  for (const double memory : memories_s) {
    const double memory_s = slowed(memory, gains.sample_rate_hz);
    const double keep = memory > 0 ? std::exp(-gains.sample_time() / memory_s) : 0;
    scales_.emplace_back(m, p, keep);
  }
  const double slowest_hz = gains.target_hz.empty()
                                ? infinity
                                : *std::min_element(gains.target_hz.begin(), gains.target_hz.end());
  const auto piece = std::max<Index>(
      1, static_cast<Index>(std::min<double>(
             most_samples / 2,
             std::max(slowed(piece_s, gains.sample_rate_hz), piece_periods / slowest_hz) *
                 gains.sample_rate_hz)));
  MatrixXd squares(m, p + m);
  for (Index j = 0; j < p + m; ++j) {
    const MatrixXd changes = changes_of(designed_, m, j, piece, squares.col(j));
    for (PaceScale& scale : scales_) scale.learn(changes, j);
  }
  force_per_noise_ = squares.rightCols(m);
  VectorXd unused(m);
  for (Index j = 0; settings.excited && j < m; ++j) {
    const MatrixXd changes = changes_of(designed_, m, p + m + j, piece, unused);
    for (PaceScale& scale : scales_) scale.learn_excitation(changes, j);
  }
  const auto samples = [&](double seconds) {
    return std::clamp<Index>(std::llround(seconds * gains.sample_rate_hz), 1, most_samples / 2);
  };
  most_doubt_.resize(m);
  for (Index k = 0; k < m; ++k) {
    const MatrixXd changes = changes_by_offset(designed_, m, k, samples(settings.ramp_in_s));
    for (PaceScale& scale : scales_) scale.learn_offset(changes, k);
    // The leak leaves such a drift a gain of hundreds: what is more than this ends at the limit.
    const double held = designed_.command()(k);
    most_doubt_(k) = settings.force_limit / worst_of(designed_.command());
    const MatrixXd down = changes_by_letting_go(designed_, m, k, samples(settings.ramp_out_s));
    for (PaceScale& scale : scales_) scale.learn_letting_go(down, k, held, keep_);
  }
  free_.setConstant(m, settings.free);
  if (p > 0 && std::isfinite(settings.beside)) {
    free_ = free_.cwiseMin(settings.beside * per_floor().rowwise().sum());
  }
  for (PaceScale& scale : scales_) scale.allow(free_);
  rest_ = moves_ = largest_ = before_ = believed_ = doubted_ = beyond_ = VectorXd::Zero(p);
  last_ = MatrixXd::Zero(m, 5);
  squares_ = most_ = change_ = quiet_ = variance_ = sorted_ = mean_ = moved_ = VectorXd::Zero(m);
  fourth_ = products_ = VectorXd::Zero(m);
  designed_.reset();
  restart();
}

void Pace::restart() noexcept {
  squares_.setZero();
  products_.setZero();
  mean_.setZero();
  moved_.setZero();
  smallest_.setConstant(squares_.size(), std::numeric_limits<double>::max());
  n_squares_ = n_in_row_ = 0;
  whole_ = false;
  for (PaceScale& scale : scales_) scale.restart();
}

void Pace::listen(std::int64_t seq, const Ref<const VectorXd>& sigma) noexcept {
  // Over samples that were lost a frame moves further, and noise is taken for more than it is.
  n_in_row_ = n_in_row_ > 0 && seq - seq_ <= longest_loss ? n_in_row_ + 1 : 1;
  seq_ = seq;
  const auto at = [&](std::int64_t age) { return last_.col((n_in_row_ + 5 - age) % 5); };
  last_.col(n_in_row_ % 5) = sigma;
  change_ = at(0) - at(1);
  for (PaceScale& scale : scales_) scale.listen(change_, n_in_row_ == 1);
  if (n_in_row_ < 5) return;
  ++n_squares_;
  change_ = sigma - mean_;
  mean_ += change_ / static_cast<double>(n_squares_);
  moved_.array() += change_.array() * (sigma - mean_).array();
  for (Index i = 0; i < sigma.size(); ++i) {
    const double step = std::abs(at(0)(i) - at(1)(i));
    if (step > 0) smallest_(i) = std::min(smallest_(i), step);
    const double fourth = at(0)(i) - 4 * at(1)(i) + 6 * at(2)(i) - 4 * at(3)(i) + at(4)(i);
    squares_(i) += fourth * fourth;
    if (n_in_row_ > 5) products_(i) += fourth * fourth_(i);
    fourth_(i) = fourth;
  }
}

bool Pace::knows_noise() const noexcept { return n_squares_ >= fewest_differences; }

void Pace::begin(const Ref<const VectorXd>& doubt) noexcept {
  const auto n = static_cast<double>(std::max<std::int64_t>(1, n_squares_));
  for (Index i = 0; i < change_.size(); ++i) {
    // The steps of a converter are noise too, and those of one at rest are not met while arming.
    const double converter = smallest_(i) < std::numeric_limits<double>::max() ? smallest_(i) : 0;
    variance_(i) = squares_(i) / (squares_of_a_difference * n) + converter * converter / 12;
  }
  change_ = doubt.cwiseMin(most_doubt_);
  for (PaceScale& scale : scales_) scale.begin(change_, variance_);
  designed_.reset();
}

Index Pace::noisy() noexcept {
  if (!knows_noise()) return -1;
  const auto n = static_cast<double>(n_squares_);
  sorted_ = variance_;
  const auto middle = sorted_.begin() + (sorted_.size() - 1) / 2;
  std::nth_element(sorted_.begin(), middle, sorted_.end());
  Index leg = -1;
  const double at_least = (products_ / (products_of_differences * n)).maxCoeff(&leg);
  if (!(at_least > noisier * noisier * *middle)) return -1;
  // Its own readings say nothing of how the frame moves.
  double moves = 0;
  for (Index i = 0; i < moved_.size(); ++i) {
    if (i != leg) moves = std::max(moves, moved_(i) / n - variance_(i));
  }
  return force_per_noise_.col(leg).maxCoeff() * at_least > moves ? leg : -1;
}

void Pace::forget(std::int64_t n_elapsed) noexcept {
  const double kept = n_elapsed == 1 ? keep_ : std::pow(keep_, static_cast<double>(n_elapsed));
  if (!blind_) largest_ *= kept;
  for (PaceScale& scale : scales_) scale.forget(kept, n_elapsed, whole_, floor_known_);
}

void Pace::floor(const Ref<const VectorXd>& measured, bool broken) noexcept {
  floor_known_ = largest_.size() > 0 && measured.size() == largest_.size();
  blind_ = broken;
  if (!floor_known_ || blind_) return;
  // At first the mean of all there were.
  ++n_rest_;
  rest_ += std::max(rests_, 1 / static_cast<double>(n_rest_)) * (measured - rest_);
  moves_ = measured - rest_;
  const VectorXd& w = moves_;
  largest_ = largest_.cwiseMax(w.cwiseAbs().cwiseMin(before_));
  before_ = w.cwiseAbs();
  doubted_ = believed_;
  believed_ = w.cwiseMin(largest_).cwiseMax(-largest_);
  doubted_ = (doubted_ - believed_).cwiseAbs();
  beyond_ = (w - believed_).cwiseAbs();
}

void Pace::expect(std::int64_t n, double gain, const Ref<const VectorXd>& acts,
                  double share) noexcept {
  if (!floor_known_) return;
  designed_.actuators(acts);
  whole_ = gain == 1;
  if (blind_) {
    for (PaceScale& scale : scales_) scale.expect(n, quiet_);
    return lose_track();
  }
  const VectorXd& change = designed_.step(n, believed_, quiet_, gain, share);
  // Between two samples that were heard a floor is on the line between them but for about as much
  // as they differ.
  if (n > 1) beyond_ += static_cast<double>(n - 1) * doubted_;
  for (PaceScale& scale : scales_) {
    scale.expect(n, change);
    scale.doubt_floor(beyond_);
  }
  if (n > DesignedLoop::longest_step) lose_track();
}

void Pace::excite(const Ref<const VectorXd>& force) noexcept {
  for (PaceScale& scale : scales_) scale.excite(force);
}

void Pace::let_go(const Ref<const VectorXd>& force) noexcept {
  for (PaceScale& scale : scales_) scale.let_go(force);
}

void Pace::lose_track() noexcept {
  if (!floor_known_) return;
  for (PaceScale& scale : scales_) scale.lose_track(largest_);
}

const VectorXd& Pace::most(std::int64_t n) noexcept {
  if (!knows_noise()) {
    most_.setConstant(infinity);
    return most_;
  }
  // What a loop that lost samples has to catch up with; in a longer gap it has begun to let go.
  const auto at_once =
      static_cast<double>(std::clamp<std::int64_t>(n, 1, DesignedLoop::longest_step));
  for (Index i = 0; i < most_.size(); ++i) {
    most_(i) = scales_.front().most(i, known_floor(), at_once);
  }
  return most_;
}

Index Pace::command(std::int64_t n, const Ref<const VectorXd>& change) noexcept {
  for (PaceScale& scale : scales_) scale.command(n, change);
  if (!knows_noise()) return -1;
  Index leg = -1;
  double furthest = 1;
  for (Index i = 0; i < change.size(); ++i) {
    double part = std::abs(change(i)) / most_(i);
    // How a frame swings within milliseconds does not tell how its floor will.
    for (std::size_t j = 1; floor_known_ && j < scales_.size(); ++j) {
      part = std::max(part, scales_[j].part(i, largest_));
    }
    // What is no number is beyond everything.
    if (std::isnan(part)) part = infinity;
    if (part <= furthest) continue;
    furthest = part;
    leg = i;
  }
  return leg;
}

}  // namespace stillframe::controller

#include "core/control/feed_forward_design.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "core/control/close_loop.hpp"
#include "core/numerics/singular_values.hpp"
#include "core/numerics/two_pi.hpp"

namespace stillframe {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;

namespace {

// Frequencies for each tap: at half the rate their steps are a third of what so many taps resolve.
constexpr Index frequencies_a_tap = 15;
constexpr Index fewest_frequencies = 120;
constexpr double lowest_part = 0.2, highest_part = 0.998;  // of the corner, of half the rate
// How near T is to come to the goal is counted as 0.4 of it, which leaves it within 3 dB.
constexpr double nearness = 0.4;
// From the last frequency at which the goal is aimed at to the first at which it is not.
constexpr double transition = 1.5;
// Singular values below this part of the largest are rounding: legs whose forces cancel each other.
constexpr double rank_part = 1e-10;

/// T_fb and H of a loop whose actuators all have that gain besides their own.
class Responses {
 public:
  Responses(LoopSettings loop, double gain) : p_(loop.plant.B_w.cols()) {
    loop.sampling.instruments.actuator_gain *= gain;
    loop_ = close_loop_with_added_force(sample_and_hold(loop.plant, loop.sampling), law_of(loop));
  }

  /// (T_fb, H) at omega.
  std::pair<MatrixXcd, MatrixXcd> at(double omega) const {
    const MatrixXcd both = transfer(loop_, omega);
    return {both.leftCols(p_), both.rightCols(both.cols() - p_)};
  }

 private:
  Index p_;
  SampledLoop loop_;
};

Eigen::VectorXd grid_hz(const FeedForwardWeights& weights, double sample_time) {
  const double to = highest_part / (2 * sample_time);
  const double from = std::min(lowest_part * weights.corner_hz, 0.1 * to);
  const Index n = std::max(fewest_frequencies, frequencies_a_tap * weights.n_taps);
  return Eigen::VectorXd::LinSpaced(n, std::log(from), std::log(to)).array().exp();
}

/// b at a frequency above to_hz; of_goal: b at to_hz.
double bound_above(double hz, const FeedForwardWeights& weights, double of_goal) {
  const double part = std::min(1.0, std::log(hz / weights.to_hz) / std::log(transition));
  return std::exp((1 - part) * std::log(of_goal) + part * std::log(weights.at_most));
}

/// The rows of the least squares problem, real and imaginary parts apart, unknowns in the order of
/// FeedForward::weights transposed: for every term the rows of its m legs.
class Rows {
 public:
  Rows(Index rows, Index unknowns, Index p) : M_(rows, unknowns), y_(rows, p) {}

  void add(const MatrixXcd& H, const Eigen::VectorXcd& terms, const MatrixXcd& wanted) {
    const Index m = H.cols(), n_y = H.rows();
    for (Index i = 0; i < terms.size(); ++i) {
      const MatrixXcd block = terms(i) * H;
      M_.block(n_, i * m, n_y, m) = block.real();
      M_.block(n_ + n_y, i * m, n_y, m) = block.imag();
    }
    y_.middleRows(n_, n_y) = wanted.real();
    y_.middleRows(n_ + n_y, n_y) = wanted.imag();
    n_ += 2 * n_y;
  }

  /// Unknowns x p. Terms are of sizes orders of magnitude apart: columns are scaled, and a
  /// triangle is taken first, as a pivoted factorisation of all rows takes ten times as long.
  MatrixXd solution() {
    Eigen::VectorXd scale = M_.colwise().norm();
    for (double& value : scale) value = value > 0 ? value : 1;
    M_ = M_ * scale.cwiseInverse().asDiagonal();
    const Eigen::HouseholderQR<Eigen::Ref<MatrixXd>> triangle(M_);
    y_.applyOnTheLeft(triangle.householderQ().adjoint());
    const Index n = M_.cols();
    const MatrixXd R = M_.topRows(n).triangularView<Eigen::Upper>();
    Eigen::CompleteOrthogonalDecomposition<MatrixXd> decomposition(n, n);
    decomposition.setThreshold(rank_part);
    decomposition.compute(R);
    return scale.cwiseInverse().asDiagonal() * decomposition.solve(y_.topRows(n));
  }

 private:
  MatrixXd M_, y_;
  Index n_ = 0;
};

}  // namespace

FeedForward design_feed_forward(LoopSettings loop, const std::function<MatrixXcd(double)>& goal,
                                const FeedForwardWeights& weights) {
  loop.feed_forward = {};
  const double T_s = loop.sampling.sample_time, e = weights.actuator_error;
  const Index m = loop.plant.B_u.cols(), p = loop.plant.B_w.cols(), n_y = loop.plant.C_y.rows();
  FeedForward filter{.memory = std::exp(-two_pi * weights.corner_hz * T_s),
                     .n_taps = weights.n_taps};
  const Responses exact(loop, 1), weak(loop, 1 - e), strong(loop, 1 + e);
  const auto size_of_goal = [&](double hz) {
    const MatrixXcd G = goal(two_pi * hz);
    if (G.rows() != n_y || G.cols() != p) {
      throw std::invalid_argument("design_feed_forward: the goal is no response of this loop");
    }
    return nearness * singular_values(G)(0);
  };
  const double at_edge = size_of_goal(weights.to_hz);
  const Eigen::VectorXd grid = grid_hz(weights, T_s);
  Rows rows(3 * 2 * n_y * grid.size(), filter.n_terms() * m, p);
  for (const double hz : grid) {
    const double omega = two_pi * hz;
    const bool aims = hz <= weights.to_hz;
    const double b = aims ? size_of_goal(hz) : bound_above(hz, weights, at_edge);
    const Eigen::VectorXcd terms =
        feed_forward_terms(filter.memory, filter.n_taps, std::polar(1.0, omega * T_s)) / b;
    const auto [T, H] = exact.at(omega);
    const auto [T_weak, H_weak] = weak.at(omega);
    const auto [T_strong, H_strong] = strong.at(omega);
    const MatrixXcd G = aims ? goal(omega) : MatrixXcd::Zero(n_y, p);
    const double noise =
        weights.noise_over_floor * std::hypot(1, std::pow(weights.corner_hz / hz, 2));
    rows.add(H, terms, (G - T) / b);
    rows.add((H_strong - H_weak) / 2, terms, (T_weak - T_strong) / (2 * b));
    rows.add(noise * H, terms, MatrixXcd::Zero(n_y, p));
  }
  const MatrixXd found = rows.solution();
  filter.weights.resize(m, p * filter.n_terms());
  for (Index i = 0; i < filter.n_terms(); ++i) {
    filter.weights.middleCols(i * p, p) = found.middleRows(i * m, m);
  }
  return filter;
}

}  // namespace stillframe

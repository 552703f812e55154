#include "core/control/delay_centre.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/control/close_loop.hpp"
#include "core/numerics/two_pi.hpp"

namespace stillframe {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

namespace {

constexpr double circle = largest_stable_radius;
using std::numbers::pi;

/// Points on the circle are this part of the distance to the next pole apart. Beside one pole a
/// quotient grows by 1 / (1 - part / 2) = 1.21 between two of them; `largest` leaves room for 1.25.
/// On random loops five points more in every gap never found more than 1.03.
constexpr double part_of_distance = 0.35;
constexpr double largest = 0.8;

/// A pole is followed that is nearer to the circle than this part of the distance to other poles.
constexpr double narrow = 0.1;

/// At least the largest singular value; of one leg it is that.
double norm(const MatrixXcd& M) {
  const double sums =
      std::sqrt(M.cwiseAbs().rowwise().sum().maxCoeff() * M.cwiseAbs().colwise().sum().maxCoeff());
  return std::min(M.norm(), sums);
}

}  // namespace

DelayCentre::DelayCentre(const LoopPlant& plant, const Sampling& sampling, const DiscreteLaw& law,
                         const std::vector<Index>& legs)
    : plant_(plant), sampling_(sampling), legs_(legs), sweep_(transposed_system(law)) {
  const VectorXcd& poles = sweep_.poles();
  stable_ = poles.size() == 0 || poles.cwiseAbs().maxCoeff() < circle;
  if (!stable_) return;
  choose_followed();
  walk_round();
}

StateSpace DelayCentre::transposed_system(const DiscreteLaw& law) {
  SampledPlant sampled = sample_and_hold(plant_, sampling_);
  const Index n = sampled.Phi.rows(), m = sampled.Gamma_u.cols(), k = std::ssize(legs_);
  MatrixXd chosen = MatrixXd::Zero(k, m);
  for (Index i = 0; i < k; ++i) chosen(i, legs_[static_cast<size_t>(i)]) = 1;
  sampled.Gamma_w = MatrixXd::Identity(n, n);
  sampled.C_y = sampled.D_yw = MatrixXd::Zero(k, n);
  sampled.D_0 = chosen;
  sampled.D_yu = -chosen;
  queue_turn_ = 1.0 / (sampled.whole_delay.maxCoeff() + sampled.report_age + 1);
  const SampledLoop loop = close_loop(sampled, law);
  StateSpace out;
  out.A = loop.A.transpose();
  out.B = loop.C.transpose();
  out.C = loop.B.transpose();
  out.D = MatrixXd::Zero(n, k);
  for (Index i = 0; i < k; ++i) out.columns.push_back({InputColumns::Kind::direct, i});
  transposed_.resize(n, k);
  return out;
}

void DelayCentre::choose_followed() {
  const VectorXcd& poles = sweep_.poles();
  for (Index i = 0; i < poles.size(); ++i) {
    if (poles(i).imag() < 0) continue;
    double others = 2 * queue_turn_;
    for (Index j = 0; j < poles.size(); ++j) {
      if (j != i) others = std::min(others, std::abs(poles(j) - poles(i)));
    }
    // Discs of a quarter never meet.
    if (circle - std::abs(poles(i)) < narrow * others) follow(poles(i), others / 4);
  }
}

void DelayCentre::follow(Complex pole, double width) {
  // The mean over n points leaves of other poles, four times as far at least, 4^-n.
  constexpr int n = 16;
  const Index rows = std::ssize(legs_), columns = transposed_.rows();
  Followed out;
  out.pole = pole;
  out.width = width;
  out.R = out.H_0 = MatrixXcd::Zero(rows, columns);
  for (int i = 0; i < n; ++i) {
    out.around.push_back(std::polar(width, two_pi * (i + 0.5) / n));
    sweep_.evaluate(pole + out.around.back(), transposed_);
    out.H_around.push_back(transposed_.transpose());
    out.R += out.around.back() / static_cast<double>(n) * out.H_around.back();
    out.H_0 += out.H_around.back() / n;
  }
  followed_.push_back(std::move(out));
}

void DelayCentre::add_point(double angle) {
  // Next to a pole that is not followed three digits do as well.
  sweep_.evaluate_unrefined(std::polar(circle, angle), transposed_);
  H_.push_back(transposed_.transpose());
}

void DelayCentre::walk_round() {
  for (double angle = 0; angle < pi;) {
    const Complex z = std::polar(circle, angle);
    const auto inside = std::find_if(followed_.begin(), followed_.end(), [&](const Followed& f) {
      return std::abs(z - f.pole) < f.width;
    });
    const double distance = (sweep_.poles().array() - z).abs().minCoeff();
    const double step = std::min(part_of_distance * distance, queue_turn_ / 2);
    if (inside == followed_.end()) {
      add_point(angle);
      angle += step;
      continue;
    }
    // Steps are too short to have passed the disc: on from its far side, but both sides belong.
    const double a = std::abs(inside->pole), w = inside->width;
    const double cosine = (a * a + circle * circle - w * w) / (2 * a * circle);
    const double half = std::acos(std::clamp(cosine, -1.0, 1.0)) * (1 + 1e-9);
    const double middle = std::arg(inside->pole);
    if (middle - half > 0) add_point(middle - half);
    angle = std::max(middle + half, angle + 1e-3 * w);
  }
  add_point(pi);
}

/// With J(t) the integral of exp(A s) B over t: G(d) = exp(A (1 - c - d)) J(d), delays and times in
/// fractions of a sample.
void DelayCentre::changes(double half, int n, Changes& before, Changes& after) const {
  const double T = sampling_.sample_time;
  Sampling part = sampling_;
  part.delay_samples = 0;
  part.leg_delays.resize(0);
  part.sample_time = half / n * T;
  const SampledPlant step = sample_and_hold(plant_, part);
  const Index rows = step.Phi.rows(), k = std::ssize(legs_);
  before.assign(static_cast<size_t>(n), MatrixXcd::Zero(rows, k));
  after = before;
  for (Index i = 0; i < k; ++i) {
    const Index leg = legs_[static_cast<size_t>(i)];
    const double delay = sampling_.delay_samples + sampling_.leg_delays(leg);
    const double left = 1 - (delay - std::floor(delay)) - half;
    VectorXd piece = step.Gamma_u.col(leg);
    if (left > 0) {
      part.sample_time = left * T;
      piece = sample_and_hold(plant_, part).Phi * piece;
    }
    // exp(A (left + j h)) J(h), of which all G are sums.
    std::vector<VectorXd> pieces{piece};
    while (std::ssize(pieces) < 2 * n) pieces.push_back(step.Phi * pieces.back());
    VectorXd down = VectorXd::Zero(rows), up = down;
    for (size_t j = 0; j < static_cast<size_t>(n); ++j) {
      down -= pieces[static_cast<size_t>(n) + j];
      up += pieces[static_cast<size_t>(n) - 1 - j];
      before[j].col(i) = down.cast<Complex>();
      after[j].col(i) = up.cast<Complex>();
    }
  }
}

DelayCentre::Reach DelayCentre::reach(double half, int n_steps) const {
  n_steps = std::max(n_steps, 2);  // the second tells how a pole's path bends in the first
  Changes before, after;
  changes(half, n_steps, before, after);
  int n_before = n_steps, n_after = n_steps;
  on_circle(before, n_before);
  on_circle(after, n_after);
  for (const Followed& pole : followed_) {
    in_disc(pole, before, n_before);
    in_disc(pole, after, n_after);
  }
  // All of them is all, whatever the rounding.
  return {n_before == n_steps ? half : half * n_before / n_steps,
          n_after == n_steps ? half : half * n_after / n_steps};
}

void DelayCentre::on_circle(const Changes& changes, int& reached) const {
  for (const MatrixXcd& H : H_) {
    for (int k = 0; k < reached; ++k) {
      if (!(norm(H * changes[static_cast<size_t>(k)]) < largest)) reached = k;
    }
  }
}

/// In the disc a pole is at z = p + tr((I - M(z))^-1 N) with N = R G, of rank one, and the rest
/// M(z) = H G - N / (z - p). M(p) is known, and M(z) - M(p) by Schwarz's lemma no more than
/// |z - p| / width of its largest value round the disc.
void DelayCentre::in_disc(const Followed& about, const Changes& changes, int& reached) {
  const Index m = about.R.rows();
  const MatrixXcd I = MatrixXcd::Identity(m, m);
  Complex before_last = about.pole, last = about.pole;
  double bend = 0;
  // The second step tells how the path bends in the first.
  for (int k = 0; reached > 0 && k < std::max(reached, 2); ++k) {
    const MatrixXcd& G = changes[static_cast<size_t>(k)];
    const MatrixXcd N = about.R * G, M = about.H_0 * G;
    const MatrixXcd inverse = (I - M).partialPivLu().inverse();
    const double kappa = norm(inverse), strength = norm(N);
    double rest = 0;
    for (size_t i = 0; i < about.around.size(); ++i) {
      rest = std::max(rest, norm(about.H_around[i] * G - N / about.around[i] - M));
    }
    rest /= largest;  // between the points
    bool proven = kappa * rest < 0.9;
    if (proven) {
      const double off = std::min(about.width, kappa * strength / (1 - kappa * rest));
      const double varied = kappa * rest * off / about.width;
      const double unknown = kappa * strength * varied / (1 - varied);
      const Complex here = about.pole + (inverse * N).trace();
      // Between two steps a path leaves its chord by an eighth of its second difference, on both
      // sides of the step that this is of: a pole may leave and be back in one step.
      if (k > 0) {
        bend = std::max(bend, std::abs(here - 2.0 * last + before_last) / 4);
        proven = std::max(std::abs(before_last), std::abs(last)) + bend < circle;
      }
      before_last = last;
      last = here;
      proven = proven && std::abs(here) + unknown + bend < circle;
    }
    // What lies behind a step is not known before the next.
    if (!proven) {
      reached = std::clamp(k - 1, 0, reached);
      return;
    }
  }
}

}  // namespace stillframe

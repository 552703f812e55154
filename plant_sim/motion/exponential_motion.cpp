#include "plant_sim/motion/exponential_motion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/numerics/phi_functions.hpp"

namespace stillframe {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr int most_halvings = 20;
constexpr int most_sweeps = 10;
/// Of the tolerance, what the sweeps may leave.
constexpr double sweep_share = 0.05;
/// What an acceleration does in a part, in units of how far the rates really went from where they
/// began: a mode that turns often in the part accelerates much and comes nowhere. Where nothing
/// does, an acceleration that rises from rest or falls to it is two or three times its mean.
constexpr double of_change = 3;
/// What rounding leaves of relative differences, in some multiplications.
constexpr double rounding = 64 * std::numeric_limits<double>::epsilon();

/// Radau points on [0, 1]; the last is the end, so that what is evaluated there can be read out.
std::array<double, 3> radau_points() { return {0.4 - std::sqrt(0.06), 0.4 + std::sqrt(0.06), 1.0}; }

/// Coefficients L(k, j) of the Lagrange polynomials l_j(u) = sum_k L(k, j) u^k of three points.
Eigen::Matrix3d lagrange_coefficients(const std::array<double, 3>& c) {
  Eigen::Matrix3d vandermonde;
  for (int i = 0; i < 3; ++i)
    vandermonde.row(i) << 1.0, c[static_cast<size_t>(i)],
        c[static_cast<size_t>(i)] * c[static_cast<size_t>(i)];
  return vandermonde.inverse();
}

}  // namespace

/// Of a part of duration h with nodes c_i h: W_i,j = integral of exp((c_i h - s) A) l_j(s / h) over
/// s from 0 to c_i h, its columns of g alone.
struct ExponentialMotion::Part {
  double duration;
  std::vector<LinearStep> steps;  ///< to the nodes
  std::vector<MatrixXd> W;        ///< 3 x 3 of n x n_g
  MatrixXd W_even;                ///< n x n_g, the same at the end of a constant
  MatrixXd W_sizes;               ///< n x n_g, its entries without their signs

  Part(const LinearEquations& linear, Index n_g, double h, double lag_rate) : duration(h) {
    const auto c = radau_points();
    const Eigen::Matrix3d L = lagrange_coefficients(c);
    for (int i = 0; i < 3; ++i) {
      const double tau = c[static_cast<size_t>(i)] * h;
      steps.emplace_back(linear, tau, lag_rate);
      const auto phi = phi_functions(tau * linear.A, 3);
      for (int j = 0; j < 3; ++j) {
        MatrixXd sum = MatrixXd::Zero(linear.A.rows(), n_g);
        double factorial = 1;  // integral of exp((tau - s) A) (s / h)^k = k! tau^(k+1) / h^k phi
        for (int k = 0; k < 3; ++k) {
          factorial *= std::max(k, 1);
          const double scale = L(k, j) * factorial * tau * std::pow(tau / h, k);
          sum += scale * phi[static_cast<size_t>(k) + 1].rightCols(n_g);
        }
        W.push_back(sum);
      }
      if (i == 2) W_even = tau * phi[1].rightCols(n_g);
      W_sizes = W_even.cwiseAbs();
    }
  }
};

ExponentialMotion::ExponentialMotion(MinimalEquations equations, LinearEquations linear,
                                     FramePoints points, double relative_tolerance,
                                     const Drive& drive, const std::vector<double>& durations)
    : equations_(std::move(equations)),
      linear_(std::move(linear)),
      points_(std::move(points)),
      relative_tolerance_(relative_tolerance),
      A_sizes_(linear_.A.bottomRows(equations_.size() - equations_.n_d()).cwiseAbs()),
      B_p_sizes_(linear_.B_p.bottomRows(A_sizes_.rows()).cwiseAbs()),
      B_v_sizes_(linear_.B_v.bottomRows(A_sizes_.rows()).cwiseAbs()),
      start_(start_for(drive)),
      y_(equations_.start()),
      begin_(y_),
      end_(VectorXd::Zero(y_.size())),
      seen_end_(y_),
      x_dot_(equations_.data().x_dot),
      change_(VectorXd::Zero(y_.size())),
      rate_(change_),
      linear_rate_(VectorXd::Zero(equations_.size() - equations_.n_d())),
      q_r_(drive.floor().floor_acceleration()),
      q_r_dot_(q_r_),
      legs_a_(VectorXd::Zero(equations_.n_legs())),
      nodes_(MatrixXd::Zero(y_.size(), n_nodes)),
      g_(MatrixXd::Zero(linear_rate_.size(), n_nodes)),
      g_new_(g_) {
  for (const double duration : durations) part(drive, duration);
}

ExponentialMotion::~ExponentialMotion() = default;

const ExponentialMotion::Part& ExponentialMotion::part(const Drive& drive, double duration) {
  for (const auto& known : parts_) {
    if (known->duration == duration) return *known;
  }
  parts_.push_back(
      std::make_unique<Part>(linear_, linear_rate_.size(), duration, drive.actuators().rate()));
  return *parts_.back();
}

/// g of the last part, taken on into the next one by its polynomial. Inputs jump in between, but
/// what they do to g is small, and the polynomial itself is smooth.
void ExponentialMotion::extrapolate(const Part& part) noexcept {
  if (last_duration_ == 0) return;
  static const auto c = radau_points();
  static const Eigen::Matrix3d L = lagrange_coefficients(c);
  Eigen::Matrix3d weights;
  for (int i = 0; i < n_nodes; ++i) {
    const double u = 1 + c[static_cast<size_t>(i)] * part.duration / last_duration_;
    weights.col(i) = L.transpose() * Eigen::Vector3d(1, u, u * u);
  }
  g_new_.noalias() = g_ * weights;
  g_.swap(g_new_);
}

void ExponentialMotion::start_sweeps(const Drive& drive, double from, const Part& part) noexcept {
  gather(drive, from, start_);
  extrapolate(part);
  for (int i = 0; i < n_nodes; ++i) {
    auto node = nodes_.col(i);
    part.steps[static_cast<size_t>(i)].apply(drive, start_, y_, node);
    for (int j = 0; j < n_nodes; ++j) {
      node.noalias() += part.W[static_cast<size_t>(3 * i + j)] * g_.col(j);
    }
  }
}

bool ExponentialMotion::evaluate_rests(const Drive& drive, double from, const Part& part) noexcept {
  const Index n_g = linear_rate_.size(), n = equations_.n_d();
  // A sweep that has not converged may have been anywhere, above all in a stiff mode: what it saw
  // is forgotten with the next one.
  seen_ = known_;
  seen_.acceleration = std::max(seen_.acceleration, least_acceleration());
  for (int i = 0; i < n_nodes; ++i) {
    const double tau = part.steps[static_cast<size_t>(i)].tau(), t = from + tau;
    if (!equations_.evaluate(drive, t, nodes_.col(i), rate_)) return false;
    seen_.acceleration =
        std::max(seen_.acceleration, equations_.q_d_ddot().lpNorm<Eigen::Infinity>());
    for (Index k = n; k < 2 * n; ++k) {
      seen_.change = std::max(seen_.change, std::abs(nodes_(k, i) - begin_(k)));
    }
    drive.floor().floor_at(t, q_r_, q_r_dot_);
    const double left = std::exp(-drive.actuators().rate() * tau);
    legs_a_ = start_.settled + left * start_.transient;
    linear_rate_.noalias() = linear_.A.bottomRows(n_g) * nodes_.col(i);
    linear_rate_.noalias() += linear_.B_p.bottomRows(n_g) * q_r_;
    linear_rate_.noalias() += linear_.B_v.bottomRows(n_g) * q_r_dot_;
    linear_rate_.noalias() += linear_.B_a.bottomRows(n_g) * drive.floor().floor_acceleration();
    linear_rate_.noalias() += linear_.B_u.bottomRows(n_g) * legs_a_;
    if (drive.external().size() > 0) {
      linear_rate_.noalias() += linear_.B_f.bottomRows(n_g) * drive.external();
    }
    g_new_.col(i) = rate_.tail(n_g) - linear_rate_;
  }
  return true;
}

/// No error below what this does means anything.
double ExponentialMotion::least_acceleration() const noexcept {
  return equations_.rest_acceleration() * 100 / relative_tolerance_;
}

double ExponentialMotion::size_of(const VectorXd& dy) const noexcept {
  const Index n = equations_.n_d();
  // The smallest normal numbers keep it finite for a frame at rest on a floor at rest.
  const double velocity = std::max(std::min(seen_.acceleration * whole_, of_change * seen_.change),
                                   least_acceleration() * whole_) +
                          1e-290;
  const double position = velocity * whole_ + 1e-290;
  const auto part = [&](Index begin, Index count, double scale) {
    return count == 0
               ? 0.0
               : dy.segment(begin, count).lpNorm<Eigen::Infinity>() / (relative_tolerance_ * scale);
  };
  return std::max(
      {part(0, n, position), part(n, n, velocity), part(2 * n, equations_.n_filtered(), position)});
}

double ExponentialMotion::collocation_error(const Part& part) noexcept {
  // g = a_0 P_0 + a_1 P_1 + a_2 P_2 in Legendre polynomials of [0, 1], from divided differences;
  // a_3 is about as much smaller than a_2 as that is smaller than a_1, and so on. The points
  // integrate up to a_4 exactly where motion is slow; what is fast divides a_3 by its frequency.
  static const auto c = radau_points();
  const double a_1 = (g_.col(2) - g_.col(0)).lpNorm<Eigen::Infinity>() / (c[2] - c[0]) / 2;
  linear_rate_ =
      ((g_.col(2) - g_.col(1)) / (c[2] - c[1]) - (g_.col(1) - g_.col(0)) / (c[1] - c[0])) /
      (c[2] - c[0]) / 6;
  const double a_2 = linear_rate_.lpNorm<Eigen::Infinity>();
  if (a_2 <= rounding * seen_.acceleration) return 0;
  change_.noalias() = part.W_even * linear_rate_;
  // A slow and large change of g makes a_1 large and says nothing of a_3, which a fast and small
  // one makes: 0.1 a_2 of a mode that turns by a radian in the part, 7 j_3(1/2) / (5 j_2(1/2)) in
  // spherical Bessel functions. Less is not believed.
  const double ratio = std::clamp(a_2 / std::max(a_1, a_2), 0.1, 1.0);
  return ratio * ratio * size_of(change_);
}

double ExponentialMotion::rounding_size(const Part& part) noexcept {
  // g is what f and A y + B u leave of each other, so that these round in it; the floor may have
  // drifted far, and displacements at the operating point may be large beside those of the run.
  change_ = y_.cwiseAbs();
  linear_rate_.noalias() = A_sizes_ * change_;
  q_r_ = start_.q_r.cwiseAbs();
  linear_rate_.noalias() += B_p_sizes_ * q_r_;
  q_r_ = start_.q_r_dot.cwiseAbs();
  linear_rate_.noalias() += B_v_sizes_ * q_r_;
  linear_rate_ *= 8 * std::numeric_limits<double>::epsilon();
  linear_rate_.head(equations_.n_d()) += 8 * equations_.rounding();
  change_.noalias() = part.W_sizes * linear_rate_;
  return size_of(change_);
}

/// The change of y at a node if g changes by g_new_.
void ExponentialMotion::change_at(const Part& part, int node) noexcept {
  change_.noalias() = part.W[static_cast<size_t>(3 * node)] * g_new_.col(0);
  change_.noalias() += part.W[static_cast<size_t>(3 * node + 1)] * g_new_.col(1);
  change_.noalias() += part.W[static_cast<size_t>(3 * node + 2)] * g_new_.col(2);
}

/// The rate at which the sweeps converge, before a second one shows it. The motion may have grown
/// since it was last seen: it ages as in RADAU5 (Hairer, Wanner, Solving ordinary differential
/// equations II, section IV.8), and it counts only where the first sweep changes no more than twice
/// what it did then.
double ExponentialMotion::rate_of_first(double size) noexcept {
  rate_ago_ = std::pow(rate_ago_, 0.8);
  return size <= 2 * size_ago_ ? rate_ago_ : 1.0;
}

ExponentialMotion::Outcome ExponentialMotion::attempt(const Drive& drive, double from,
                                                      const Part& part) noexcept {
  // Changes of this size in units of the tolerance are rounding.
  const double enough = std::max(sweep_share, rounding / relative_tolerance_);
  start_sweeps(drive, from, part);
  settled_ = false;
  double before = 0;
  for (int sweep = 1; sweep <= most_sweeps; ++sweep) {
    if (!evaluate_rests(drive, from, part)) return Outcome::cannot_evaluate;
    g_.swap(g_new_);
    g_new_ = g_ - g_new_;
    end_ = nodes_.col(2);
    change_at(part, 2);
    seen_end_ = end_;
    end_ += change_;
    const double size = size_of(change_);
    if (!std::isfinite(size)) return Outcome::halve;
    const double seen = sweep > 1 ? size / before : rate_of_first(size);
    if (sweep == 2) {
      rate_ago_ = std::clamp(3 * seen, 1e-6, 1.0);
      size_ago_ = before;
    }
    const double left = sweep > 1 ? size * seen / (1 - std::min(seen, 0.5)) : size * seen;
    if (left < enough) {
      settled_ = true;
      const double error = collocation_error(part);
      // It grows with the fifth power of the duration or faster.
      easy_ = sweep <= 2 && error < 0.02;
      return error < 1 || error < rounding_size(part) ? Outcome::ok : Outcome::halve;
    }
    if (sweep > 1 && seen > 0.5) return size < rounding_size(part) ? Outcome::ok : Outcome::halve;
    before = size;
    nodes_.col(2) = end_;
    for (int i = 0; i < 2; ++i) {
      change_at(part, i);
      nodes_.col(i) += change_;
    }
  }
  return Outcome::halve;
}

Motion::Status ExponentialMotion::advance(const Drive& drive, double duration) noexcept {
  std::int64_t done = 0;  // in parts of duration / 2^halvings_
  whole_ = duration;
  known_ = {};
  begin_ = y_;
  while (done < (std::int64_t{1} << halvings_)) {
    const double h = std::ldexp(duration, -halvings_);
    const Outcome outcome = attempt(drive, static_cast<double>(done) * h, part(drive, h));
    if (outcome == Outcome::ok) {
      known_ = seen_;
      equations_.keep();
      y_.swap(end_);
      last_duration_ = h;
      ++done;
      // Back to longer parts where one begins.
      if (easy_ && halvings_ > 0 && done % 2 == 0) {
        --halvings_;
        done /= 2;
      }
      continue;
    }
    // An attempt whose sweeps did not settle may have been anywhere. One that did knows what is to
    // come in the part: where motion begins at its end, shorter parts alone would each be compared
    // with next to nothing.
    if (settled_) known_ = seen_;
    equations_.go_back();
    g_.setZero();
    last_duration_ = 0;
    if (++halvings_ > most_halvings) {
      halvings_ = 0;
      y_ = begin_;
      return outcome == Outcome::cannot_evaluate ? Status::equations_failed : Status::failed;
    }
    done *= 2;
  }
  // What the last sweep moved after the equations had been looked at, in the geometry of there.
  end_ = y_ - seen_end_;
  const Data& data = equations_.data();
  x_dot_ = data.x_dot;
  x_dot_.noalias() += data.DF * end_.segment(equations_.n_d(), equations_.n_d());
  return Status::ok;
}

bool ExponentialMotion::hand_over(const Drive& drive, MotionSnapshot& to) noexcept {
  return equations_.hand_over(drive, y_, to);
}

void ExponentialMotion::take_over(const MotionSnapshot& from) noexcept {
  equations_.take_over(from);
  y_ = from.y;
  end_.setZero();
  x_dot_ = from.x_dot;
  g_.setZero();
  last_duration_ = 0;
  halvings_ = 0;
  rate_ago_ = 1;
}

void ExponentialMotion::velocities(VectorXd& v) const noexcept {
  points_.velocities(equations_.data().x, x_dot_, v);
}

void ExponentialMotion::elastic_stresses(VectorXd& sigma) const noexcept {
  for (Index i = 0; i < equations_.n_legs(); ++i) sigma(i) = equations_.elastic_stress(i);
  sigma.noalias() += linear_.S_y * end_;
}

void ExponentialMotion::filtered_stresses(VectorXd& sigma) const noexcept {
  sigma = equations_.stress_scale() * y_.tail(equations_.n_filtered());
}

Eigen::VectorXd ExponentialMotion::displacements() const { return y_.head(equations_.n_d()); }

}  // namespace stillframe

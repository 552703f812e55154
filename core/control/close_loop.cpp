#include "core/control/close_loop.hpp"

#include <Eigen/LU>
#include <stdexcept>
#include <string>

#include "core/systems/balanced_states.hpp"

namespace stillframe {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;

namespace {

void check_shapes(const SampledPlant& plant, const DiscreteLaw& law) {
  const Index m = plant.Gamma_u.cols(), n = law.A.rows();
  const Index n_in = law.D.cols();
  const bool fits = law.A.cols() == n && law.B.rows() == n && law.B.cols() == n_in &&
                    law.C.rows() == m && law.C.cols() == n && law.D.rows() == m &&
                    (n_in == m || (n_in == 2 * m && !law.subtract_applied)) &&
                    plant.C_sigma.rows() == m;
  if (!fits) {
    throw std::invalid_argument("close_loop: the law does not fit a plant of " + std::to_string(m) +
                                " legs");
  }
  const LinearSystem& feed = law.feed_forward;
  if (feed.D.cols() == 0 || plant.Gamma_w.cols() == 0) return;
  if (feed.D.rows() != m || feed.D.cols() > plant.Gamma_w.cols()) {
    throw std::invalid_argument("close_loop: the feed-forward hears " +
                                std::to_string(feed.D.cols()) + " accelerations, the plant has " +
                                std::to_string(plant.Gamma_w.cols()));
  }
}

/// The floor that a feed-forward hears: as many of the plant's inputs.
Index n_heard(const SampledPlant& plant, const DiscreteLaw& law) {
  return plant.Gamma_w.cols() > 0 ? law.feed_forward.D.cols() : 0;
}

/// Where the parts of xi stand: plant, the floor as it was measured last and the feed-forward that
/// hears it, law, c_0 (the command that held before t_k), the filtered
/// report, the reports on their way, oldest first, and the commands on their way, leg by leg,
/// oldest first.
struct Layout {
  Index n, m, floor, feed, law, held, filtered, reports, pending, total;

  Layout(const SampledPlant& plant, const DiscreteLaw& control)
      : n(plant.Phi.rows()), m(plant.Gamma_u.cols()), floor(n) {
    const Index p = n_heard(plant, control);
    feed = floor + p;
    law = feed + (p > 0 ? control.feed_forward.A.rows() : 0);
    held = law + control.A.rows();
    filtered = held + m;
    reports = filtered + (control.subtract_applied && control.applied_memory > 0 ? m : 0);
    const bool reported = control.subtract_applied || control.hears_applied();
    pending = reports + (reported ? m * plant.report_age : 0);
    total = pending + plant.whole_delay.sum();
  }
};

/// Moves a queue of m-blocks on by one and puts `newest` (m rows) in behind.
void shift_in(MatrixXd& A, Index begin, Index end, Index m, const MatrixXd& newest) {
  for (Index row = begin; row < end; row += m) {
    if (row + m < end) {
      A.block(row, row + m, m, m).setIdentity();
    } else {
      A.middleRows(row, m) = newest;
    }
  }
}

/// A closed loop in the states of Layout, and what its law hears of them.
struct Connected {
  SampledLoop loop;
  MatrixXd C_e;   ///< of sigma, less the applied force where the law takes it out
  Index n_plant;  ///< before those of the law
};

Connected connected(const SampledPlant& plant, const DiscreteLaw& law) {
  check_shapes(plant, law);
  const Layout at(plant, law);
  const Index n = at.n, m = at.m, n_law = law.A.rows();

  // e = C_e xi + v is the law's input, u = C_u xi + D v its command, c_1 = C_f xi what takes effect
  // in the coming interval.
  // A law that hears the applied force has that below sigma in e.
  MatrixXd C_e = MatrixXd::Zero(m, at.total), C_report = C_e, C_applied = C_e;
  C_e.leftCols(n) = plant.C_sigma;
  C_e.middleCols(at.held, m) = plant.D_sigma;
  C_report.leftCols(n) = plant.C_report;
  C_report.middleCols(at.held, m) = plant.D_report;
  if (law.subtract_applied || law.hears_applied()) {
    C_applied = C_report;
    if (plant.report_age > 0) {
      C_applied.setZero();
      C_applied.middleCols(at.reports, m).setIdentity();
    }
  }
  if (law.subtract_applied) {
    if (law.applied_memory > 0) {
      C_applied *= 1 - law.applied_memory;
      C_applied.middleCols(at.filtered, m).diagonal().array() += law.applied_memory;
    }
    C_e -= C_applied;
  }
  MatrixXd C_in = C_e;
  if (law.hears_applied()) {
    C_in.resize(2 * m, at.total);
    C_in << C_e, C_applied;
  }
  const MatrixXd B_v = law.B.leftCols(m), D_v = law.D.leftCols(m);
  MatrixXd C_u = law.D * C_in;
  C_u.middleCols(at.law, n_law) += law.C;
  const LinearSystem& forward = law.feed_forward;
  const Index p = at.feed - at.floor, n_feed = at.law - at.feed;
  if (p > 0) {
    C_u.middleCols(at.floor, p) += forward.D;
    C_u.middleCols(at.feed, n_feed) += forward.C;
  }
  // A leg whose command takes effect at once has it straight from the law, others from the queue.
  MatrixXd C_f = C_u, D_f = D_v;  // of xi and v
  Index queue = at.pending;
  for (Index i = 0; i < m; ++i) {
    if (plant.whole_delay(i) == 0) continue;
    C_f.row(i).setZero();
    C_f(i, queue) = 1;
    D_f.row(i).setZero();
    queue += plant.whole_delay(i);
  }

  SampledLoop loop;
  loop.n_exogenous = plant.n_exogenous + p + n_feed;
  loop.sample_time = plant.sample_time;
  loop.A = MatrixXd::Zero(at.total, at.total);
  loop.A.topRows(n) = plant.Gamma_u * C_f;
  loop.A.topLeftCorner(n, n) += plant.Phi;
  loop.A.block(0, at.held, n, m) += plant.Gamma_0;
  loop.A.middleRows(at.law, n_law) = law.B * C_in;
  loop.A.block(at.law, at.law, n_law, n_law) += law.A;
  loop.A.middleRows(at.held, m) = C_f;
  if (at.reports > at.filtered) loop.A.middleRows(at.filtered, m) = C_applied;
  shift_in(loop.A, at.reports, at.pending, m, C_report);
  loop.B = MatrixXd::Zero(at.total, plant.Gamma_w.cols());
  loop.B.topRows(n) = plant.Gamma_w;
  if (p > 0) {
    // What the floor did up to t_{k+1} is in the measurement of t_{k+1}.
    loop.B.block(at.floor, 0, p, p).setIdentity();
    loop.A.block(at.feed, at.floor, n_feed, p) = forward.B;
    loop.A.block(at.feed, at.feed, n_feed, n_feed) = forward.A;
  }
  loop.B_v = MatrixXd::Zero(at.total, m);
  loop.B_v.topRows(n) = plant.Gamma_u * D_f;
  loop.B_v.middleRows(at.law, n_law) = B_v;
  loop.B_v.middleRows(at.held, m) = D_f;
  queue = at.pending;
  for (Index i = 0; i < m; ++i) {
    if (plant.whole_delay(i) == 0) continue;
    const Index end = queue + plant.whole_delay(i);
    shift_in(loop.A, queue, end, 1, C_u.row(i));
    loop.B_v.row(end - 1) = D_v.row(i);
    queue = end;
  }
  loop.C = plant.D_yu * C_f;
  loop.C.leftCols(n) += plant.C_y;
  loop.C.middleCols(at.held, m) += plant.D_0;
  loop.D = plant.D_yw;
  loop.D_v = plant.D_yu * D_f;
  return {std::move(loop), std::move(C_e), at.law};
}

}  // namespace

SampledLoop close_loop(const SampledPlant& plant, const DiscreteLaw& law) {
  Connected closed = connected(plant, law);
  const BalancedStates states(closed.loop, closed.n_plant);
  return states.of(std::move(closed.loop));
}

SampledLoop close_loop_with_added_force(SampledPlant plant, DiscreteLaw law) {
  // Channels of a floor that moves nothing, passed on as they are measured.
  const Index p = plant.Gamma_w.cols(), m = law.D.rows(), n = plant.Phi.rows();
  plant.Gamma_w.conservativeResizeLike(MatrixXd::Zero(n, p + m));
  plant.D_yw.conservativeResizeLike(MatrixXd::Zero(plant.D_yw.rows(), p + m));
  law.feed_forward = {.A = MatrixXd::Zero(0, 0),
                      .B = MatrixXd::Zero(0, p + m),
                      .C = MatrixXd::Zero(m, 0),
                      .D = MatrixXd::Zero(m, p + m)};
  law.feed_forward.D.rightCols(m).setIdentity();
  return close_loop(plant, law);
}

GainedLoop gain_loop(const SampledPlant& plant, const DiscreteLaw& law) {
  DiscreteLaw silent = law;
  silent.C.setZero();
  silent.D.setZero();
  silent.feed_forward.C.setZero();
  silent.feed_forward.D.setZero();
  Connected closed = connected(plant, law);
  const Index n_plant = closed.n_plant;
  const BalancedStates states(closed.loop, n_plant);
  return {.closed = states.of(std::move(closed.loop)),
          .released = states.of(connected(plant, silent).loop),
          .C_e = states.rows(closed.C_e),
          .n_plant = n_plant};
}

SampledLoop GainedLoop::at(double share) const {
  SampledLoop loop = closed;
  loop.A += (1 - share) * (released.A - closed.A);
  loop.B_v += (1 - share) * (released.B_v - closed.B_v);
  loop.C += (1 - share) * (released.C - closed.C);
  loop.D_v += (1 - share) * (released.D_v - closed.D_v);
  return loop;
}

MatrixXcd return_ratio(const SampledPlant& plant, const DiscreteLaw& law, double omega) {
  const Complex z = std::polar(1.0, omega * plant.sample_time);
  const Index m = plant.Gamma_u.cols(), n = plant.Phi.rows() - plant.n_exogenous;
  const MatrixXd A = plant.Phi.topLeftCorner(n, n);
  const MatrixXcd to_state =
      plant.Gamma_u.topRows(n).cast<Complex>() + plant.Gamma_0.topRows(n).cast<Complex>() / z;
  MatrixXcd resolvent = -A.cast<Complex>();
  resolvent.diagonal().array() += z;
  const MatrixXcd x = resolvent.partialPivLu().solve(to_state);
  const MatrixXcd sigma = plant.C_sigma.leftCols(n) * x + plant.D_sigma.cast<Complex>() / z;
  MatrixXcd law_resolvent = -law.A.cast<Complex>();
  law_resolvent.diagonal().array() += z;
  MatrixXcd F = law.C * law_resolvent.partialPivLu().solve(law.B.cast<Complex>()) + law.D;
  for (Index i = 0; i < m; ++i) F.row(i) *= std::pow(z, -plant.whole_delay(i));
  const MatrixXcd of_sigma = F.leftCols(m) * sigma;
  if (!law.subtract_applied && !law.hears_applied()) return -of_sigma;
  MatrixXcd report = plant.C_report.leftCols(n) * x + plant.D_report.cast<Complex>() / z;
  report *=
      std::pow(z, -plant.report_age) * (1 - law.applied_memory) / (1.0 - law.applied_memory / z);
  // c = F (sigma - r): what the law takes out of sigma, or hears beside it, is the report of its
  // own command.
  const MatrixXcd of_report =
      law.subtract_applied ? MatrixXcd(F * report) : MatrixXcd(-F.rightCols(m) * report);
  return -(MatrixXcd::Identity(m, m) + of_report).partialPivLu().solve(of_sigma);
}

}  // namespace stillframe

#include "core/control/mode_design.hpp"

#include <algorithm>
#include <cmath>

#include "core/errors/input_error.hpp"
#include "core/numerics/decibels.hpp"
#include "core/numerics/infinity.hpp"
#include "core/numerics/simplex_search.hpp"
#include "core/numerics/two_pi.hpp"

namespace stillframe {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

namespace {

/// Forces of all legs over those that are reported, and samples of more delay, with which a loop
/// has to be stable.
constexpr double gains[] = {0.75, 1.25};
constexpr double later = 1;

/// (b_2 s^2 + b_1 s + b_0) / (s^2 + 2 zeta omega s + omega^2), its states of one size.
LinearSystem second_order(double b_2, double b_1, double b_0, double zeta, double omega,
                          double sample_time) {
  LinearSystem out{MatrixXd(2, 2), MatrixXd(2, 1), MatrixXd(1, 2), MatrixXd(1, 1)};
  out.A << 0, omega, -omega, -2 * zeta * omega;
  out.B << 0, omega;
  out.C << b_0 / (omega * omega) - b_2, b_1 / omega - 2 * zeta * b_2;
  out.D << b_2;
  return tustin(out, sample_time);
}

/// (s + zero) / (s + pole).
LinearSystem first_order(double zero, double pole, double sample_time) {
  LinearSystem out{MatrixXd(1, 1), MatrixXd(1, 1), MatrixXd(1, 1), MatrixXd(1, 1)};
  out.A << -pole;
  out.B << pole;
  out.C << (zero - pole) / pole;
  out.D << 1;
  return tustin(out, sample_time);
}

LinearSystem floor_weight(const ModeGoal& goal, double edge_hz, double T_s) {
  const double edge = two_pi * edge_hz, d = goal.omega_d, ratio = std::pow(edge / d, 2);
  // Damping ratios of the two pairs of a Butterworth filter.
  const double zeta_1 = std::sin(two_pi / 16), zeta_2 = std::sin(3 * two_pi / 16);
  const LinearSystem first =
      second_order(ratio, 2 * goal.zeta * d * ratio, d * d * ratio, zeta_1, edge, T_s);
  const LinearSystem second = second_order(0, 0, edge * edge, zeta_2, edge, T_s);
  return in_series(in_series(first, second), first_order(4 * d, d / 5, T_s));
}

/// Whether a loop is stable with what it does not know of.
double most_radius(const SampledMode& mode, const LinearSystem& F) {
  double worst = mode.radius(F, 1, later);
  for (const double gain : gains) worst = std::max(worst, mode.radius(F, gain));
  return worst;
}

/// By how many dB T is above the goal's bounds outside its band.
double excess_db(const ModeGoal& goal, const VectorXd& hz, const VectorXcd& T) {
  // In the band the level may be what it is, but for the peak.
  constexpr double any_level = 1000;
  return decibels((T.cwiseAbs().array() / bound_of(goal, any_level, hz).array()).maxCoeff());
}

}  // namespace

H2Problem h2_problem(const SampledMode& mode, const ModeGoal& goal, const H2Weights& weights) {
  const LawPorts& ports = mode.ports();
  const double T_s = mode.sampling().sample_time, d = goal.omega_d;
  const LinearSystem floor = floor_weight(goal, weights.edge_hz, T_s);
  const LinearSystem target = second_order(0, 0, d * d, goal.zeta, d, T_s);
  // At low rates three edges are beyond what is sampled.
  const double about = std::min(3 * weights.edge_hz, 0.3 / T_s) * two_pi;
  const LinearSystem noise =
      second_order(1, weights.noise_hump * about, about * about, 0.5, about, T_s);
  const Index n_p = ports.A.rows(), n_f = floor.A.rows(), n_t = 2, n_n = 2;
  const Index f = n_p, t = f + n_f, s = t + n_t, n = s + n_n;
  H2Problem out;
  out.A = MatrixXd::Zero(n, n);
  out.B_w = MatrixXd::Zero(n, 3);
  out.B_u = MatrixXd::Zero(n, 1);
  out.A.topLeftCorner(n_p, n_p) = ports.A;
  out.A.block(0, f, n_p, n_f) = ports.B_w * floor.C;
  out.A.block(f, f, n_f, n_f) = floor.A;
  out.A.block(t, f, n_t, n_f) = target.B * floor.C;
  out.A.block(t, t, n_t, n_t) = target.A;
  out.A.block(s, s, n_n, n_n) = noise.A;
  out.B_w.col(0).head(n_p) = ports.B_w * floor.D;
  out.B_w.col(0).segment(f, n_f) = floor.B;
  out.B_w.col(0).segment(t, n_t) = target.B * floor.D;
  out.B_w.col(1).head(n_p) = ports.B_w;
  out.B_w.col(2).segment(s, n_n) = weights.noise * noise.B;
  out.B_u.topRows(n_p) = ports.B_u;
  out.C_z = MatrixXd::Zero(2, n);
  out.C_z.row(0).head(n_p) = ports.C_y;
  out.C_z.row(0).segment(f, n_f) = (ports.D_yw - target.D) * floor.C;
  out.C_z.row(0).segment(t, n_t) = -target.C;
  out.D_zw = MatrixXd::Zero(2, 3);
  out.D_zw.row(0) << ((ports.D_yw - target.D) * floor.D)(0, 0), ports.D_yw(0, 0), 0;
  out.D_zu = MatrixXd::Zero(2, 1);
  out.D_zu << ports.D_yu(0, 0), weights.effort;
  out.C_e = MatrixXd::Zero(1, n);
  out.C_e.leftCols(n_p) = ports.C_e;
  out.C_e.rightCols(n_n) = noise.C;
  out.D_ew = MatrixXd::Zero(1, 3);
  out.D_ew(0, 2) = weights.noise * noise.D(0, 0);
  return out;
}

bool keeps(const SampledMode& mode, const ModeGoal& goal, const ModeResponses& responses,
           const ModeLaw& law) {
  // What T is off its bounds between two frequencies of the grid.
  constexpr double between_db = 0.1;
  return law.disk >= goal.disk && most_radius(mode, law.F) < largest_stable_radius &&
         excess_db(goal, responses.hz, responses.T(responses.of(law.F))) < between_db;
}

std::optional<ModeLaw> h2_mode_law(const SampledMode& mode, const ModeGoal& goal) {
  const ModeResponses responses(mode, goal);
  const auto weights_of = [&](const VectorXd& knobs) {
    const VectorXd values = knobs.array().exp();
    return H2Weights{.edge_hz = values(0), .noise = values(1), .noise_hump = values(2)};
  };
  // The margin on the grid is above the margin by what lies between its frequencies.
  constexpr double reserve = 1.003;
  const auto cost = [&](const VectorXd& knobs) {
    const H2Weights weights = weights_of(knobs);
    if (!(weights.edge_hz < 0.4 / mode.sampling().sample_time)) return infinity;
    H2Law law;
    try {
      law = h2_law(h2_problem(mode, goal, weights));
    } catch (const Refusal&) {
      return infinity;
    }
    if (!(mode.radius(law.law) < largest_stable_radius)) return infinity;
    const VectorXcd F = responses.of(law.law), T = responses.T(F);
    const double disk = 1 / (responses.S(F).array() - 0.5).abs().maxCoeff();
    const double radius = most_radius(mode, law.law);
    // Every rule that is broken costs more than breaking it wins.
    return level_of(goal, responses.hz, T) + 200 * std::max(reserve * goal.disk - disk, 0.0) +
           5 * std::max(excess_db(goal, responses.hz, T), 0.0) +
           (radius < largest_stable_radius ? 0.0 : 20 + 200 * (radius - 1));
  };
  VectorXd start(3);
  start << std::log(0.85 * goal.to_hz), std::log(2.0), std::log(2.0);
  constexpr int most = 160;
  const Lowest best = simplex_search(cost, start, 0.4, most, 0.02);
  if (!std::isfinite(best.value)) return std::nullopt;
  ModeLaw found{.F = h2_law(h2_problem(mode, goal, weights_of(best.at))).law};
  found.disk = mode.disk_margin(found.F);
  found.level_db = level_of(goal, responses.hz, responses.T(responses.of(found.F)));
  if (!keeps(mode, goal, responses, found)) return std::nullopt;
  return found;
}

}  // namespace stillframe

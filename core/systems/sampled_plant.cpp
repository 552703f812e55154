#include "core/systems/sampled_plant.hpp"

#include <cmath>
#include <map>
#include <stdexcept>
#include <string>
#include <unsupported/Eigen/MatrixFunctions>
#include <utility>

#include "core/numerics/balance.hpp"
#include "core/numerics/two_pi.hpp"

namespace stillframe {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// What is under way is states of the loop; margins look 20 samples beyond any loop's own.
constexpr double longest_delay = 1000;

void check(const LoopPlant& plant, const Sampling& sampling) {
  if (!(sampling.sample_time > 0)) {
    throw std::invalid_argument("sample_and_hold: sample_time must be positive, got " +
                                std::to_string(sampling.sample_time));
  }
  if (!(sampling.delay_samples >= 0 && sampling.delay_samples <= longest_delay)) {
    throw std::invalid_argument("sample_and_hold: the delay must be 0 to 1000, got " +
                                std::to_string(sampling.delay_samples));
  }
  if (sampling.leg_gains.size() != 0 && sampling.leg_gains.size() != plant.B_u.cols()) {
    throw std::invalid_argument("sample_and_hold: expected " + std::to_string(plant.B_u.cols()) +
                                " leg gains, got " + std::to_string(sampling.leg_gains.size()));
  }
  if (sampling.sensor_gains.size() != 0 && sampling.sensor_gains.size() != plant.B_u.cols()) {
    throw std::invalid_argument("sample_and_hold: expected " + std::to_string(plant.B_u.cols()) +
                                " sensor gains, got " +
                                std::to_string(sampling.sensor_gains.size()));
  }
  if (sampling.leg_delays.size() != 0 &&
      (sampling.leg_delays.size() != plant.B_u.cols() || !(sampling.leg_delays.minCoeff() >= 0) ||
       !(sampling.leg_delays.maxCoeff() <= longest_delay))) {
    throw std::invalid_argument("sample_and_hold: the delays of legs are " +
                                std::to_string(plant.B_u.cols()) + " numbers from 0 to 1000");
  }
}

/// Plant and instruments in continuous time: x' = A x + B_w w + B_c c, y = C_y x + D_yw w + D_yc c,
/// and what is read at an instant, with c the command in effect just before it.
struct Instrumented {
  MatrixXd A, B_w, B_c, C_y, D_yw, D_yc, C_sigma, D_sigma, C_report, D_report;
};

Instrumented with_instruments(const LoopPlant& plant, const Sampling& sampling) {
  const Instruments& has = sampling.instruments;
  const Index n = plant.A.rows(), m = plant.B_u.cols(), p = plant.B_w.cols();
  const bool lag = has.actuator_lag_hz > 0, filter = has.sensor_filter_hz > 0;
  const Index i_filter = lag ? m : 0, i_z = i_filter + (filter ? m : 0), total = i_z + n;
  const VectorXd gains =
      has.actuator_gain *
      (sampling.leg_gains.size() > 0 ? sampling.leg_gains : VectorXd(VectorXd::Ones(m)));
  const MatrixXd I = MatrixXd::Identity(m, m), G = gains.asDiagonal();

  // The force that acts: F_x x + F_c c. The state of the lag is the force before the gain, which is
  // what is reported.
  MatrixXd F_x = MatrixXd::Zero(m, total), F_c = G;
  Instrumented out;
  out.A = MatrixXd::Zero(total, total);
  out.B_w = MatrixXd::Zero(total, p);
  out.B_c = MatrixXd::Zero(total, m);
  if (lag) {
    const double corner = two_pi * has.actuator_lag_hz;
    F_x.leftCols(m) = G;
    F_c.setZero();
    out.A.topLeftCorner(m, m) = -corner * I;
    out.B_c.topRows(m) = corner * I;
  }
  out.A.bottomRows(n) = plant.B_u * F_x;
  out.A.bottomRightCorner(n, n) += plant.A;
  out.B_c.bottomRows(n) = plant.B_u * F_c;
  out.B_w.bottomRows(n) = plant.B_w;
  out.C_y = plant.D_yu * F_x;
  out.C_y.rightCols(n) += plant.C_y;
  out.D_yw = plant.D_yw;
  out.D_yc = plant.D_yu * F_c;

  out.C_sigma = F_x;
  out.C_sigma.rightCols(n) += plant.C_sigma;
  out.D_sigma = F_c;
  if (filter) {
    const double corner = two_pi * has.sensor_filter_hz;
    out.A.middleRows(i_filter, m) = corner * out.C_sigma;
    out.A.block(i_filter, i_filter, m, m) -= corner * I;
    out.B_c.middleRows(i_filter, m) = corner * F_c;
    out.C_sigma.setZero();
    out.C_sigma.middleCols(i_filter, m).setIdentity();
    out.D_sigma.setZero();
  }
  if (sampling.sensor_gains.size() > 0) {
    out.C_sigma = sampling.sensor_gains.asDiagonal() * out.C_sigma.eval();
    out.D_sigma = sampling.sensor_gains.asDiagonal() * out.D_sigma.eval();
  }
  out.C_report = MatrixXd::Zero(m, total);
  out.D_report = MatrixXd::Zero(m, m);
  if (lag && has.report == Instruments::Report::measured) {
    out.C_report.leftCols(m).setIdentity();
  } else {
    out.D_report.setIdentity();
  }
  return out;
}

/// One part of a sample, w and c held: the state at its end and the integral of y over it.
struct HeldPart {
  MatrixXd Phi, Gamma_w, Gamma_c, Y_x, Y_w, Y_c;
};

HeldPart part_of(const Instrumented& plant, double duration) {
  const Index n = plant.A.rows(), p = plant.B_w.cols(), m = plant.B_c.cols();
  const Index n_y = plant.C_y.rows(), total = n + p + m + n_y;
  MatrixXd augmented = MatrixXd::Zero(total, total);
  augmented.topLeftCorner(n, n + p + m) << plant.A, plant.B_w, plant.B_c;
  augmented.bottomLeftCorner(n_y, n + p + m) << plant.C_y, plant.D_yw, plant.D_yc;
  // Unbalanced, metres beside newtons and slow beside fast modes cost half of the digits.
  const VectorXd S = balancing_scales(augmented);
  const MatrixXd scaled = S.cwiseInverse().asDiagonal() * augmented * S.asDiagonal();
  const MatrixXd E =
      S.asDiagonal() * (scaled * duration).exp().eval() * S.cwiseInverse().asDiagonal();
  return {E.topLeftCorner(n, n),         E.block(0, n, n, p),
          E.block(0, n + p, n, m),       E.bottomLeftCorner(n_y, n),
          E.block(n + p + m, n, n_y, p), E.block(n + p + m, n + p, n_y, m)};
}

}  // namespace

SampledPlant sample_and_hold(const LoopPlant& plant, const Sampling& sampling) {
  check(plant, sampling);
  const double T = sampling.sample_time;
  const Index m = plant.B_u.cols();
  const Instrumented system = with_instruments(plant, sampling);
  const HeldPart whole = part_of(system, T);
  SampledPlant out{.Phi = whole.Phi,
                   .Gamma_w = whole.Gamma_w,
                   .Gamma_0 = MatrixXd::Zero(system.A.rows(), m),
                   .Gamma_u = whole.Gamma_c,
                   .C_y = whole.Y_x / T,
                   .D_yw = whole.Y_w / T,
                   .D_0 = MatrixXd::Zero(plant.C_y.rows(), m),
                   .D_yu = whole.Y_c / T,
                   .C_sigma = system.C_sigma,
                   .D_sigma = system.D_sigma,
                   .C_report = system.C_report,
                   .D_report = system.D_report,
                   .n_exogenous = plant.n_exogenous,
                   .whole_delay = Eigen::VectorXi::Zero(m),
                   .report_age = sampling.instruments.report_age_samples,
                   .sample_time = T};
  // Legs of one delay share the exponentials of the two parts of the sample.
  std::map<double, std::pair<HeldPart, HeldPart>> parts;
  for (Index i = 0; i < m; ++i) {
    const double delay =
        sampling.delay_samples + (sampling.leg_delays.size() > 0 ? sampling.leg_delays(i) : 0.0);
    out.whole_delay(i) = static_cast<int>(std::floor(delay));
    const double fraction = delay - std::floor(delay);
    if (fraction == 0) continue;
    auto found = parts.find(fraction);
    if (found == parts.end()) {
      found = parts
                  .emplace(fraction, std::pair(part_of(system, fraction * T),
                                               part_of(system, (1 - fraction) * T)))
                  .first;
    }
    const auto& [before, after] = found->second;
    out.Gamma_0.col(i) = after.Phi * before.Gamma_c.col(i);
    out.Gamma_u.col(i) = after.Gamma_c.col(i);
    out.D_0.col(i) = (before.Y_c.col(i) + after.Y_x * before.Gamma_c.col(i)) / T;
    out.D_yu.col(i) = after.Y_c.col(i) / T;
  }
  return out;
}

}  // namespace stillframe

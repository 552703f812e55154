#include "core/control/mode_responses.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/control/disk_margin.hpp"
#include "core/control/open_plant.hpp"
#include "core/numerics/decibels.hpp"
#include "core/numerics/two_pi.hpp"

namespace stillframe {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

namespace {

LoopPlant mode_plant(double omega) {
  LoopPlant plant;
  plant.A = MatrixXd::Zero(2, 2);
  plant.A << 0, 1, -omega * omega, 0;
  plant.B_w = plant.B_u = MatrixXd::Zero(2, 1);
  plant.B_w(1, 0) = plant.B_u(1, 0) = -1;
  plant.C_y = MatrixXd::Zero(1, 2);
  plant.C_y(0, 0) = -omega * omega;
  plant.C_sigma = -plant.C_y;
  plant.D_yw = MatrixXd::Zero(1, 1);
  plant.D_yu = MatrixXd::Constant(1, 1, -1);
  return plant;
}

/// open_plant without the floor's last acceleration, which its law does not hear, and with the
/// strain force in place of sigma and the applied force, which is filtered as sigma is.
LawPorts law_ports(const SampledPlant& plant, double applied_memory) {
  const LinearSystem open = open_plant(plant);
  const Index floor = plant.Phi.rows(), n = open.A.rows() - 1, behind = n - floor;
  const bool filtered = applied_memory > 0;
  const Index total = n + (filtered ? 1 : 0);
  const auto without_floor = [&](const MatrixXd& row) {
    MatrixXd kept = MatrixXd::Zero(1, total);
    kept << row.leftCols(floor), row.rightCols(behind), MatrixXd::Zero(1, total - n);
    return kept;
  };
  LawPorts ports{.A = MatrixXd::Zero(total, total),
                 .B_w = MatrixXd::Zero(total, 1),
                 .B_u = MatrixXd::Zero(total, 1),
                 .C_y = without_floor(open.C.row(0)),
                 .D_yw = open.D.topLeftCorner(1, 1),
                 .D_yu = open.D.topRightCorner(1, 1),
                 .C_e = without_floor(open.C.row(1))};
  for (Index i = 0; i < n; ++i) {
    const Index from = i < floor ? i : i + 1;
    ports.A.row(i) = without_floor(open.A.row(from));
    ports.B_w(i, 0) = open.B(from, 0);
    ports.B_u(i, 0) = open.B(from, 1);
  }
  MatrixXd taken_out = without_floor(open.C.row(2));
  if (filtered) {
    taken_out *= 1 - applied_memory;
    taken_out(0, n) = applied_memory;
    ports.A.row(n) = taken_out;
  }
  ports.C_e -= taken_out;
  return ports;
}

Sampling nominal(Sampling sampling) {
  sampling.leg_gains.resize(0);
  sampling.leg_delays.resize(0);
  sampling.instruments.actuator_gain = 1;
  return sampling;
}

VectorXd grid_hz(const ModeGoal& goal, double sample_time) {
  constexpr Index n_below = 110, n_above = 70;
  const double to = 0.998 / (2 * sample_time), from = goal.omega_d / two_pi / 20;
  const double middle = std::min(1.2 * goal.to_hz, 0.5 * to);
  VectorXd hz(n_below + n_above);
  hz.head(n_below) = VectorXd::LinSpaced(n_below, std::log(from), std::log(middle)).array().exp();
  const double step = (to - middle) / n_above;
  hz.tail(n_above) = VectorXd::LinSpaced(n_above, middle + step, to);
  return hz;
}

}  // namespace

SampledMode::SampledMode(double omega, const Sampling& sampling, double applied_memory)
    : omega_(omega),
      applied_memory_(applied_memory),
      sampling_(nominal(sampling)),
      plant_(mode_plant(omega)),
      sampled_(sample_and_hold(plant_, sampling_)),
      ports_(law_ports(sampled_, applied_memory)) {}

DiscreteLaw SampledMode::law_of(const LinearSystem& F) const {
  return {.A = F.A,
          .B = F.B,
          .C = F.C,
          .D = F.D,
          .subtract_applied = true,
          .applied_memory = applied_memory_};
}

double SampledMode::radius(const LinearSystem& F, double gain, double later) const {
  Sampling sampling = sampling_;
  sampling.instruments.actuator_gain *= gain;
  sampling.delay_samples += later;
  return spectral_radius(close_loop(sample_and_hold(feedback_part(plant_), sampling), law_of(F)));
}

double SampledMode::disk_margin(const LinearSystem& F) const {
  return DiskSearch(plant_, sampling_, law_of(F)).of_all().alpha;
}

ModeResponses::ModeResponses(const SampledMode& mode, const ModeGoal& goal)
    : hz(grid_hz(goal, mode.sampling().sample_time)) {
  const LawPorts& ports = mode.ports();
  const SampledPlant& plant = mode.sampled();
  const Index N = hz.size(), n = ports.A.rows();
  for (VectorXcd* values : {&z, &y_w, &y_u, &e_w, &e_u, &sigma_f}) values->resize(N);
  MatrixXcd inputs(n, 2);
  inputs << ports.B_w, ports.B_u;
  for (Index k = 0; k < N; ++k) {
    z(k) = std::polar(1.0, two_pi * hz(k) * plant.sample_time);
    MatrixXcd resolvent = -ports.A.cast<Complex>();
    resolvent.diagonal().array() += z(k);
    const MatrixXcd x = resolvent.partialPivLu().solve(inputs);
    const MatrixXcd y = ports.C_y * x, e = ports.C_e * x;
    y_w(k) = y(0, 0) + ports.D_yw(0, 0);
    y_u(k) = y(0, 1) + ports.D_yu(0, 0);
    e_w(k) = e(0, 0);
    e_u(k) = e(0, 1);
    MatrixXcd of_plant = -plant.Phi.cast<Complex>();
    of_plant.diagonal().array() += z(k);
    const MatrixXcd to_state = plant.Gamma_u.cast<Complex>() + plant.Gamma_0.cast<Complex>() / z(k);
    const MatrixXcd sigma =
        plant.C_sigma * of_plant.partialPivLu().solve(to_state) + plant.D_sigma / z(k);
    sigma_f(k) = sigma(0, 0) * std::pow(z(k), -plant.whole_delay(0));
  }
}

VectorXcd ModeResponses::of(const LinearSystem& F) const {
  VectorXcd values(z.size());
  const VectorXcd B = F.B.cast<Complex>();
  for (Index k = 0; k < z.size(); ++k) {
    MatrixXcd resolvent = -F.A.cast<Complex>();
    resolvent.diagonal().array() += z(k);
    values(k) = (F.C * resolvent.partialPivLu().solve(B))(0) + F.D(0, 0);
  }
  return values;
}

VectorXcd ModeResponses::T(const VectorXcd& F) const {
  return y_w.array() + y_u.array() * F.array() * e_w.array() / (1.0 - F.array() * e_u.array());
}

VectorXcd ModeResponses::S(const VectorXcd& F) const {
  return 1.0 + F.array() * sigma_f.array() / (1.0 - F.array() * e_u.array());
}

namespace {

/// From here on the target is a roll-off.
double band_from_hz(const ModeGoal& goal) { return 1.5 * goal.omega_d / two_pi; }

}  // namespace

VectorXd target_size(const ModeGoal& goal, const VectorXd& hz) {
  return hz.unaryExpr([&](double f) {
    const Complex s(0, two_pi * f);
    const double w = goal.omega_d * goal.omega_d;
    return std::abs(w / (s * s + 2 * goal.zeta * goal.omega_d * s + w));
  });
}

VectorXd bound_of(const ModeGoal& goal, double level_db, const VectorXd& hz) {
  VectorXd bound = target_size(goal, hz) * std::pow(10, level_db / 20);
  const double peak = std::pow(10, goal.peak_db / 20), above = std::pow(10, goal.above_db / 20);
  for (Index k = 0; k < hz.size(); ++k) {
    if (hz(k) < band_from_hz(goal)) bound(k) = peak;
    bound(k) = hz(k) > goal.to_hz ? above : std::min(bound(k), peak);
  }
  return bound;
}

double level_of(const ModeGoal& goal, const VectorXd& hz, const VectorXcd& T) {
  const VectorXd target = target_size(goal, hz);
  double worst = 0;
  for (Index k = 0; k < hz.size(); ++k) {
    if (hz(k) < band_from_hz(goal) || hz(k) > goal.to_hz) continue;
    worst = std::max(worst, std::abs(T(k)) / target(k));
  }
  return decibels(worst);
}

}  // namespace stillframe

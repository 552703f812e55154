#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <vector>

#include "core/control/close_loop.hpp"
#include "report/identification/multisine.hpp"

namespace stillframe::report::toy {

/// A sample time, and commands that take effect whole samples late.
inline Sampling sampled_at(double sample_time, double delay_samples = 0) {
  Sampling sampling;
  sampling.sample_time = sample_time;
  sampling.delay_samples = delay_samples;
  return sampling;
}

inline constexpr double pi = std::numbers::pi;

/// A unit mass on three undamped legs whose modes are no leg directions: e'' = -K e - u - w, sigma
/// = K e + u, and y = e'' + w, the frame's acceleration along the legs.
struct Frame {
  std::vector<double> modes_hz = {13.9055, 20.0055, 31.3203};
  Eigen::Matrix3d V =
      (Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized())).toRotationMatrix();

  Eigen::Matrix3d stiffness() const {
    const Eigen::Map<const Eigen::Vector3d> f(modes_hz.data());
    return V * (2 * pi * f).cwiseAbs2().asDiagonal() * V.transpose();
  }

  LoopPlant plant() const {
    const Eigen::Matrix3d K = stiffness(), I = Eigen::Matrix3d::Identity();
    LoopPlant plant;
    plant.A.setZero(6, 6);
    plant.A.topRightCorner(3, 3) = I;
    plant.A.bottomLeftCorner(3, 3) = -K;
    plant.B_w.setZero(6, 3);
    plant.B_w.bottomRows(3) = -I;
    plant.B_u = plant.B_w;
    plant.C_y.setZero(3, 6);
    plant.C_y.leftCols(3) = -K;
    plant.C_sigma = -plant.C_y;
    plant.D_yw.setZero(3, 3);
    plant.D_yu = -I;
    return plant;
  }

  /// The exact law for omega_d and zeta with a leak, feedthrough solved for, by the trapezoidal
  /// rule: X u' + (omega_l + K_I) u = -(K_P e' + K_I e), X = K / omega_d^2.
  DiscreteLaw law(double omega_d, double zeta, double leak, double sample_time) const {
    const Eigen::Matrix3d I = Eigen::Matrix3d::Identity(), X = stiffness() / (omega_d * omega_d);
    const Eigen::Matrix3d K_P = X - I, K_I = 2 * zeta * omega_d * X, a = leak * I + K_I;
    const double c = 2 / sample_time;
    const Eigen::Matrix3d L = (c * X + a).inverse();
    const Eigen::Matrix3d F = L * (c * X - a), D = -L * (c * K_P + K_I), N = L * (c * K_P - K_I);
    return {.A = F, .B = F * D + N, .C = I, .D = D, .subtract_applied = true};
  }
};

/// Steps a loop from a given state. Row k + 1 holds w[k] and what the instruments read at the end
/// of it, as in a log; row 0 is at rest.
struct Record {
  Eigen::MatrixXd inputs, outputs;
};

inline Record simulate(const SampledLoop& loop, const Eigen::MatrixXd& w, Eigen::VectorXd state) {
  Record record{Eigen::MatrixXd::Zero(w.rows() + 1, w.cols()),
                Eigen::MatrixXd::Zero(w.rows() + 1, loop.C.rows())};
  for (Eigen::Index k = 0; k < w.rows(); ++k) {
    const Eigen::VectorXd input = w.row(k).transpose();
    record.inputs.row(k + 1) = input.transpose();
    record.outputs.row(k + 1) = (loop.C * state + loop.D * input).transpose();
    state = loop.A * state + loop.B * input;
  }
  return record;
}

/// The share of a glide done at 0 <= t <= 1: the integral of a Blackman-Harris window.
inline double glide(double t) {
  const double a[] = {0.35875, 0.48829, 0.14128, 0.01168};
  return t - a[1] / a[0] * std::sin(2 * pi * t) / (2 * pi) +
         a[2] / a[0] * std::sin(4 * pi * t) / (4 * pi) -
         a[3] / a[0] * std::sin(6 * pi * t) / (6 * pi);
}

/// The excitation that a plan describes, a line amplitude of `amplitude` each, phases from a fixed
/// seed.
inline Eigen::MatrixXd multisine(const MultisinePlan& plan, double amplitude) {
  std::mt19937_64 random(7);
  std::vector<double> phases;
  for (std::size_t l = 0; l < plan.frequencies_hz.size(); ++l) {
    phases.push_back(2 * pi * std::ldexp(static_cast<double>(random() >> 11), -53));
  }
  const auto n_ramp = static_cast<Eigen::Index>(std::lround(plan.ramp_s * plan.sample_rate_hz));
  const auto n_block =
      n_ramp + static_cast<Eigen::Index>(std::lround(plan.window_s * plan.sample_rate_hz));
  Eigen::MatrixXd w = Eigen::MatrixXd::Zero(plan.n_blocks * n_block, plan.n_blocks);
  for (Eigen::Index k = 0; k < w.rows(); ++k) {
    const Eigen::Index b = k / n_block, in_block = k % n_block;
    const double done =
        in_block < n_ramp ? glide(static_cast<double>(in_block) / static_cast<double>(n_ramp)) : 1;
    for (Eigen::Index i = 0; i < plan.n_blocks; ++i) {
      const auto turn = [&](Eigen::Index block) {
        return std::polar(
            1.0, 2 * pi * static_cast<double>(i * block) / static_cast<double>(plan.n_blocks));
      };
      const std::complex<double> phasor =
          done * turn(b) + (b > 0 ? (1 - done) * turn(b - 1) : std::complex<double>(0));
      for (std::size_t l = 0; l < phases.size(); ++l) {
        const double angle = phases[l] + 2 * pi * plan.frequencies_hz[l] * static_cast<double>(k) /
                                             plan.sample_rate_hz;
        w(k, i) += amplitude * (phasor * std::polar(1.0, angle)).real();
      }
    }
  }
  return w;
}

/// Three blocks of 2 + 4 s at 500 Hz; every line is 4 bins (1 Hz) or more from each mode of Frame.
inline MultisinePlan plan() {
  return {.sample_rate_hz = 500,
          .frequencies_hz = {1, 2, 4, 7, 10, 12, 16, 18, 22, 26, 29, 34, 40, 50, 63, 80, 100},
          .n_blocks = 3,
          .ramp_s = 2,
          .window_s = 4};
}

}  // namespace stillframe::report::toy

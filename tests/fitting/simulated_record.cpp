#include "tests/fitting/simulated_record.hpp"

#include <cmath>
#include <numbers>
#include <random>

namespace stillframe::fitting {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Simulated simulate(const SampledPlant& plant, const Drive& drive) {
  const Index m = plant.Gamma_u.cols(), p = plant.Gamma_w.cols(), q = plant.C_y.rows();
  const Index n = drive.n_window, part = n * (drive.n_windows + 2);
  const Index before = 50, total = before + n * drive.n_rest + part * m + 50;
  std::mt19937_64 random(drive.seed);
  std::normal_distribution<double> normal;
  VectorXd wave = VectorXd::Zero(n);
  for (const int line : drive.lines) {
    const double phase = 2 * std::numbers::pi * std::generate_canonical<double, 53>(random);
    for (Index k = 0; k < n; ++k) {
      wave(k) += std::cos(2 * std::numbers::pi * static_cast<double>((line * k) % n) /
                              static_cast<double>(n) +
                          phase);
    }
  }
  wave *= drive.force / wave.cwiseAbs().maxCoeff();
  Simulated out;
  RigRecord& record = out.record;
  record.sample_time = plant.sample_time;
  record.n_window = n;
  record.lines = drive.lines;
  record.command = MatrixXd::Zero(total, m);
  for (int w = 0; w < drive.n_rest; ++w) {
    record.windows.push_back(before + w * n);
    out.driven.push_back(false);
  }
  for (Index leg = 0; leg < m; ++leg) {
    const Index start = before + n * drive.n_rest + part * leg;
    // As abruptly as can be: nothing is asked of how the drive begins and ends.
    for (Index k = 0; k < part - n; ++k) record.command(start + k, leg) = wave(k % n);
    for (int w = 0; w < drive.n_windows; ++w) {
      record.windows.push_back(start + n + w * n);
      out.driven.push_back(true);
    }
  }
  record.sigma = record.applied = MatrixXd::Zero(total, m);
  record.frame = MatrixXd::Zero(total, q);
  MatrixXd floor = MatrixXd::Zero(total, p);
  VectorXd x = VectorXd::Zero(plant.Phi.rows()), w = VectorXd::Zero(p), y = VectorXd::Zero(q);
  std::vector<VectorXd> reports(static_cast<std::size_t>(plant.report_age) + 1, VectorXd::Zero(m));
  const auto commanded = [&](Index k, Index leg) { return k >= 0 ? record.command(k, leg) : 0.0; };
  for (Index k = 0; k < total; ++k) {
    VectorXd c_0(m), c_1(m);
    for (Index leg = 0; leg < m; ++leg) {
      c_1(leg) = commanded(k - plant.whole_delay(leg), leg);
      c_0(leg) = commanded(k - plant.whole_delay(leg) - 1, leg);
    }
    for (Index i = 0; i < m; ++i) record.sigma(k, i) = drive.sigma_noise * normal(random);
    record.sigma.row(k) += (plant.C_sigma * x + plant.D_sigma * c_0).transpose();
    for (std::size_t i = reports.size() - 1; i > 0; --i) reports[i] = reports[i - 1];
    reports[0] = plant.C_report * x + plant.D_report * c_0;
    record.applied.row(k) = reports.back().transpose();
    for (Index i = 0; i < m; ++i) record.applied(k, i) += drive.applied_noise * normal(random);
    record.frame.row(k) = y.transpose();
    for (Index i = 0; i < q; ++i) record.frame(k, i) += drive.frame_noise * normal(random);
    floor.row(k) = w.transpose();
    for (Index i = 0; i < p; ++i) w(i) = drive.floor_noise * normal(random);
    y = plant.C_y * x + plant.D_yw * w + plant.D_0 * c_0 + plant.D_yu * c_1;
    x = (plant.Phi * x + plant.Gamma_w * w + plant.Gamma_0 * c_0 + plant.Gamma_u * c_1).eval();
  }
  record.floor = drive.floor_is_measured ? floor : MatrixXd(total, 0);
  return out;
}

}  // namespace stillframe::fitting

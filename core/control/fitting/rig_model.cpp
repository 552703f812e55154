#include "core/control/fitting/rig_model.hpp"

#include <Eigen/LU>
#include <cmath>
#include <complex>

#include "core/numerics/two_pi.hpp"

namespace stillframe::fitting {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;

namespace {

/// columns x lines.
MatrixXcd sums(const MatrixXd& signals, Index from, const LineKernel& kernel) {
  return signals.middleRows(from, kernel.powers.rows()).transpose() * kernel.powers;
}

/// What is driven and read of a sampled plant: x' = Phi x + drive u, read = C x + D u, u the two
/// commands of a sample and the floor.
struct Rows {
  Rows(const SampledPlant& plant, const std::vector<Index>& frame, Index p) {
    const Index n = plant.Phi.rows(), m = plant.Gamma_u.cols(),
                q = static_cast<Index>(frame.size());
    C.resize(2 * m + q, n);
    D = MatrixXd::Zero(2 * m + q, 2 * m + p);
    drive.resize(n, 2 * m + p);
    C.topRows(m) = plant.C_sigma;
    D.topLeftCorner(m, m) = plant.D_sigma;
    C.middleRows(m, m) = plant.C_report;
    D.block(m, 0, m, m) = plant.D_report;
    for (Index i = 0; i < q; ++i) {
      const Index row = frame[static_cast<std::size_t>(i)];
      C.row(2 * m + i) = plant.C_y.row(row);
      D.block(2 * m + i, 0, 1, m) = plant.D_0.row(row);
      D.block(2 * m + i, m, 1, m) = plant.D_yu.row(row);
      if (p > 0) D.block(2 * m + i, 2 * m, 1, p) = plant.D_yw.row(row);
    }
    drive.leftCols(m) = plant.Gamma_0;
    drive.middleCols(m, m) = plant.Gamma_u;
    if (p > 0) drive.rightCols(p) = plant.Gamma_w;
  }

  MatrixXd C, D, drive;
};

}  // namespace

LineKernel::LineKernel(Index n_window, const std::vector<int>& lines, double decay)
    : z(static_cast<Index>(lines.size())), z_n(z.size()), powers(n_window, z.size()) {
  const auto n = static_cast<double>(n_window);
  for (Index l = 0; l < z.size(); ++l) {
    const Index line = lines[static_cast<std::size_t>(l)];
    const double w = two_pi * static_cast<double>(line) / n;
    z(l) = std::polar(std::exp(decay * w), w);
    z_n(l) = std::exp(-decay * w * n);
    for (Index k = 0; k < n_window; ++k) {
      const double turns = static_cast<double>((line * k) % n_window) / n;
      powers(k, l) =
          std::polar(2 / n * std::exp(-decay * w * static_cast<double>(k)), -two_pi * turns);
    }
  }
}

WindowData::WindowData(const RigRecord& record, Index window, int report_age,
                       const LineKernel& kernel)
    : record_(record),
      kernel_(kernel),
      from_(record.windows[static_cast<std::size_t>(window)]),
      report_age_(report_age) {
  const Index m = record.command.cols(), q = record.frame.cols();
  read_.resize(2 * m + q, kernel.z.size());
  read_.topRows(m) = sums(record.sigma, from_, kernel);
  read_.middleRows(m, m) = sums(record.applied, from_ + report_age, kernel);
  // A mean over a sample stands at its end, and is what began with the state there.
  read_.bottomRows(q) = sums(record.frame, from_ + 1, kernel);
  floor_ = sums(record.floor, from_ + 1, kernel);
  command_ = sums(record.command, from_, kernel);
}

std::vector<MatrixXcd> WindowData::gaps() const {
  std::vector<MatrixXcd> all;
  if (record_.missing.empty()) return all;
  const Index m = record_.command.cols();
  for (Index output = 0; output < read_.rows(); ++output) {
    const Index shift = output < m ? 0 : output < 2 * m ? report_age_ : 1;
    for (Index k = 0; k < record_.n_window; ++k) {
      if (!record_.missing[static_cast<std::size_t>(from_ + shift + k)]) continue;
      all.push_back(MatrixXcd::Zero(read_.rows(), read_.cols()));
      all.back().row(output) = kernel_.powers.row(k);
    }
  }
  return all;
}

VectorXcd WindowData::commands(Index leg, Index late) const {
  const Index n = record_.n_window;
  const double scale = 2.0 / static_cast<double>(n);
  VectorXcd sum = command_.row(leg).transpose();
  for (Index d = 1; d <= late; ++d) {
    // One sample later: another comes in before, the last goes out.
    const double in = scale * record_.command(from_ - d, leg),
                 out = scale * record_.command(from_ - d + n, leg);
    sum = (sum.array() / kernel_.z.array() + in - out * kernel_.z_n.array()).eval();
  }
  return sum;
}

MatrixXcd WindowData::driven(const Eigen::VectorXi& whole_delay) const {
  const Index m = whole_delay.size();
  MatrixXcd all(2 * m + floor_.rows(), command_.cols());
  for (Index leg = 0; leg < m; ++leg) {
    all.row(leg) = commands(leg, whole_delay(leg) + 1).transpose();
    all.row(m + leg) = commands(leg, whole_delay(leg)).transpose();
  }
  all.bottomRows(floor_.rows()) = floor_;
  return all;
}

RigModel::RigModel(const SampledPlant& plant, const RigRecord& record,
                   const std::vector<Index>& frame, const LineKernel& kernel)
    : n_floor_(record.floor.cols()), whole_delay_(plant.whole_delay), frame_(frame), z_(kernel.z) {
  const bool on_circle = kernel.z_n.cwiseAbs().minCoeff() == 1;
  const Rows rows(plant, frame, n_floor_);
  const Index n = plant.Phi.rows(), n_in = rows.drive.cols();
  n_ends_ = on_circle ? n : 2 * n;
  MatrixXcd drive(n, n_in + n_ends_);
  drive.leftCols(n_in) = rows.drive.cast<Complex>();
  const MatrixXcd Phi = plant.Phi.cast<Complex>(), I = MatrixXcd::Identity(n, n);
  for (Index l = 0; l < kernel.z.size(); ++l) {
    const Complex z = kernel.z(l);
    drive.middleCols(n_in, n) = z * I;
    if (!on_circle) drive.rightCols(n) = -z * kernel.z_n(l) * I;
    MatrixXcd state = (z * I - Phi).partialPivLu().solve(drive);
    MatrixXcd all = rows.C * state;
    all.leftCols(n_in) += rows.D;
    response_.push_back(std::move(all));
    state_.push_back(std::move(state));
  }
}

RigModel RigModel::slope(const SampledPlant& above, const SampledPlant& below, double step) const {
  const Rows up(above, frame_, n_floor_), down(below, frame_, n_floor_);
  const MatrixXd dC = (up.C - down.C) / step, dD = (up.D - down.D) / step,
                 dPhi = (above.Phi - below.Phi) / step, d_drive = (up.drive - down.drive) / step;
  const Index n = dPhi.rows(), n_in = d_drive.cols();
  RigModel slope;
  slope.n_ends_ = n_ends_;
  slope.whole_delay_ = whole_delay_;
  for (std::size_t l = 0; l < response_.size(); ++l) {
    // C (z I - Phi)^-1 is what the state at a window's beginning adds, over z.
    const MatrixXcd of_state = response_[l].middleCols(n_in, n) / z_(static_cast<Index>(l));
    MatrixXcd moved = dPhi * state_[l];
    moved.leftCols(n_in) += d_drive;
    MatrixXcd all = dC * state_[l] + of_state * moved;
    all.leftCols(n_in) += dD;
    slope.response_.push_back(std::move(all));
  }
  return slope;
}

MatrixXcd RigModel::predicted(const WindowData& window) const {
  const MatrixXcd driven = window.driven(whole_delay_);
  MatrixXcd all(response_.front().rows(), driven.cols());
  for (Index l = 0; l < driven.cols(); ++l) {
    all.col(l) = response_[static_cast<std::size_t>(l)].leftCols(driven.rows()) * driven.col(l);
  }
  return all;
}

MatrixXcd RigModel::of_ends(std::size_t line) const { return response_[line].rightCols(n_ends_); }

}  // namespace stillframe::fitting

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

}  // namespace

LineKernel::LineKernel(const RigRecord& record, double decay)
    : z(static_cast<Index>(record.lines.size())), z_n(z.size()), powers(record.n_window, z.size()) {
  const auto n = static_cast<double>(record.n_window);
  for (Index l = 0; l < z.size(); ++l) {
    const Index line = record.lines[static_cast<std::size_t>(l)];
    const double w = two_pi * static_cast<double>(line) / n;
    z(l) = std::polar(std::exp(decay * w), w);
    z_n(l) = std::exp(-decay * w * n);
    for (Index k = 0; k < record.n_window; ++k) {
      const double turns = static_cast<double>((line * k) % record.n_window) / n;
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
    : whole_delay_(plant.whole_delay) {
  const bool on_circle = kernel.z_n.cwiseAbs().minCoeff() == 1;
  const Index n = plant.Phi.rows(), m = record.command.cols(), p = record.floor.cols();
  const auto q = static_cast<Index>(frame.size());
  const Index n_in = 2 * m + p;
  n_ends_ = on_circle ? n : 2 * n;
  MatrixXd C(2 * m + q, n), D = MatrixXd::Zero(2 * m + q, n_in);
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
  MatrixXcd drive(n, n_in + n_ends_);
  drive.leftCols(m) = plant.Gamma_0.cast<Complex>();
  drive.middleCols(m, m) = plant.Gamma_u.cast<Complex>();
  if (p > 0) drive.middleCols(2 * m, p) = plant.Gamma_w.cast<Complex>();
  const MatrixXcd Phi = plant.Phi.cast<Complex>(), I = MatrixXcd::Identity(n, n);
  for (Index l = 0; l < kernel.z.size(); ++l) {
    const Complex z = kernel.z(l);
    drive.middleCols(n_in, n) = z * I;
    if (!on_circle) drive.rightCols(n) = -z * kernel.z_n(l) * I;
    MatrixXcd all = C * (z * I - Phi).partialPivLu().solve(drive);
    all.leftCols(n_in) += D;
    response_.push_back(std::move(all));
  }
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

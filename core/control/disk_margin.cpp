#include "core/control/disk_margin.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/numerics/eigenvalues.hpp"
#include "core/numerics/golden_section.hpp"
#include "core/numerics/infinity.hpp"
#include "core/numerics/singular_values.hpp"
#include "core/numerics/two_pi.hpp"

namespace stillframe {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
using std::numbers::pi;

/// To which a peak is proven to be the highest one.
constexpr double proof = 1e-6;

/// Golden sections of a peak, to part of its angle, which is nearer than its second order shows.
constexpr int sections = 40;
constexpr double part = 1e-10;

/// Angles at which S - I/2 may have a peak, ascending, with 0 and pi.
std::vector<double> angles_to_search(const Eigen::VectorXcd& poles) {
  constexpr int n = 240;
  // Where the distance of a pole to the circle is more than this part of its angle, the grid has
  // seen it.
  constexpr double seen = 0.3;
  std::vector<double> angles{0.0, pi};
  double lowest = 1e-6 * pi;
  for (Index i = 0; i < poles.size(); ++i) {
    const double angle = std::abs(std::arg(poles(i))), width = std::abs(1 - std::abs(poles(i)));
    // Legs that are alike have poles that are.
    const bool again = i > 0 && (poles.head(i).array() - poles(i)).abs().minCoeff() < 0.1 * width;
    if (again || poles(i).imag() < 0 || !(width < seen)) continue;
    lowest = std::min(lowest, 0.1 * std::hypot(width, angle));
    if (angle < 1 && width > seen * angle) continue;
    angles.push_back(angle);
    for (double t = width / 2; t < seen; t *= 2) {
      angles.push_back(std::abs(angle - t));
      angles.push_back(pi - std::abs(pi - (angle + t)));
    }
  }
  lowest = std::max(lowest, 1e-15);
  for (int i = 0; i < n; ++i) {
    angles.push_back(lowest * std::pow(pi / lowest, static_cast<double>(i) / n));
  }
  std::sort(angles.begin(), angles.end());
  // Poles of one frequency, or nearly, ask for the same points.
  const auto same = [](double a, double b) { return b - a < 1e-9 * b; };
  angles.erase(std::unique(angles.begin(), angles.end(), same), angles.end());
  return angles;
}

/// Angles of all z for which level^2 = h(z) h(1/z), h = c (z I - A)^-1 b + d: on the circle those
/// where |h| is `level`. With R = level^2 - d^2, F = A + b d c / R, the pencil is
///   [F, b b^T / R; 0, I] - z [I, 0; c^T c level^2 / R, F^T],
/// taken to s = (z - 1) / (z + 1). Empty if it cannot be computed.
std::vector<double> level_angles(const LinearSystem& system, Index leg, double level) {
  const Index n = system.A.rows();
  const double d = system.D(leg, leg), R = level * level - d * d;
  VectorXd b = system.B.col(leg), c = system.C.row(leg).transpose();
  const double ratio = std::sqrt(c.norm() / b.norm());
  if (!(R > 0) || !std::isfinite(ratio) || ratio == 0) return {};
  b *= ratio;
  c /= ratio;
  const MatrixXd I = MatrixXd::Identity(n, n);
  const MatrixXd F = system.A + b * (d / R) * c.transpose();
  const MatrixXd G = b * b.transpose() / R, Q = c * c.transpose() * (level * level / R);
  MatrixXd sum(2 * n, 2 * n), difference(2 * n, 2 * n);
  sum << F + I, G, Q, I + F.transpose();
  difference << F - I, G, -Q, I - F.transpose();
  const MatrixXd pencil = sum.partialPivLu().solve(difference);
  const auto values = eigenvalues(pencil);
  if (!values) return {};
  std::vector<double> angles{0.0, pi};
  for (const Complex s : *values) {
    const double angle = std::abs(std::arg((1.0 + s) / (1.0 - s)));
    if (std::isfinite(angle)) angles.push_back(angle);
  }
  std::sort(angles.begin(), angles.end());
  return angles;
}

/// log D of Osborne's balancing of the moduli: close to the best D, in the Frobenius norm.
VectorXd balanced_moduli(const MatrixXcd& Z) {
  const Index m = Z.rows();
  MatrixXd squares = Z.cwiseAbs2();
  VectorXd log_d = VectorXd::Zero(m);
  for (int sweep = 0; sweep < 20; ++sweep) {
    double change = 0;
    for (Index i = 0; i < m; ++i) {
      const double row = squares.row(i).sum() - squares(i, i);
      const double column = squares.col(i).sum() - squares(i, i);
      if (!(row > 0) || !(column > 0)) continue;
      const double factor = std::sqrt(column / row);  // of d_i^2
      squares.row(i) *= factor;
      squares.col(i) /= factor;
      log_d(i) += std::log(factor) / 2;
      change = std::max(change, std::abs(factor - 1));
    }
    if (change < 1e-3) break;
  }
  return log_d;
}

/// The largest singular value after Osborne's balancing: an upper bound of diagonal_mu.
double simple_bound(const MatrixXcd& Z) {
  if (!Z.allFinite()) return nan;
  const VectorXd d = balanced_moduli(Z).array().exp();
  return singular_values(d.asDiagonal() * Z * d.cwiseInverse().asDiagonal())(0);
}

}  // namespace

LinearSystem half_sensitivity(const LoopPlant& loop_plant, const Sampling& sampling,
                              const DiscreteLaw& law) {
  const SampledPlant plant = sample_and_hold(feedback_part(loop_plant), sampling);
  const Index n = plant.Phi.rows(), m = plant.Gamma_u.cols();
  const MatrixXd I = MatrixXd::Identity(m, m);
  // Beside the plant: the d that held before, and where the report is a measured one, what d has
  // done to the actuators, which head the states: it is no part of what is reported.
  const bool measured = !plant.C_report.isZero(0);
  const Index held = n, actuators = n + m, total = n + m + (measured ? m : 0);
  SampledPlant with_d = plant;
  with_d.n_exogenous = total - n;
  const auto widened = [&](const MatrixXd& M, Index rows, Index columns) {
    MatrixXd out = MatrixXd::Zero(rows, columns);
    out.topLeftCorner(M.rows(), M.cols()) = M;
    return out;
  };
  with_d.Phi = widened(plant.Phi, total, total);
  with_d.Phi.block(0, held, n, m) = plant.Gamma_0;
  with_d.Gamma_0 = widened(plant.Gamma_0, total, m);
  with_d.Gamma_u = widened(plant.Gamma_u, total, m);
  with_d.Gamma_w = with_d.Gamma_u;
  with_d.Gamma_w.middleRows(held, m) = I;
  with_d.C_sigma = widened(plant.C_sigma, m, total);
  with_d.C_sigma.middleCols(held, m) = plant.D_sigma;
  with_d.C_report = widened(plant.C_report, m, total);
  if (measured) {
    with_d.Phi.block(actuators, held, m, m) = plant.Gamma_0.topRows(m);
    with_d.Phi.block(actuators, actuators, m, m) = plant.Phi.topLeftCorner(m, m);
    with_d.Gamma_w.middleRows(actuators, m) = plant.Gamma_u.topRows(m);
    with_d.C_report.middleCols(actuators, m) = -plant.C_report.leftCols(m);
  }
  with_d.C_y = MatrixXd::Zero(m, total);
  with_d.D_0 = MatrixXd::Zero(m, m);
  with_d.D_yu = I;
  with_d.D_yw = I / 2;
  DiscreteLaw feedback = law;
  feedback.feed_forward = {};
  const SampledLoop loop = close_loop(with_d, feedback);
  return {.A = loop.A, .B = loop.B, .C = loop.C, .D = loop.D};
}

LinearSystem half_sensitivity(const LoopSettings& settings) {
  return half_sensitivity(settings.plant, settings.sampling, law_of(settings));
}

DiskSearch::DiskSearch(const LoopSettings& settings)
    : DiskSearch(settings.plant, settings.sampling, law_of(settings)) {}

DiskSearch::DiskSearch(const LoopPlant& plant, const Sampling& sampling, const DiscreteLaw& law)
    : system_(half_sensitivity(plant, sampling, law)),
      sweep_(proper_system(system_)),
      m_(system_.D.rows()),
      sample_time_(sampling.sample_time),
      angles_(angles_to_search(sweep_.poles())),
      here_(m_, m_) {
  for (const double angle : angles_) values_.push_back(at(angle));
}

const MatrixXcd& DiskSearch::at(double angle) {
  sweep_.evaluate(std::polar(1.0, angle), here_);
  return here_;
}

double DiskSearch::of(Index leg, double angle) { return std::abs(at(angle)(leg, leg)); }

DiskMargin DiskSearch::margin(const Peak& peak) const {
  return {1 / peak.value, peak.angle / (two_pi * sample_time_)};
}

DiskSearch::Peak DiskSearch::highest(Index leg) {
  Peak best{-1, 0};
  const size_t n = angles_.size();
  for (size_t i = 0; i < n; ++i) {
    const double value = std::abs(values_[i](leg, leg));
    if (!std::isfinite(value)) return {nan, angles_[i]};
    if (value > best.value) best = {value, angles_[i]};
  }
  const double first = best.value;
  for (size_t i = 1; i + 1 < n; ++i) {
    const auto value = [&](size_t j) { return std::abs(values_[j](leg, leg)); };
    if (value(i) < 0.8 * first || value(i) < value(i - 1) || value(i) < value(i + 1)) continue;
    const auto [angle, found] = golden_section([&](double x) { return of(leg, x); }, angles_[i - 1],
                                               angles_[i + 1], sections, part);
    if (!std::isfinite(found)) return {nan, angle};
    if (found > best.value) best = {found, angle};
  }
  return best;
}

DiskMargin DiskSearch::of_leg(Index leg) {
  Peak best = highest(leg);
  for (int round = 0; round < 30; ++round) {
    const double level = best.value * (1 + proof);
    const std::vector<double> angles = level_angles(system_, leg, level);
    if (angles.empty()) return {nan, nan};
    Peak found = best;
    for (size_t i = 0; i + 1 < angles.size(); ++i) {
      const double middle = (angles[i] + angles[i + 1]) / 2, value = of(leg, middle);
      if (!(value <= found.value)) found = {value, middle};
    }
    if (!std::isfinite(found.value)) return {nan, nan};
    if (found.value <= level) return margin(best);
    best = found;
  }
  return {nan, nan};
}

DiskMargin DiskSearch::of_all(double at_least) {
  if (m_ == 1) return of_leg(0);
  const double enough = at_least > 0 ? 1 / at_least : infinity;
  // Each of the moduli on the diagonal is a lower bound.
  for (size_t i = 0; i < angles_.size(); ++i) {
    const double value = values_[i].diagonal().cwiseAbs().maxCoeff();
    if (value > enough) return margin({value, angles_[i]});
  }
  std::vector<double> bounds;
  for (const MatrixXcd& Z : values_) bounds.push_back(simple_bound(Z));
  std::vector<size_t> order(angles_.size());
  for (size_t i = 0; i < order.size(); ++i) {
    if (!std::isfinite(bounds[i])) return {nan, nan};
    order[i] = i;
  }
  std::sort(order.begin(), order.end(), [&](size_t i, size_t j) { return bounds[i] > bounds[j]; });
  Peak best{0, 0};
  const auto consider = [&](double value, double angle) {
    if (value > best.value) best = {value, angle};
  };
  for (const size_t i : order) {
    if (bounds[i] <= best.value) break;
    const double mu = diagonal_mu(values_[i]);
    if (!std::isfinite(mu)) return {nan, nan};
    consider(mu, angles_[i]);
    if (best.value > enough) return margin(best);
  }
  for (const size_t i : order) {
    if (bounds[i] < 0.8 * best.value) break;
    const size_t before = i > 0 ? i - 1 : i, after = std::min(i + 1, order.size() - 1);
    if (bounds[i] < bounds[before] || bounds[i] < bounds[after]) continue;
    const auto [angle, value] = golden_section([&](double x) { return diagonal_mu(at(x)); },
                                               angles_[before], angles_[after], sections, part);
    if (!std::isfinite(value)) return {nan, nan};
    consider(value, angle);
    if (best.value > enough) break;
  }
  return margin(best);
}

double diagonal_mu(const MatrixXcd& Z) {
  if (!Z.allFinite()) return nan;
  VectorXd log_d = balanced_moduli(Z);
  // The 2-norm is convex in log D; its gradient is the difference of the moduli squared of the
  // singular vectors. Steps are halved as long as they do not help.
  const auto decompose = [&](const VectorXd& x) {
    const VectorXd d = x.array().exp();
    return Eigen::JacobiSVD<MatrixXcd>(d.asDiagonal() * Z * d.cwiseInverse().asDiagonal(),
                                       Eigen::ComputeFullU | Eigen::ComputeFullV);
  };
  Eigen::JacobiSVD<MatrixXcd> svd = decompose(log_d);
  double step = 0.5;
  for (int i = 0; i < 20 && step > 1e-3; ++i) {
    const VectorXd gradient = svd.matrixU().col(0).cwiseAbs2() - svd.matrixV().col(0).cwiseAbs2();
    if (gradient.norm() < 1e-2) break;
    const auto next = decompose(log_d - step * gradient);
    if (next.singularValues()(0) < svd.singularValues()(0)) {
      log_d -= step * gradient;
      svd = next;
    } else {
      step /= 2;
    }
  }
  // Where several singular values are the largest the way down ends early; Z itself may be lower.
  return std::min(svd.singularValues()(0), singular_values(Z)(0));
}

}  // namespace stillframe

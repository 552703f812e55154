#include "core/linear/margins.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <tuple>

#include "core/linear/sampled_loop.hpp"
#include "core/yaml/input_error.hpp"

namespace stillframe {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// The value at which `stable` first fails on the way from `from` (stable) by steps of `step` to
/// `to`, halved down to 1e-6 of the step; infinity if it does not fail.
double first_failure(const std::function<bool(double)>& stable, double from, double to,
                     double step) {
  const int n = static_cast<int>(std::ceil(std::abs((to - from) / step)));
  double good = from;
  for (int i = 1; i <= n; ++i) {
    double bad = from + (to - from) * i / n;
    if (stable(bad)) {
      good = bad;
      continue;
    }
    for (int j = 0; j < 20; ++j) {
      const double middle = (good + bad) / 2;
      (stable(middle) ? good : bad) = middle;
    }
    return good;
  }
  return infinity;
}

/// Tries perturbed loops with one law; the law does not know of the perturbation.
class Perturbed {
 public:
  explicit Perturbed(const LoopSettings& settings)
      : plant_(feedback_part(settings.plant)),
        sampling_(settings.sampling),
        law_(law_of(settings)),
        m_(plant_.B_u.cols()) {}

  bool stable_with_gains(const VectorXd& factors) const {
    Sampling sampling = sampling_;
    sampling.leg_gains = sampling_.leg_gains.size() > 0
                             ? VectorXd(sampling_.leg_gains.cwiseProduct(factors))
                             : factors;
    return stable(sampling);
  }
  bool stable_with_delays(const VectorXd& samples) const {
    Sampling sampling = sampling_;
    sampling.leg_delays =
        sampling_.leg_delays.size() > 0 ? VectorXd(sampling_.leg_delays + samples) : samples;
    return stable(sampling);
  }
  /// Factors 10^x on the legs of `mask` (ones and zeros).
  GainRange gain_range(const VectorXd& mask) const {
    const auto stable = [&](double x) {
      return stable_with_gains((std::log(10.0) * x * mask).array().exp());
    };
    const double down = first_failure(stable, 0, -3, 0.05), up = first_failure(stable, 0, 3, 0.05);
    return {down == infinity ? 0.0 : std::pow(10, down),
            up == infinity ? infinity : std::pow(10, up)};
  }
  /// Seconds by which the legs of `mask` may be late: up to 4 samples in quarters, on to
  /// longest_delay in steps of one.
  double delay_limit(const VectorXd& mask) const {
    const auto stable = [&](double samples) { return stable_with_delays(samples * mask); };
    double limit = first_failure(stable, 0, 4, 0.25);
    if (limit == infinity) limit = first_failure(stable, 4, longest_delay, 1);
    return limit * sampling_.sample_time;
  }
  Index n_legs() const { return m_; }

 private:
  bool stable(const Sampling& sampling) const {
    const double radius = spectral_radius(close_loop(sample_and_hold(plant_, sampling), law_));
    return radius < largest_stable_radius;
  }

  LoopPlant plant_;
  Sampling sampling_;
  DiscreteLaw law_;
  Index m_;
};

/// Largest value of f over frequencies (rad/s) up to `to`: a logarithmic grid, refined by golden
/// sections about its highest points.
std::pair<double, double> peak(const std::function<double(double)>& f, double from, double to) {
  constexpr int n = 240;
  const double step = std::log(to / from) / (n - 1);
  VectorXd values(n);
  const auto at = [&](double i) { return from * std::exp(step * i); };
  for (int i = 0; i < n; ++i) values(i) = f(at(i));
  std::pair<double, double> best{0, from};
  const double highest = values.maxCoeff();
  for (int i = 0; i < n; ++i) {
    const bool local =
        (i == 0 || values(i) >= values(i - 1)) && (i == n - 1 || values(i) >= values(i + 1));
    if (!local || values(i) < 0.7 * highest) continue;
    double low = std::max(i - 1, 0), high = std::min(i + 1, n - 1);
    constexpr double golden = 0.6180339887498949;
    for (int j = 0; j < 25; ++j) {
      const double a = high - golden * (high - low), b = low + golden * (high - low);
      (f(at(a)) > f(at(b)) ? high : low) = f(at(a)) > f(at(b)) ? b : a;
    }
    const double found = f(at((low + high) / 2));
    if (std::max(found, values(i)) > best.first) {
      best =
          found > values(i) ? std::pair(found, at((low + high) / 2)) : std::pair(values(i), at(i));
    }
  }
  return best;
}

/// S - I/2 of a loop over frequency.
class HalfSensitivity {
 public:
  explicit HalfSensitivity(const LoopSettings& settings)
      : plant_(sample_and_hold(feedback_part(settings.plant), settings.sampling)),
        law_(law_of(settings)) {}

  MatrixXcd operator()(double omega) const {
    const Index m = n_legs();
    const MatrixXcd I = MatrixXcd::Identity(m, m);
    return (I + return_ratio(plant_, law_, omega)).partialPivLu().inverse() - 0.5 * I;
  }
  /// Largest value of f(S - I/2) up to half the sample rate, and where (rad/s).
  std::pair<double, double> peak_of(const std::function<double(const MatrixXcd&)>& f) const {
    const double nyquist = std::numbers::pi / plant_.sample_time;
    return peak([&](double omega) { return f((*this)(omega)); }, 1e-6 * nyquist, nyquist);
  }
  Index n_legs() const { return plant_.Gamma_u.cols(); }

 private:
  SampledPlant plant_;
  DiscreteLaw law_;
};

}  // namespace

double diagonal_mu(const MatrixXcd& Z) {
  const Index m = Z.rows();
  // Osborne's balancing of the moduli brings D close, in the Frobenius norm.
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
  return svd.singularValues()(0);
}

std::pair<double, double> all_leg_disk_margin(const LoopSettings& settings) {
  const auto [mu, omega] = HalfSensitivity(settings).peak_of(diagonal_mu);
  return {1 / mu, omega / (2 * std::numbers::pi)};
}

bool has_disk_margin(const LoopSettings& settings, double alpha) {
  const HalfSensitivity half(settings);
  const double nyquist = std::numbers::pi / settings.sampling.sample_time;
  constexpr int n = 40;
  for (int i = 0; i < n; ++i) {
    // The spectral radius is a lower bound of the structured singular value.
    const MatrixXcd Z = half(nyquist * std::pow(10.0, -4.0 * i / n));
    if (Z.eigenvalues().cwiseAbs().maxCoeff() > 1 / alpha) return false;
  }
  return 1 / half.peak_of(diagonal_mu).first >= alpha;
}

Margins margins(const LoopSettings& settings) {
  const double radius = spectral_radius(settings);
  if (!(radius < largest_stable_radius)) {
    throw Refusal("a loop of spectral radius " + std::to_string(radius) + " has no margins");
  }
  const Perturbed loop(settings);
  const Index m = loop.n_legs();
  Margins out;
  out.leg_delay.resize(m);
  for (Index i = 0; i < m; ++i) {
    out.leg_gain.push_back(loop.gain_range(VectorXd::Unit(m, i)));
    out.leg_delay(i) = loop.delay_limit(VectorXd::Unit(m, i));
  }
  out.all_gain = loop.gain_range(VectorXd::Ones(m));
  out.all_delay = loop.delay_limit(VectorXd::Ones(m));
  const HalfSensitivity half(settings);
  out.leg_disk.resize(m);
  for (Index i = 0; i < m; ++i) {
    out.leg_disk(i) = 1 / half.peak_of([i](const MatrixXcd& Z) { return std::abs(Z(i, i)); }).first;
  }
  std::tie(out.all_disk, out.all_disk_hz) = all_leg_disk_margin(settings);
  return out;
}

}  // namespace stillframe

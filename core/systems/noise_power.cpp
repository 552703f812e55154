#include "core/systems/noise_power.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

#include "core/numerics/infinity.hpp"
#include "core/numerics/two_pi.hpp"
#include "core/systems/frequency_sweep.hpp"

namespace stillframe {

using Complex = std::complex<double>;
using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

NoiseProcess NoiseProcess::stationary(double kept, double variance) {
  return {
      .kept = kept, .fresh = std::sqrt(variance * (1 - kept * kept)), .first = std::sqrt(variance)};
}

double NoiseProcess::density(double hz, double sample_time) const {
  // |z - a|^2 = (1 - a)^2 + 4 a sin^2(theta / 2), which keeps its digits near z = 1.
  const double sine = std::sin(std::numbers::pi * hz * sample_time);
  return 2 * sample_time * fresh * fresh / ((1 - kept) * (1 - kept) + 4 * kept * sine * sine);
}

namespace {

MatrixXd congruent(const MatrixXd& A, const MatrixXd& P) { return A * P * A.transpose(); }

/// Sums over m steps of P -> A P A^T + Q: of the covariance from rest, and of one that was there.
class CovarianceSums {
 public:
  CovarianceSums(MatrixXd A, MatrixXd Q, MatrixXd P_0)
      : A_(std::move(A)),
        Q_(std::move(Q)),
        P_0_(std::move(P_0)),
        power_(MatrixXd::Identity(A_.rows(), A_.rows())),
        fresh_(MatrixXd::Zero(A_.rows(), A_.rows())),
        sum_(fresh_),
        sum_of_first_(fresh_) {}

  void step() {
    sum_ += fresh_;
    fresh_ = Q_ + congruent(A_, fresh_);
    sum_of_first_ = P_0_ + congruent(A_, sum_of_first_);
    power_ = A_ * power_;
    ++m_;
  }
  void twice() {
    sum_ += m_ * fresh_ + congruent(power_, sum_);
    fresh_ += congruent(power_, fresh_);
    sum_of_first_ += congruent(power_, sum_of_first_);
    power_ = power_ * power_;
    m_ *= 2;
  }
  /// P_0 + ... + P_{m-1}.
  MatrixXd sum() const { return sum_ + sum_of_first_; }

 private:
  MatrixXd A_, Q_, P_0_;
  MatrixXd power_;         ///< A^m
  MatrixXd fresh_, sum_;   ///< P_m from rest; P_0 to P_{m-1} from rest
  MatrixXd sum_of_first_;  ///< A^k P_0 A^kT, k from 0 to m - 1
  double m_ = 0;
};

}  // namespace

VectorXd mean_square_over(const LinearSystem& system, const NoiseProcess& process, std::int64_t n) {
  const Index n_v = system.B.cols(), n_x = system.A.rows(), N = n_v + n_x;
  MatrixXd A = MatrixXd::Zero(N, N), Q = A, P_0 = A, C(system.C.rows(), N);
  A.topLeftCorner(n_v, n_v).diagonal().setConstant(process.kept);
  A.bottomLeftCorner(n_x, n_v) = system.B;
  A.bottomRightCorner(n_x, n_x) = system.A;
  Q.topLeftCorner(n_v, n_v).diagonal().setConstant(process.fresh * process.fresh);
  P_0.topLeftCorner(n_v, n_v).diagonal().setConstant(process.first * process.first);
  C << system.D, system.C;
  CovarianceSums sums(std::move(A), std::move(Q), std::move(P_0));
  for (int bit = std::bit_width(static_cast<std::uint64_t>(n)); bit-- > 0;) {
    sums.twice();
    if ((n >> bit) & 1) sums.step();
  }
  // Rounding may leave less than nothing of what is zero.
  return (C * sums.sum() * C.transpose()).diagonal().cwiseMax(0) / static_cast<double>(n);
}

namespace {

// Nodes from the middle outwards and weights of the rule of 15 points and of that of 7 among them.
// Source: R. Piessens et al., QUADPACK (Springer, 1983).
constexpr std::array<double, 8> nodes = {
    0.000000000000000000, 0.207784955007898468, 0.405845151377397167, 0.586087235467691130,
    0.741531185599394440, 0.864864423359769073, 0.949107912342758525, 0.991455371120812640};
constexpr std::array<double, 8> kronrod = {
    0.209482141084727828, 0.204432940075298892, 0.190350578064785410, 0.169004726639267903,
    0.140653259715525919, 0.104790010322250184, 0.063092092629978553, 0.022935322010529225};
constexpr std::array<double, 8> gauss = {0.417959183673469388, 0, 0.381830050505118945, 0,
                                         0.279705391489276668, 0, 0.129484966168869693, 0};

// Of each part, and beside it of all that the kind does to any output: what is less is rounding.
constexpr double tolerance = 1e-6, negligible = 1e-10;
/// Halvings of a part: what is left is narrower than any pole is known.
constexpr int deepest = 40;

/// The densities behind a system as one list of numbers, and their integrals.
class Spectrum {
 public:
  Spectrum(const LinearSystem& system, const std::vector<NoiseKind>& kinds, double sample_time)
      : sweep_(proper_system(system)),
        kinds_(kinds),
        sample_time_(sample_time),
        n_y_(system.C.rows()),
        G_(system.C.rows(), system.B.cols()),
        values_(2 * n_y_ * static_cast<Index>(kinds.size())) {}

  /// Integrals, without and with (2 pi f)^-2: for every kind n_y and n_y numbers, the latter zero
  /// of a part that begins at 0 Hz. At once, or as finely as it takes with errors of `least`.
  ArrayXd at_once(double from_hz, double to_hz) {
    least_ = ArrayXd::Constant(values_.size(), infinity);
    return over(from_hz, to_hz, 0);
  }
  ArrayXd finely(double from_hz, double to_hz, const ArrayXd& least) {
    least_ = least;
    return over(from_hz, to_hz, deepest);
  }

  /// Hz, where the system may peak, ascending.
  std::vector<double> peaks() const {
    std::vector<double> found;
    for (const Complex z : sweep_.poles()) {
      if (z.imag() > 0) found.push_back(std::arg(z) / (two_pi * sample_time_));
    }
    std::sort(found.begin(), found.end());
    return found;
  }

 private:
  ArrayXd over(double from_hz, double to_hz, int deep) {
    with_velocity_ = from_hz > 0;
    const double half = (to_hz - from_hz) / 2, middle = (from_hz + to_hz) / 2;
    ArrayXd fine = ArrayXd::Zero(values_.size()), coarse = fine;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      for (const double side : {-1.0, 1.0}) {
        if (i == 0 && side > 0) continue;
        evaluate(middle + side * half * nodes[i]);
        fine += half * kronrod[i] * values_;
        coarse += half * gauss[i] * values_;
      }
    }
    const bool met = ((fine - coarse).abs() <= tolerance * fine + least_).all();
    if (met || deep == 0) return fine;
    return over(from_hz, middle, deep - 1) + over(middle, to_hz, deep - 1);
  }

  void evaluate(double hz) {
    sweep_.evaluate_unrefined(std::polar(1.0, two_pi * hz * sample_time_), G_);
    const ArrayXd gain = G_.rowwise().squaredNorm().array();
    const double velocity = with_velocity_ ? 1 / ((two_pi * hz) * (two_pi * hz)) : 0;
    Index at = 0;
    for (const NoiseKind& kind : kinds_) {
      double density = 0;
      for (const NoiseProcess& process : kind) density += process.density(hz, sample_time_);
      values_.segment(at, n_y_) = density * gain;
      values_.segment(at + n_y_, n_y_) = density * velocity * gain;
      at += 2 * n_y_;
    }
  }

  FrequencySweep sweep_;
  const std::vector<NoiseKind>& kinds_;
  double sample_time_;
  Index n_y_;
  Eigen::MatrixXcd G_;
  ArrayXd values_, least_;
  bool with_velocity_ = true;
};

/// A cell between edges, cut where the system may peak.
struct Part {
  Index cell;
  double from_hz, to_hz;
};

std::vector<Part> parts_of(const VectorXd& edges_hz, const std::vector<double>& peaks) {
  std::vector<Part> parts;
  for (Index cell = 0; cell + 1 < edges_hz.size(); ++cell) {
    double from = edges_hz(cell);
    for (const double peak : peaks) {
      if (!(peak > from && peak < edges_hz(cell + 1))) continue;
      parts.push_back({cell, from, peak});
      from = peak;
    }
    parts.push_back({cell, from, edges_hz(cell + 1)});
  }
  return parts;
}

}  // namespace

std::vector<NoisePower> noise_power(const LinearSystem& system, const std::vector<NoiseKind>& kinds,
                                    double sample_time, const VectorXd& edges_hz) {
  const Index n_y = system.C.rows(), n_cells = edges_hz.size() - 1;
  std::vector<NoisePower> powers(kinds.size(),
                                 {MatrixXd::Zero(n_y, n_cells), MatrixXd::Zero(n_y, n_cells)});
  if (kinds.empty()) return powers;
  Spectrum spectrum(system, kinds, sample_time);
  const std::vector<Part> parts = parts_of(edges_hz, spectrum.peaks());
  ArrayXd least = ArrayXd::Zero(2 * n_y * std::ssize(kinds));
  for (const Part& part : parts) least += spectrum.at_once(part.from_hz, part.to_hz);
  for (Index at = 0; at < least.size(); at += n_y) {
    least.segment(at, n_y).setConstant(negligible * least.segment(at, n_y).maxCoeff());
  }
  for (const Part& part : parts) {
    const ArrayXd found = spectrum.finely(part.from_hz, part.to_hz, least);
    for (std::size_t kind = 0; kind < kinds.size(); ++kind) {
      const Index at = 2 * n_y * static_cast<Index>(kind);
      powers[kind].power.col(part.cell) += found.segment(at, n_y).matrix();
      powers[kind].integrated.col(part.cell) += found.segment(at + n_y, n_y).matrix();
    }
  }
  return powers;
}

}  // namespace stillframe

#include "core/mechanics/sparse/damped_modes.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <utility>
#include <vector>

#include "core/mechanics/sparse/mixed_factors.hpp"

namespace stillframe {

using Eigen::Index;
using Eigen::VectorXcd;
using Eigen::VectorXd;

namespace {

using Complex = std::complex<double>;

constexpr double not_found = std::numeric_limits<double>::quiet_NaN();

/// A mode on its way: p, and v with v^T M v = 1.
struct Damped {
  Complex p;
  VectorXcd v;
};

class DampedPencil {
 public:
  /// still: rad/s, below which what moves is free.
  DampedPencil(const MixedModel& mixed, const MixedState& state, double still)
      : mixed_(mixed),
        E_(mixed.strain_rows(state.x)),
        M_(mixed.mass(state.x)),
        D_(mixed.damping(state.x)),
        G_(mixed.geometric_stiffness(state.x, state.s, state.load_factor)),
        still_(still),
        keeps_modes_(keeps_modes()) {}

  /// The root of v^T (M p^2 + D p + K + G) v = 0 that is nearest to a p, or the one above or below
  /// where v does not yet know.
  Complex quotient(const VectorXcd& v, Complex near) const {
    const auto [d, k] = forms(v);
    const Complex root = std::sqrt(d * d / 4.0 - k);
    const Complex a = -d / 2.0 + root, b = -d / 2.0 - root;
    // Of two real roots far apart the small one is a difference; their product is not.
    const Complex large = std::abs(a) > std::abs(b) ? a : b;
    const Complex small = std::abs(large) > 0 ? k / large : large;
    return std::abs(large - near) < std::abs(small - near) ? large : small;
  }
  /// Both roots of a real mode.
  std::pair<Complex, Complex> roots(const VectorXd& v) const {
    const auto [d, k] = forms(v.cast<Complex>());
    // What moves freely strains dampers by rounding only.
    const double rounding = 1e-15 * v.cwiseAbs().dot(D_.cwiseAbs() * v.cwiseAbs());
    const double half = std::abs(d.real()) > rounding ? 0.5 * d.real() : 0,
                 square = half * half - k.real();
    if (square < 0) return {{-half, std::sqrt(-square)}, {-half, -std::sqrt(-square)}};
    const double large = -half - std::copysign(std::sqrt(square), half);
    return {large != 0 ? k.real() / large : 0, large};
  }

  /// From a mode without damping near p to the mode at an eigenvalue.
  Damped converged(Complex p, const VectorXd& start) const {
    constexpr double enough = 1e-12;
    constexpr int most = 30;
    // From beside the eigenvalue, where the matrix is not singular, and on the side where no others
    // are; each step is shorter by so much over the distance to the next one.
    constexpr double beside = 1e-5;
    Damped mode{p, start.cast<Complex>()};
    if (keeps_modes_ || std::abs(p) <= still_) return mode;
    MixedFactors<Complex> factors;
    VectorXcd s, y;
    for (int k = 0; k < most; ++k) {
      const Complex q = mode.p + beside * std::abs(mode.p);
      const Eigen::SparseMatrix<Complex> A =
          (q * q) * M_.cast<Complex>() + q * D_.cast<Complex>() + G_.cast<Complex>();
      if (!factors.compute(E_, compliance(q), A)) break;
      factors.solve({}, M_ * mode.v, s, y);
      const Complex square = y.transpose() * (M_ * y), before = mode.p;
      mode.v = y / std::sqrt(square);
      mode.p = quotient(mode.v, before);
      if (std::abs(mode.p - before) <= enough * std::abs(before)) return mode;
    }
    mode.p = {not_found, not_found};
    return mode;
  }
  Complex overlap(const VectorXcd& a, const VectorXcd& b) const { return a.transpose() * (M_ * b); }

 private:
  VectorXcd compliance(Complex p) const {
    return (mixed_.compliance().array() / (1.0 + mixed_.damping_time().array() * p)).matrix();
  }
  struct Forms {
    Complex d, k;
  };
  /// v^T D v and v^T (K + G) v, of strains and not of K.
  Forms forms(const VectorXcd& v) const {
    Forms forms{v.transpose() * (D_ * v), v.transpose() * (G_ * v)};
    const VectorXcd e = E_ * v;
    for (Index i = 0; i < e.size(); ++i) {
      const double c = mixed_.compliance()(i);
      if (c == 0) continue;
      const Complex energy = e(i) * e(i) / c;
      forms.k += energy;
      forms.d += mixed_.damping_time()(i) * energy;
    }
    return forms;
  }
  /// Whether all stiffness has one damping time, and there is nothing else that resists: then the
  /// modes are those without damping.
  bool keeps_modes() const {
    if (D_.nonZeros() > 0 || G_.nonZeros() > 0) return false;
    double time = -1;
    for (Index i = 0; i < E_.rows(); ++i) {
      if (mixed_.compliance()(i) == 0) continue;
      // Those of equal beams, to the rounding of their stiffness.
      if (time >= 0 && std::abs(mixed_.damping_time()(i) - time) > 1e-13 * time) return false;
      time = mixed_.damping_time()(i);
    }
    return true;
  }

  const MixedModel& mixed_;
  SparseMatrix E_, M_, D_, G_;
  double still_;
  bool keeps_modes_;
};

VectorXcd eigenvalues_of(const MixedModel& mixed, const MixedState& state,
                         const LowestModes& modes) {
  const Index n = modes.squares.size();
  VectorXcd values(2 * n);
  if (!mixed.damped()) {
    for (Index i = 0; i < n; ++i) {
      const double omega = std::sqrt(modes.squares(i));
      values.segment<2>(2 * i) << Complex(0, omega), Complex(0, -omega);
    }
    return values;
  }
  double lowest = modes.squares(n - 1);
  for (const double square : modes.squares) {
    if (square > 0) lowest = std::min(lowest, square);
  }
  const DampedPencil pencil(mixed, state, 1e-7 * std::sqrt(lowest));
  std::vector<Damped> found;
  const auto add = [&](Complex p, const VectorXd& start) {
    const Damped mode = pencil.converged(p, start);
    for (const Damped& other : found) {
      if (std::abs(mode.p - other.p) <= 1e-9 * std::abs(mode.p) &&
          std::abs(pencil.overlap(mode.v, other.v)) > 0.5) {
        return Complex(not_found, not_found);
      }
    }
    found.push_back(mode);
    return mode.p;
  };
  for (Index i = 0; i < n; ++i) {
    const VectorXd v = modes.shapes.col(i);
    const auto [upper, lower] = pencil.roots(v);
    values(2 * i) = add(upper, v);
    values(2 * i + 1) = upper.imag() != 0 ? std::conj(values(2 * i)) : add(lower, v);
  }
  return values;
}

}  // namespace

Modes sparse_modes(const MixedModel& mixed, const MixedState& state, Index n_modes) {
  const LowestModes lowest = lowest_modes(mixed, state, n_modes);
  Modes modes;
  modes.natural_frequencies_hz = lowest.natural_frequencies_hz;
  modes.shapes = lowest.shapes;
  modes.eigenvalues = eigenvalues_of(mixed, state, lowest);
  modes.known_to.resize(modes.eigenvalues.size());
  for (Index i = 0; i < lowest.squares.size(); ++i) {
    // d omega = d omega^2 / (2 omega), or what the square of nothing is known to.
    const double omega = std::sqrt(lowest.squares(i)),
                 known =
                     omega > 0 ? lowest.known_to(i) / (2 * omega) : std::sqrt(lowest.known_to(i));
    modes.known_to.segment<2>(2 * i).setConstant(known);
  }
  judge_eigenvalues(modes);
  return modes;
}

}  // namespace stillframe

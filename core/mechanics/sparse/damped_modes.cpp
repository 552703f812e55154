#include "core/mechanics/sparse/damped_modes.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <utility>
#include <vector>

#include "core/mechanics/sparse/mixed_factors.hpp"

namespace stillframe {

using Eigen::Index;
using Eigen::MatrixXd;
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
        G_(mixed.geometric_stiffness(state)),
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
  /// D on the modes V (n_c x n) without damping, n x n, without what rounding strains the dampers
  /// by.
  MatrixXd projected_damping(const MatrixXd& V) const {
    const MatrixXd E_V = E_ * V;
    const VectorXd viscosity = mixed_.stiffness().cwiseProduct(mixed_.damping_time());
    MatrixXd D = E_V.transpose() * viscosity.asDiagonal() * E_V + V.transpose() * (D_ * V);
    const MatrixXd sizes = V.cwiseAbs(),
                   rounding = 1e-15 * sizes.transpose() * (D_.cwiseAbs() * sizes);
    return (D.cwiseAbs().array() > rounding.array()).select(D, 0);
  }

  /// From near an eigenvalue p to it.
  Damped converged(Complex p, const VectorXcd& start) const {
    constexpr double enough = 1e-12, settled = 1e-7;  // rounding may be all that still changes it
    constexpr int most = 30;
    // From beside the eigenvalue, where the matrix is not singular, and on the side where no others
    // are; each step is shorter by so much over the distance to the next one.
    constexpr double beside = 1e-4;
    Damped mode{p, start};
    if (std::abs(p) <= still_) mode.p = 0;
    if (keeps_modes_ || mode.p == 0.0) return mode;
    MixedFactors<Complex> factors;
    VectorXcd s, y;
    double last = 0;
    for (int k = 0; k < most; ++k) {
      const Complex q = mode.p + beside * std::abs(mode.p);
      const Eigen::SparseMatrix<Complex> A =
          (q * q) * M_.cast<Complex>() + q * D_.cast<Complex>() + G_.cast<Complex>();
      if (!factors.compute(E_, compliance(q), A)) break;
      factors.solve({}, M_ * mode.v, s, y);
      const Complex square = y.transpose() * (M_ * y), before = mode.p;
      mode.v = y / std::sqrt(square);
      mode.p = quotient(mode.v, before);
      const double change = std::abs(mode.p - before) / std::abs(before);
      if (change <= enough || (change <= settled && change >= 0.5 * last)) return mode;
      last = change;
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
    const VectorXcd e = E_ * v, energies = e.cwiseProduct(e).cwiseProduct(mixed_.stiffness());
    Forms forms{v.transpose() * (D_ * v), v.transpose() * (G_ * v)};
    forms.d += energies.cwiseProduct(mixed_.damping_time()).sum();
    forms.k += energies.sum();
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

/// The damped modes of what moves in the undamped ones alone, by modulus: of a conjugate pair that
/// with the positive imaginary part, real ones two by two. With less damping than keeps a mode from
/// ringing they are near those of the whole.
std::vector<Damped> ritz_modes(const LowestModes& modes, const MatrixXd& D) {
  const Index n = modes.squares.size();
  MatrixXd A = MatrixXd::Zero(2 * n, 2 * n);
  A.topRightCorner(n, n).setIdentity();
  A.bottomLeftCorner(n, n).diagonal() = -modes.squares;
  A.bottomRightCorner(n, n) = -D;
  const Eigen::EigenSolver<MatrixXd> solver(A);
  std::vector<Damped> found, real;
  for (Index i = 0; i < 2 * n; ++i) {
    const Complex p = solver.eigenvalues()(i);
    if (p.imag() < 0) continue;
    const VectorXcd y = solver.eigenvectors().col(i).head(n);
    (p.imag() > 0 ? found : real).push_back({p, modes.shapes * y});
  }
  const auto lower = [](const Damped& a, const Damped& b) { return std::abs(a.p) < std::abs(b.p); };
  std::sort(real.begin(), real.end(), lower);
  std::stable_sort(found.begin(), found.end(), lower);
  for (size_t i = 0; i + 1 < real.size(); i += 2) {
    const auto at = std::upper_bound(found.begin(), found.end(), real[i], lower);
    found.insert(at, {real[i], real[i + 1]});
  }
  return found;
}

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
  const auto add = [&](const Damped& start) {
    const Damped mode = pencil.converged(start.p, start.v);
    for (const Damped& other : found) {
      if (mode.p != 0.0 && std::abs(mode.p - other.p) <= 1e-9 * std::abs(mode.p) &&
          std::abs(pencil.overlap(mode.v, other.v)) > 0.5) {
        return Complex(not_found, not_found);
      }
    }
    found.push_back(mode);
    return mode.p;
  };
  const std::vector<Damped> starts = ritz_modes(modes, pencil.projected_damping(modes.shapes));
  Index at = 0;
  for (const Damped& start : starts) {
    const Complex value = add(start);
    values(at++) = value;
    if (start.p.imag() != 0) values(at++) = std::conj(value);
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

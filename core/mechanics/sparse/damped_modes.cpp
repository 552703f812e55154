#include "core/mechanics/sparse/damped_modes.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <utility>
#include <vector>

#include "core/mechanics/sparse/mixed_factors.hpp"
#include "core/numerics/balance.hpp"
#include "core/numerics/infinity.hpp"

namespace stillframe {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

namespace {

using Complex = std::complex<double>;

constexpr double not_found = std::numeric_limits<double>::quiet_NaN();

/// A mode on its way: p, and v = W y of the basis W.
struct Damped {
  Complex p;
  VectorXcd y;
  double change = infinity;  ///< of p in the last round, relative
  bool settled = false;
};

/// (p^2 M + p D + K + G) v = 0 on a real basis W of unit mass: the modes V without damping and,
/// beside them, what damping mixes into those.
class DampedPencil {
 public:
  DampedPencil(const MixedModel& mixed, const MixedState& state, const LowestModes& modes)
      : mixed_(mixed),
        E_(mixed.strain_rows(state.x)),
        M_(mixed.mass(state.x)),
        D_(mixed.damping(state.x)),
        G_(mixed.geometric_stiffness(state)),
        modes_(modes),
        held_(mixed.stiffness()),
        W_(modes.shapes) {
    // So stiff that it changes no square by more than 1e-12 of the highest, and not so stiff that
    // rounding of V strains it.
    const double stiff = 1e12 * modes.squares.maxCoeff() * M_.diagonal().maxCoeff();
    held_ = (mixed.compliance().array() == 0).select(stiff, held_);
    project();
  }

  /// All 2 n of the basis but the conjugates.
  std::vector<Damped> ritz_modes() const {
    const Index n = W_.cols();
    MatrixXd A = MatrixXd::Zero(2 * n, 2 * n);
    A.topRightCorner(n, n).setIdentity();
    A.bottomLeftCorner(n, n) = -stiffness_;
    A.bottomRightCorner(n, n) = -damping_;
    const VectorXd scale = balancing_scales(A);
    const Eigen::EigenSolver<MatrixXd> solver(scale.cwiseInverse().asDiagonal() * A *
                                              scale.asDiagonal());
    std::vector<Damped> found;
    for (Index i = 0; i < 2 * n; ++i) {
      const Complex p = solver.eigenvalues()(i);
      if (p.imag() < 0) continue;
      const VectorXcd y = (scale.asDiagonal() * solver.eigenvectors().col(i)).head(n).normalized();
      found.push_back({quotient(y, p), y});
    }
    return found;
  }

  /// Steps of inverse iteration for one factorisation, from so far beside the eigenvalue, where the
  /// matrix is not singular, and on the side where no others are.
  static constexpr int steps = 2;
  static constexpr double beside = 1e-4;

  /// Puts into the basis what steps of inverse iteration make of each mode that is not settled.
  /// The basis keeps V and what the modes have of the rest, and they are written in it.
  void widen(std::vector<Damped>& modes) {
    const Index n_rest = W_.cols() - modes_.shapes.cols();
    const MatrixXd rest = W_.rightCols(n_rest);
    std::vector<VectorXcd> kept, stepped;
    VectorXcd s, x;
    for (const Damped& mode : modes) {
      if (n_rest > 0) kept.push_back(rest * mode.y.tail(n_rest));
      if (mode.settled) continue;
      const Complex q = mode.p + beside * std::abs(mode.p);
      const Eigen::SparseMatrix<Complex> A =
          (q * q) * M_.cast<Complex>() + q * D_.cast<Complex>() + G_.cast<Complex>();
      if (!factors_.compute(E_, compliance(q), A)) continue;
      x = W_ * mode.y;
      for (int step = 0; step < steps; ++step) {
        factors_.solve({}, M_ * x, s, x);
        if (!x.allFinite()) break;
        x.normalize();
        stepped.push_back(x);
      }
    }
    const MatrixXd before = W_;
    W_ = modes_.shapes;
    for (const auto* columns : {&kept, &stepped}) {
      for (const VectorXcd& column : *columns) {
        take_up(column.real(), column.norm());
        take_up(column.imag(), column.norm());
      }
    }
    const MatrixXd to_new = W_.transpose() * (M_ * before);
    for (Damped& mode : modes) mode.y = to_new * mode.y;
    project();
  }

  /// Rounding of the modes without damping, in p, as far as the mode is made of them, or what p has
  /// changed by in the last round: rad/s.
  double known_to(const Damped& mode) const {
    const Index n = modes_.squares.size();
    const double change = mode.y.head(n).cwiseAbs2().dot(modes_.known_to), a = mode.y.squaredNorm(),
                 b = std::abs(2.0 * mode.p * a + mode.y.dot(damping_ * mode.y));
    const double known = change > 0 ? 2 * change / (b + std::sqrt(b * b + 4 * a * change)) : 0.0;
    return std::isfinite(mode.change) ? std::max(known, mode.change * std::abs(mode.p)) : known;
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

 private:
  VectorXcd compliance(Complex p) const {
    return (mixed_.compliance().array() / (1.0 + mixed_.damping_time().array() * p)).matrix();
  }

  /// The root of y^T (p^2 + D p + K) y = 0 that is nearest to a p, which knows it to the square of
  /// what y is off by. Of modes that have one p, y may be a sum for which that says nothing.
  Complex quotient(const VectorXcd& y, Complex near) const {
    const Complex m = y.transpose() * y;
    if (std::abs(m) < 0.1 * y.squaredNorm()) return near;
    const Complex d = Complex(y.transpose() * damping_ * y) / m,
                  k = Complex(y.transpose() * stiffness_ * y) / m;
    const Complex root = std::sqrt(d * d / 4.0 - k);
    const Complex a = -d / 2.0 + root, b = -d / 2.0 - root;
    // Of two real roots far apart the small one is a difference; their product is not.
    const Complex large = std::abs(a) > std::abs(b) ? a : b;
    const Complex small = std::abs(large) > 0 ? k / large : large;
    Complex p = std::abs(large - near) < std::abs(small - near) ? large : small;
    if (near.imag() == 0) p.imag(0);
    return p;
  }

  void project() {
    const MatrixXd E_W = E_ * W_;
    const VectorXd viscosity = mixed_.stiffness().cwiseProduct(mixed_.damping_time());
    damping_ = E_W.transpose() * viscosity.asDiagonal() * E_W + W_.transpose() * (D_ * W_);
    // Without what rounding strains the dampers by.
    const MatrixXd sizes = W_.cwiseAbs(),
                   rounding = 1e-15 * sizes.transpose() * (D_.cwiseAbs() * sizes);
    damping_ = (damping_.cwiseAbs().array() > rounding.array()).select(damping_, 0);
    stiffness_ = E_W.transpose() * held_.asDiagonal() * E_W + W_.transpose() * (G_ * W_);
    const Index n = modes_.shapes.cols();
    stiffness_.topLeftCorner(n, n) = modes_.squares.asDiagonal();
  }

  /// whole: the size beside which what is left of a column says nothing.
  void take_up(VectorXd column, double whole) {
    constexpr double nothing = 1e-8;  // its square is in p
    for (int twice = 0; twice < 2; ++twice) column -= W_ * (W_.transpose() * (M_ * column));
    const double mass = column.dot(M_ * column);
    if (!(mass > 0) || column.norm() <= nothing * whole) return;
    W_.conservativeResize(Eigen::NoChange, W_.cols() + 1);
    W_.rightCols<1>() = column / std::sqrt(mass);
  }

  const MixedModel& mixed_;
  SparseMatrix E_, M_, D_, G_;
  const LowestModes& modes_;
  VectorXd held_;  ///< the stiffness, and one of conditions, which rounding breaks
  MatrixXd W_, stiffness_, damping_;
  MixedFactors<Complex> factors_;
};

/// What p of a mode that changed by so much is off by: a step of inverse iteration leaves of what
/// v is off by the share beside over the distance to the next eigenvalue, of p the square of that.
double left_over(const Damped& mode, const std::vector<Damped>& found) {
  double gap = std::abs(mode.p);
  for (const Damped& other : found) {
    if (other.p != mode.p) gap = std::min(gap, std::abs(other.p - mode.p));
  }
  const double share = DampedPencil::beside * std::abs(mode.p) / gap;
  return mode.change * std::pow(share, 2 * DampedPencil::steps);
}

/// To each mode the nearest of those found, to no two the same: the nearest pairs first.
void follow(std::vector<Damped>& modes, const std::vector<Damped>& found) {
  constexpr double enough = 1e-12, rounding = 1e-7;  // rounding may be all that still changes it
  constexpr double nearly = 1e-6;
  constexpr double small = 1e-8;  // of the gap, which is one of what is not known better
  struct Step {
    double length;
    size_t from, to;
  };
  std::vector<Step> steps;
  for (size_t i = 0; i < modes.size(); ++i) {
    for (size_t j = 0; j < found.size(); ++j) {
      steps.push_back({std::abs(modes[i].p - found[j].p), i, j});
    }
  }
  std::sort(steps.begin(), steps.end(),
            [](const Step& a, const Step& b) { return a.length < b.length; });
  std::vector<bool> gone(modes.size()), taken(found.size());
  for (const Step& step : steps) {
    Damped& mode = modes[step.from];
    if (gone[step.from] || taken[step.to] || mode.p == 0.0) continue;
    gone[step.from] = taken[step.to] = true;
    if (mode.settled) continue;
    const double last = mode.change, change = step.length / std::abs(mode.p);
    // What was as good as found and goes away again does so by rounding of a basis that has grown.
    if (last <= nearly && change > 10 * last) {
      mode.settled = true;
      continue;
    }
    mode = found[step.to];
    mode.change = change;
    mode.settled = change <= enough || (change <= rounding && change >= 0.5 * last) ||
                   (change <= small && left_over(mode, found) <= enough);
  }
}

/// What the modes turn into when they are damped, in neighbours by modulus: pairs, and real ones
/// two by two. Those that were not found are last.
void damp(const MixedModel& mixed, const MixedState& state, const LowestModes& lowest,
          Modes& result) {
  constexpr int most = 8;
  DampedPencil pencil(mixed, state, lowest);
  std::vector<Damped> modes = pencil.ritz_modes();
  // What stands still without damping and with it has no other basis to be sought in.
  double still = lowest.squares(lowest.squares.size() - 1);
  for (const double square : lowest.squares) {
    if (square > 0) still = std::min(still, square);
  }
  still = 1e-7 * std::sqrt(still);
  for (const Damped& mode : modes) still = std::max(still, 1e-12 * std::abs(mode.p));
  const bool kept = pencil.keeps_modes();
  for (Damped& mode : modes) {
    if (std::abs(mode.p) <= still) mode.p = 0;
    mode.settled = kept || mode.p == 0.0;
  }
  const auto unsettled = [](const Damped& mode) { return !mode.settled; };
  for (int k = 0; k < most && std::any_of(modes.begin(), modes.end(), unsettled); ++k) {
    pencil.widen(modes);
    // Another free motion is none that anything turns into.
    std::vector<Damped> found = pencil.ritz_modes();
    std::erase_if(found, [&](const Damped& mode) { return std::abs(mode.p) <= still; });
    follow(modes, found);
  }
  std::vector<std::pair<Damped, Damped>> pairs;
  std::vector<Damped> real;
  for (const Damped& mode : modes) {
    if (!mode.settled) continue;
    if (mode.p.imag() == 0) {
      real.push_back(mode);
      continue;
    }
    pairs.emplace_back(mode, mode);
    pairs.back().second.p = std::conj(mode.p);
  }
  const auto smaller = [](const Damped& a, const Damped& b) {
    return std::abs(a.p) < std::abs(b.p);
  };
  std::sort(real.begin(), real.end(), smaller);
  if (real.size() % 2 != 0) real.push_back({{not_found, not_found}, real.back().y});
  for (size_t i = 0; i < real.size(); i += 2) pairs.emplace_back(real[i], real[i + 1]);
  std::sort(pairs.begin(), pairs.end(),
            [&](const auto& a, const auto& b) { return smaller(a.first, b.first); });
  const Index n = lowest.squares.size();
  result.eigenvalues.setConstant(2 * n, {not_found, not_found});
  result.known_to.setZero(2 * n);
  for (Index i = 0; i < std::min(n, static_cast<Index>(pairs.size())); ++i) {
    const auto& [one, other] = pairs[static_cast<size_t>(i)];
    result.eigenvalues.segment<2>(2 * i) << one.p, other.p;
    result.known_to.segment<2>(2 * i) << pencil.known_to(one), pencil.known_to(other);
  }
}

}  // namespace

Modes sparse_modes(const MixedModel& mixed, const MixedState& state, Index n_modes) {
  const LowestModes lowest = lowest_modes(mixed, state, n_modes);
  const Index n = lowest.squares.size();
  Modes modes;
  modes.natural_frequencies_hz = lowest.natural_frequencies_hz;
  modes.shapes = lowest.shapes;
  if (mixed.damped()) {
    damp(mixed, state, lowest, modes);
  } else {
    modes.eigenvalues.resize(2 * n);
    modes.known_to.resize(2 * n);
    for (Index i = 0; i < n; ++i) {
      const double omega = std::sqrt(lowest.squares(i));
      modes.eigenvalues.segment<2>(2 * i) << Complex(0, omega), Complex(0, -omega);
      // d omega = d omega^2 / (2 omega), or what the square of nothing is known to.
      modes.known_to.segment<2>(2 * i).setConstant(omega > 0 ? lowest.known_to(i) / (2 * omega)
                                                             : std::sqrt(lowest.known_to(i)));
    }
  }
  judge_eigenvalues(modes);
  return modes;
}

}  // namespace stillframe

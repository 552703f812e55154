#include "core/mechanics/sparse/lowest_modes.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

#include "core/errors/input_error.hpp"
#include "core/mechanics/sparse/mixed_factors.hpp"
#include "core/mechanics/unstable.hpp"
#include "core/numerics/lanczos.hpp"

namespace stillframe {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// The largest omega^2 of a coordinate by itself: far above all that is asked for.
double largest_square(const SparseMatrix& E, const VectorXd& compliance, const SparseMatrix& M) {
  double largest = 0;
  const VectorXd mass = M.diagonal();
  for (Index j = 0; j < E.cols(); ++j) {
    double stiffness = 0;
    for (SparseMatrix::InnerIterator it(E, j); it; ++it) {
      if (compliance(it.row()) != 0) {
        stiffness += it.value() * it.value() / std::abs(compliance(it.row()));
      }
    }
    if (mass(j) > 0) largest = std::max(largest, stiffness / mass(j));
  }
  return largest;
}

/// The squares that are lowest, seen from -shift, upwards.
struct Seen {
  VectorXd squares, known_to;
  MatrixXd shapes;
};

class Pencil {
 public:
  Pencil(const MixedModel& mixed, const MixedState& state)
      : mixed_(mixed),
        E_(mixed.strain_rows(state.x)),
        M_(mixed.mass(state.x)),
        G_(mixed.geometric_stiffness(state.x, state.s, state.load_factor)) {}

  const SparseMatrix& G() const { return G_; }
  double largest() const { return largest_square(E_, mixed_.compliance(), M_); }

  Seen seen_from(double shift, Index n_modes) const {
    MixedFactors<double> factors;
    factor(factors, SparseMatrix(shift * M_ + G_));
    VectorXd s, M_x;
    const LanczosPairs pairs = largest_pairs(
        M_.rows(), n_modes, Largest::modulus,
        [&](const VectorXd& x, VectorXd& y) {
          M_x.noalias() = M_ * x;
          factors.solve({}, M_x, s, y);
        },
        [&](const VectorXd& x, VectorXd& y) { y.noalias() = M_ * x; });
    if (!pairs.converged) {
      throw Refusal("the lowest modes were not found: the Lanczos method did not converge");
    }
    // What has no mass has no mode: rounding of the largest.
    Index n = 0;
    const double largest = std::abs(pairs.values(0));
    while (n < n_modes && std::abs(pairs.values(n)) > 1e-15 * largest) ++n;
    std::vector<std::pair<Square, Index>> upwards;
    for (Index i = 0; i < n; ++i) {
      upwards.emplace_back(square_of(pairs.values(i), largest, shift, pairs.vectors.col(i)), i);
    }
    std::sort(upwards.begin(), upwards.end(),
              [](const auto& a, const auto& b) { return a.first.value < b.first.value; });
    Seen seen{VectorXd(n), VectorXd(n), MatrixXd(M_.rows(), n)};
    for (Index i = 0; i < n; ++i) {
      const auto& [square, from] = upwards[static_cast<size_t>(i)];
      seen.squares(i) = square.value;
      seen.known_to(i) = square.known_to;
      seen.shapes.col(i) = pairs.vectors.col(from);
    }
    return seen;
  }

  /// K + G is positive semidefinite, rounding aside: of (shift M - G) v = theta (K + shift M) v no
  /// theta is above one.
  bool stable(double shift) const {
    if (G_.nonZeros() == 0) return true;
    const SparseMatrix A = shift * M_ - G_;
    MixedFactors<double> factors;
    factor(factors, SparseMatrix(shift * M_));
    VectorXd s, A_x, e;
    const LanczosPairs pairs = largest_pairs(
        A.rows(), 1, Largest::algebraic,
        [&](const VectorXd& x, VectorXd& y) {
          A_x.noalias() = A * x;
          factors.solve({}, A_x, s, y);
        },
        [&](const VectorXd& x, VectorXd& y) {
          e.noalias() = E_ * x;
          for (Index i = 0; i < e.size(); ++i) {
            const double c = mixed_.compliance()(i);
            e(i) = c != 0 ? e(i) / c : 0;
          }
          y.noalias() = E_.transpose() * e + shift * (M_ * x);
        });
    return pairs.converged && pairs.values(0) <= 1 + 1e-9;
  }

 private:
  void factor(MixedFactors<double>& factors, const SparseMatrix& A) const {
    if (!factors.compute(E_, mixed_.compliance(), A) || factors.singular()) refuse_singular();
  }

  struct Square {
    double value, known_to;
  };
  /// omega^2 of a pair, as the operator has it or as the shape strains the elements, whichever
  /// rounding spares: the first is known to eps of the lowest square, which a soft mode beside
  /// stiff ones makes small, the second to what eps of the displacements strains.
  Square square_of(double value, double largest, double shift, const VectorXd& v) const {
    constexpr double eps = 2.2e-16;
    const Square seen{1 / value - shift, 4 * eps * largest / (value * value)};
    const VectorXd e = E_ * v, noise = eps * (E_.cwiseAbs() * v.cwiseAbs());
    double energy = v.dot(G_ * v), lost = 0;
    for (Index i = 0; i < e.size(); ++i) {
      const double c = mixed_.compliance()(i);
      if (c == 0) continue;
      energy += e(i) * e(i) / c;
      lost += (2 * std::abs(e(i)) + noise(i)) * noise(i) / std::abs(c);
    }
    return lost < seen.known_to ? Square{energy, lost} : seen;
  }

  const MixedModel& mixed_;
  SparseMatrix E_, M_, G_;
};

}  // namespace

void refuse_singular() {
  throw Refusal(
      "the equations are singular: conditions (rigid elements, supports) are not independent, or "
      "something can move that has neither stiffness nor mass");
}

LowestModes lowest_modes(const MixedModel& mixed, const MixedState& state, Index n_modes) {
  const Pencil pencil(mixed, state);
  if (n_modes >= mixed.n_coordinates()) {
    throw Refusal("more modes are asked for than there are coordinates");
  }
  // Seen from far away modes lie close together; seen from too near, what moves freely drowns the
  // others. From within a factor of a thousand of the lowest that is elastic both keep 13 digits.
  double shift = 1e-16 * pencil.largest();
  if (!(shift > 0) || !std::isfinite(shift)) throw Refusal("nothing that resists has mass");
  Seen seen;
  double free = 0;
  bool settled = false;
  for (int attempt = 0; attempt < 6 && !settled; ++attempt) {
    seen = pencil.seen_from(shift, n_modes);
    free = 1e-9 * shift;
    const auto elastic = std::find_if(seen.squares.begin(), seen.squares.end(),
                                      [&](double square) { return std::abs(square) > free; });
    if (elastic == seen.squares.end()) break;
    // A negative square seen from near may be all that the free motions have left of another.
    const double lowest = std::abs(*elastic);
    const bool drowned = elastic != seen.squares.begin() || *elastic < 0;
    settled = lowest > 1e-2 * shift && (!drowned || lowest < 1e4 * shift);
    if (!settled) shift = 0.1 * lowest;
  }
  LowestModes result;
  result.squares = seen.squares.unaryExpr(
      [&](double square) { return std::abs(square) <= free ? 0.0 : square; });
  result.shapes = seen.shapes;
  result.known_to = seen.known_to;
  if (result.squares.size() == 0) throw Refusal("nothing that resists has mass");
  if (result.squares(0) < 0 || !pencil.stable(shift)) {
    char why[64] = "the stiffness is not positive definite";
    if (result.squares(0) < 0) {
      std::snprintf(why, sizeof why, "omega^2 = %.6g (rad/s)^2 in mode 1", result.squares(0));
    }
    throw Unstable(why, result.shapes.col(0));
  }
  result.natural_frequencies_hz = result.squares.cwiseSqrt() / (2 * std::numbers::pi);
  return result;
}

}  // namespace stillframe

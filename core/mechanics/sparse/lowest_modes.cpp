#include "core/mechanics/sparse/lowest_modes.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/errors/formatted.hpp"
#include "core/errors/input_error.hpp"
#include "core/mechanics/sparse/mixed_factors.hpp"
#include "core/mechanics/sparse/unresisted.hpp"
#include "core/mechanics/unstable.hpp"
#include "core/numerics/lanczos.hpp"
#include "core/numerics/two_pi.hpp"

namespace stillframe {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// An omega^2 as large as any, in order of magnitude: all stiffness over all mass.
double largest_square(const SparseMatrix& E, const VectorXd& stiffness, const SparseMatrix& M) {
  const SparseMatrix squares = E.cwiseAbs2();
  return (squares.transpose() * stiffness.cwiseAbs()).sum() / M.diagonal().sum();
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
        G_(mixed.geometric_stiffness(state)),
        largest_(largest_square(E_, mixed.stiffness(), M_)) {}

  double largest() const { return largest_; }

  [[noreturn]] void refuse_singular(double shift) const {
    const std::string light = unresisted_coordinate(mixed_, E_, SparseMatrix(shift * M_ + G_));
    throw Refusal("the equations are singular: " +
                  (light.empty()
                       ? "conditions (rigid elements, supports) are not independent, or something "
                         "can move that has neither stiffness nor mass"
                       : light + " can move and has neither stiffness nor mass"));
  }
  bool stressed() const { return G_.nonZeros() > 0; }
  bool regular() const { return regular_; }  ///< from one shift at least

  /// False where the shift is not enough to tell the matrix from a singular one, or modes from
  /// what moves freely.
  /// in_any_time: as of largest_pairs.
  bool see_from(double shift, Index n_modes, Seen& seen, bool in_any_time = false) const {
    MixedFactors<double> factors;
    if (!factors.compute(E_, mixed_.compliance(), SparseMatrix(shift * M_ + G_))) return false;
    regular_ = true;
    VectorXd s;
    const LanczosPairs pairs = largest_pairs(
        M_, n_modes, Largest::modulus,
        [&](const VectorXd& f, VectorXd& y) { factors.solve({}, f, s, y); }, {}, in_any_time);
    if (!pairs.converged) return false;
    // What has no mass has no mode: rounding of the largest.
    Index n = 0;
    const double largest = pairs.values.size() > 0 ? std::abs(pairs.values(0)) : 0;
    while (n < pairs.values.size() && std::abs(pairs.values(n)) > 1e-15 * largest) ++n;
    std::vector<std::pair<Square, Index>> upwards;
    MatrixXd shapes = pairs.vectors.leftCols(n);
    for (Index i = 0; i < n; ++i) {
      // Of unit mass to rounding, not to that of the largest value.
      shapes.col(i) /= std::sqrt(shapes.col(i).dot(M_ * shapes.col(i)));
      upwards.emplace_back(square_of(pairs.values(i), largest, shift, shapes.col(i)), i);
    }
    std::sort(upwards.begin(), upwards.end(),
              [](const auto& a, const auto& b) { return a.first.value < b.first.value; });
    seen = {VectorXd(n), VectorXd(n), MatrixXd(M_.rows(), n)};
    for (Index i = 0; i < n; ++i) {
      const auto& [square, from] = upwards[static_cast<size_t>(i)];
      seen.squares(i) = square.value;
      seen.known_to(i) = square.known_to;
      seen.shapes.col(i) = shapes.col(from);
    }
    return true;
  }

  /// K + G is positive semidefinite, rounding aside: of (shift M - G) v = theta (K + shift M) v no
  /// theta is above one.
  bool stable(double shift) const {
    if (!stressed()) return true;
    const SparseMatrix A = shift * M_ - G_;
    MixedFactors<double> factors;
    if (!factors.compute(E_, mixed_.compliance(), SparseMatrix(shift * M_))) {
      refuse_singular(shift);
    }
    VectorXd s;
    const LanczosPairs pairs = largest_pairs(
        A, 1, Largest::algebraic,
        [&](const VectorXd& f, VectorXd& y) { factors.solve({}, f, s, y); },
        [&](const VectorXd& x, VectorXd& y) {
          const VectorXd sigma = mixed_.stiffness().cwiseProduct(E_ * x);
          y.noalias() = E_.transpose() * sigma + shift * (M_ * x);
        });
    if (!pairs.converged) {
      throw Refusal(
          "whether the configuration is stable was not found: Lanczos' method does not end");
    }
    return !(pairs.values.size() > 0 && pairs.values(0) > 1 + 1e-9);
  }

 private:
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
    // What rounding of the operator mixes into the shape strains it by the square of that.
    const double mixed_in = eps * largest / value;
    // It breaks conditions as well, by as much, and what holds them does work on that.
    double lost = mixed_in * mixed_in * largest_;
    if (mixed_.rigid()) lost += 4 * mixed_in / value;
    const VectorXd& k = mixed_.stiffness();
    lost += (2 * e.cwiseAbs() + noise).cwiseProduct(noise).dot(k.cwiseAbs());
    const double energy = v.dot(G_ * v) + e.cwiseAbs2().dot(k);
    return lost < seen.known_to ? Square{energy, lost} : seen;
  }

  const MixedModel& mixed_;
  SparseMatrix E_, M_, G_;
  double largest_;
  mutable bool regular_ = false;
};

/// Modes that rounding of the lowest ones hides, seen anew from their own height. free: up to where
/// a square is that of a free motion.
void look_closer(const Pencil& pencil, double free, Seen& seen) {
  constexpr double enough = 1e-11;
  constexpr int most = 4;
  const Index n = seen.squares.size();
  for (int k = 0; k < most; ++k) {
    Index first = 0;
    while (first < n &&
           (seen.squares(first) <= free || seen.known_to(first) <= enough * seen.squares(first))) {
      ++first;
    }
    Seen from_there;
    if (first == n || !pencil.see_from(0.1 * seen.squares(first), n, from_there) ||
        from_there.squares.size() < n) {
      return;
    }
    const Index n_above = n - first;
    if (!(from_there.known_to(first) < 0.5 * seen.known_to(first))) return;
    seen.squares.tail(n_above) = from_there.squares.tail(n_above);
    seen.known_to.tail(n_above) = from_there.known_to.tail(n_above);
    seen.shapes.rightCols(n_above) = from_there.shapes.rightCols(n_above);
  }
}

}  // namespace

LowestModes lowest_modes(const MixedModel& mixed, const MixedState& state, Index n_modes) {
  const Pencil pencil(mixed, state);
  // Seen from far away modes lie close together; seen from too near, what moves freely drowns the
  // others. From within a factor of a thousand of the lowest that is elastic both keep 13 digits.
  // To begin with, near the lowest of a chain of 10 000 beams.
  double shift = 1e-16 * pencil.largest();
  if (!(shift > 0) || !std::isfinite(shift)) throw Refusal("nothing that resists has mass");
  Seen seen;
  double free = 0, seen_from = 0;
  bool settled = false, in_any_time = false;
  double farthest = 1e-7 * pencil.largest();
  for (int attempt = 0; attempt < 16 && !settled; ++attempt) {
    if (!pencil.see_from(shift, n_modes, seen, in_any_time)) {
      if (seen_from > 0 && !in_any_time) {
        in_any_time = true;
        continue;
      }
      settled = seen_from > 0;  // what was seen from farther is as good as it gets
      if (settled) {
        shift = seen_from;
        break;
      }
      shift *= in_any_time ? 30 : 1e4;
      if (shift <= farthest) continue;
      if (in_any_time && pencil.regular()) {
        throw Refusal(
            "modes are hidden by the rounding of slower ones, or of what moves freely: ask for "
            "fewer, or hold the scene");
      }
      if (!pencil.regular()) pencil.refuse_singular(shift);
      // Beside what moves freely many modes may be beyond what Lanczos' method converges to.
      in_any_time = true;
      farthest = pencil.largest();
      shift = 1e-10 * pencil.largest();
      continue;
    }
    free = 1e-9 * shift;
    seen_from = shift;
    const auto elastic = std::find_if(seen.squares.begin(), seen.squares.end(),
                                      [&](double square) { return std::abs(square) > free; });
    settled = elastic == seen.squares.end();
    if (settled) break;
    // A negative square seen from near may be all that the free motions have left of another.
    const double lowest = std::abs(*elastic);
    const bool drowned = elastic != seen.squares.begin() || *elastic < 0;
    settled = lowest > 1e-3 * shift && (!drowned || lowest < 1e4 * shift);
    if (!settled) shift = 0.1 * lowest;
  }
  if (!settled) throw Refusal("the lowest modes were not found: no shift tells them apart");
  look_closer(pencil, free, seen);
  LowestModes result;
  result.squares = seen.squares;
  result.shapes = seen.shapes;
  result.known_to = seen.known_to;
  for (Index i = 0; i < seen.squares.size(); ++i) {
    // What is negative by little beside the shift is told by stable(); without stresses by any.
    const double square = seen.squares(i);
    if (square > std::max(free, seen.known_to(i))) continue;
    if (square < -std::max(1e-3 * shift, seen.known_to(i)) && pencil.stressed()) continue;
    result.squares(i) = 0;
    result.known_to(i) = std::max(seen.known_to(i), std::abs(square));
  }
  if (result.squares.size() == 0) throw Refusal("nothing that resists has mass");
  if (result.squares(0) < 0 || !pencil.stable(shift)) {
    throw Unstable(result.squares(0) < 0
                       ? formatted("omega^2 = %.6g (rad/s)^2 in mode 1", result.squares(0))
                       : "the stiffness is not positive definite",
                   result.shapes.col(0));
  }
  result.natural_frequencies_hz = result.squares.cwiseSqrt() / two_pi;
  return result;
}

}  // namespace stillframe

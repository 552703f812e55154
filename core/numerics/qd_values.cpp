#include "core/numerics/qd_values.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace stillframe {

namespace {

using Eigen::Index;

constexpr double epsilon = std::numeric_limits<double>::epsilon();

/// Stands for zero where it is divided by.
constexpr double tiny = 1e-290;

/// Whether e beside q (below it) changes no value of size `value` or more by more than rounding:
/// the matrix of squares has the entries e and sqrt(q e) of it.
bool negligible(double e, double q, double value) noexcept {
  return e <= epsilon * value && e * q <= (epsilon * value) * (epsilon * value);
}

struct Step {
  bool early;        ///< a remainder before the last was negative, and the rest was not done
  double remainder;  ///< the last one; negative: the shift was too large by about that much
};

/// The qd transform of (q, e) with a shift into (q_new, e_new).
Step transform(const double* q, const double* e, Index n, double shift, double* q_new,
               double* e_new) noexcept {
  double d = q[0] - shift;
  for (Index i = 0; i + 1 < n; ++i) {
    if (d < 0 && shift > 0) return {true, d};
    d = std::max(d, tiny);
    q_new[i] = d + e[i];
    const double ratio = q[i + 1] / q_new[i];
    e_new[i] = e[i] * ratio;
    d = d * ratio - shift;
  }
  q_new[n - 1] = d;
  return {false, d};
}

/// Eigenvalues of [a b; b c] with b^2 = square and the given determinant, without cancellation.
struct TwoByTwo {
  double large, small;
};
TwoByTwo eigenvalues(double a, double c, double square, double determinant) noexcept {
  const double half = (a - c) / 2, large = (a + c) / 2 + std::sqrt(half * half + square);
  return {large, large == 0 ? 0.0 : determinant / large};
}

/// A shift that is likely to be just below the smallest value of the block: the smaller eigenvalue
/// of the last two rows, less the norm of its residual in the rows above.
double estimate(const double* q, const double* e, Index n) noexcept {  // n > 2
  const double a = q[n - 2] + e[n - 2], c = q[n - 1], square = c * e[n - 2];
  const double value = eigenvalues(a, c, square, q[n - 2] * c).small;
  if (!(value > 0)) return 0.0;
  const double across = (a - value) * (a - value) + square;
  const double residual = across > 0 ? std::sqrt(q[n - 2] * e[n - 3] * square / across) : 0.0;
  return std::max(value - residual, value / 4);
}

/// One transform in place with the largest shift that is found to be allowed.
double advance(double* q, double* e, Index n, double* work) noexcept {
  double *q_new = work, *e_new = work + n;
  double shift = estimate(q, e, n);
  for (int attempt = 0;; ++attempt) {
    if (attempt == 5) shift = 0;
    const Step step = transform(q, e, n, shift, q_new, e_new);
    // Without a shift a negative remainder is rounding, and one that is no number comes from data
    // that are none, which the values then show.
    if (shift == 0) {
      q_new[n - 1] = step.remainder < 0 ? 0.0 : step.remainder;
      break;
    }
    if (!step.early && step.remainder >= 0) break;
    // The remainder that failed says by how much; couplings further on may take a little more.
    const double reduced = shift + step.remainder * (step.early ? 2.0 : 1 + 8 * epsilon);
    shift = attempt < 2 ? std::max(reduced, shift / 4) : shift / 4;
  }
  std::copy(q_new, q_new + n, q);
  std::copy(e_new, e_new + n - 1, e);
  return shift;
}

/// Sets the entries to zero that change no value by more than rounding.
void split_at_start(const double* q, double* e, Index n) noexcept {
  double d = q[0];
  for (Index i = 0; i + 1 < n; ++i) {
    if (e[i] <= epsilon * epsilon * d) {
      e[i] = 0;
      d = q[i + 1];
    } else {
      d = q[i + 1] * (d / (d + e[i]));
    }
  }
}

}  // namespace

void qd_values(double* q, double* e, Index n, double start, double* work, double* values) noexcept {
  double* taken = work + 2 * n;  // the shifts so far, of every row
  std::fill(taken, taken + n, start);
  if (n > 0 && start == 0) split_at_start(q, e, n);
  // Few steps a value are needed; the bound is against data that no rounding should produce.
  Index budget = 100 * n;
  for (Index end = n; end > 0; --budget) {
    Index first = end - 1;
    while (first > 0 && !negligible(e[first - 1], q[first], taken[first])) --first;
    if (first > 0) e[first - 1] = 0;
    const Index size = end - first, last = end - 1;
    if (size == 1 || budget < 0 || negligible(e[last - 1], q[last], taken[last] + q[last])) {
      if (last > 0) e[last - 1] = 0;
      values[last] = std::sqrt(taken[last] + std::max(q[last], 0.0));
      end = last;
      continue;
    }
    if (size == 2) {
      const TwoByTwo pair =
          eigenvalues(q[first] + e[first], q[last], q[last] * e[first], q[first] * q[last]);
      values[first] = std::sqrt(taken[last] + pair.large);
      values[last] = std::sqrt(taken[last] + pair.small);
      end = first;
      continue;
    }
    const double shift = advance(q + first, e + first, size, work);
    for (Index i = first; i < end; ++i) taken[i] += shift;
  }
}

}  // namespace stillframe

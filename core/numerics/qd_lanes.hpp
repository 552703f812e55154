#pragma once

#include <limits>
#include <utility>

#include "core/numerics/lanes.hpp"

namespace stillframe {

/// State of the qd algorithm in every lane: what is left are rows 0 to end, of which `taken` has
/// been taken away. q and e as in qd_values; q_new, e_new: the same again, as work.
struct QdLanes {
  Number *q, *e, *q_new, *e_new;
  Lanes taken;
  Eigen::Index end;
};

/// One transform with a shift a lane; where it failed, `remainder` is the first negative one, by
/// about which the shift was too large.
[[gnu::always_inline]] inline void qd_transform(const QdLanes& state, const Lanes& shift,
                                                Lanes& remainder) noexcept {
  constexpr double tiny = 1e-290;  // stands for zero where it is divided by
  Lanes d = state.q[0].value - shift, first = d;
  for (Eigen::Index i = 0; i + 1 < state.end; ++i) {
    first = first < 0 ? first : d;
    d = d < tiny ? tiny - Lanes{} : d;
    const Lanes sum = d + state.e[i].value, ratio = state.q[i + 1].value / sum;
    state.q_new[i].value = sum;
    state.e_new[i].value = state.e[i].value * ratio;
    d = d * ratio - shift;
  }
  // Without a shift a negative remainder can only be rounding.
  d = (shift == 0) & (d < 0) ? Lanes{} : d;
  first = shift == 0 ? d : first;
  state.q_new[state.end - 1].value = d;
  remainder = first < 0 ? first : d;
}

/// A shift likely to be just below the smallest value: the smaller eigenvalue of the last two rows,
/// less the norm of its residual in the row above. At least two rows.
[[gnu::always_inline]] inline void qd_shift(const QdLanes& state, Lanes& shift) noexcept {
  const Eigen::Index n = state.end;
  const Lanes q_2 = state.q[n - 2].value, c = state.q[n - 1].value, e_2 = state.e[n - 2].value;
  const Lanes a = q_2 + e_2, square = c * e_2, half = (a - c) / 2, zero{};
  Lanes root = half * half + square;
  take_root(root);
  const Lanes large = (a + c) / 2 + root;
  const Lanes value = large > 0 ? q_2 * c / large : zero;
  const Lanes above = n > 2 ? state.e[n - 3].value : zero;
  const Lanes across = (a - value) * (a - value) + square;
  Lanes residual = across > 0 ? q_2 * above * square / across : zero;
  take_root(residual);
  const Lanes less = value - residual, part = value / 4;
  shift = less > part ? less : part;
}

/// Takes the smallest values off at the bottom, in all lanes together, until one row is left or the
/// lanes no longer agree on where to take off; values: the squares found, a row each. What is left
/// of every lane is a problem for qd_values.
[[gnu::always_inline]] inline void qd_together(QdLanes& state, Number* values) noexcept {
  constexpr double epsilon = std::numeric_limits<double>::epsilon();
  const Lanes zero{};
  Eigen::Index budget = 20;  // steps, a value
  while (state.end > 1 && budget > 0) {
    const Eigen::Index last = state.end - 1;
    const Lanes q = state.q[last].value, e = state.e[last - 1].value;
    const Lanes limit = epsilon * (state.taken + q);
    const auto done = (e <= limit) & (e * q <= limit * limit);
    bool all = true;
    for (Eigen::Index l = 0; l < lanes; ++l) all = all && done[l];
    if (all) {
      values[last].value = state.taken + q;
      --state.end;
      budget = 20;
      continue;
    }
    --budget;
    Lanes shift, remainder;
    qd_shift(state, shift);
    shift = done ? zero : shift;
    for (int attempt = 0;; ++attempt) {
      qd_transform(state, shift, remainder);
      bool allowed = true;
      for (Eigen::Index l = 0; l < lanes; ++l) allowed = allowed && !(remainder[l] < 0);
      if (allowed) break;
      // The remainder that failed says by how much; couplings further on may take a little more.
      const Lanes reduced = shift + 2.0 * remainder, part = shift / 4;
      const Lanes next = attempt > 2 ? Lanes{} : reduced > part ? reduced : part;
      shift = remainder < 0 ? next : shift;
    }
    state.taken += shift;
    std::swap(state.q, state.q_new);
    std::swap(state.e, state.e_new);
  }
}

}  // namespace stillframe

#pragma once

#include <cmath>

#include "core/systems/instruments.hpp"

namespace stillframe {

/// The hysteresis of Bouc and Wen with exponent 1 between a drive f and the force F that acts,
///   F = kappa f - h,   h' = alpha f' - beta |f'| h - gamma f' |h|.
/// It depends on the path of f and not on its speed, and along a path on which f keeps its
/// direction s it has a closed form: H = s h obeys dH/dp = alpha - (beta + gamma sign H) H in the
/// length p of the path. All values N. Source: Y. K. Wen, J. Eng. Mech. Div. ASCE 102 (1976)
/// 249-263. Hot: noexcept, no allocation.
struct BoucWen {
  double kappa = 1, alpha = 0;  ///< 1
  double beta = 0, gamma = 0;   ///< 1/N; -beta < gamma <= beta

  /// h once f has moved by so much in one direction.
  double moved(double h, double by) const noexcept {
    const double s = by < 0 ? -1 : 1;
    double H = s * h, p = std::abs(by);
    if (H < 0) {
      const double to_zero = length_to_zero(H);
      if (p < to_zero) return s * (H + grown(H, beta - gamma, p));
      H = 0;
      p -= to_zero;
    }
    return s * (H + grown(H, beta + gamma, p));
  }

  /// Length of path in the direction s after which s h, at present H < 0, is zero, N.
  double length_to_zero(double H) const noexcept {
    const double b = beta - gamma;
    return b == 0 ? -H / alpha : std::log1p(-b * H / alpha) / b;
  }

  /// Least slope dF/df on the closed loop between drives of minus and plus `swing`: where f has
  /// just turned back.
  double least_slope(double swing) const noexcept {
    return kappa - alpha - (beta - gamma) * end_of_loop(swing);
  }

  /// h at the end of the closed loop between minus and plus `swing`.
  double end_of_loop(double swing) const noexcept {
    // moved(-H, 2 swing) falls to H from above as H grows from 0: bisected to the last bit.
    double low = 0, high = 2 * alpha * swing;
    for (int i = 0; i < 200; ++i) {
      const double middle = 0.5 * (low + high);
      (moved(-middle, 2 * swing) > middle ? low : high) = middle;
    }
    return 0.5 * (low + high);
  }

 private:
  /// (alpha - b H) (1 - exp(-b p)) / b, by which H grows: small paths lose no digits, b may be 0.
  double grown(double H, double b, double p) const noexcept {
    const double x = b * p;
    return (alpha - b * H) * p * (x == 0 ? 1 : -std::expm1(-x) / x);
  }
};

/// The hysteresis whose closed loop between drives of minus and plus `swing_n` has its ends at F =
/// f, so that gains calibrated over the whole range hold, and opens by `width` of the range of F at
/// f = 0, where it is widest: h is in proportion to alpha, so both follow from the loop of alpha =
/// 1. Set-up.
inline BoucWen bouc_wen(const HysteresisLoop& loop) {
  BoucWen model{.kappa = 1,
                .alpha = 1,
                .beta = 1 / loop.saturation_n,
                .gamma = loop.gamma_over_beta / loop.saturation_n};
  const double end = model.end_of_loop(loop.swing_n);
  model.alpha = loop.width * loop.swing_n / model.moved(-end, loop.swing_n);
  model.kappa = 1 + model.alpha * end / loop.swing_n;
  return model;
}

}  // namespace stillframe

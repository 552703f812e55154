#include "report/spectra/windows.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/numerics/two_pi.hpp"

namespace stillframe::report {

using Eigen::Index;
using Eigen::VectorXd;

VectorXd hann(Index n) {
  const double step = two_pi / static_cast<double>(n);
  return VectorXd::NullaryExpr(
      n, [step](Index k) { return 0.5 - 0.5 * std::cos(step * static_cast<double>(k)); });
}

VectorXd hann_squared(Index n) { return hann(n).cwiseAbs2(); }

namespace {

/// Square of the transform of hann_squared over its square at 0: of sin^4 the continuous one,
/// sinc(m) 4 / ((1 - m^2) (4 - m^2)).
double lobe(double m) {
  const double pole = std::min(std::abs(m - 1), std::abs(m - 2));
  if (m == 0) return 1;
  // sinc is zero at both; 1e-6 beside them the quotient is its limit to 1e-6.
  if (pole < 1e-6) return lobe(m + 2e-6);
  const double sinc = std::sin(std::numbers::pi * m) / (std::numbers::pi * m);
  return std::pow(sinc * 4 / ((1 - m * m) * (4 - m * m)), 2);
}

constexpr double step_bins = 1.0 / 64;
constexpr int last_bins = 16;

/// beyond_lobe at multiples of step_bins: midpoints, from the far end inwards.
std::vector<double> integrate_lobe() {
  constexpr int n = static_cast<int>(last_bins / step_bins);
  // Behind last_bins sin^2 is a half on average, and the rest 16 / (pi^2 m^10).
  const double square = 35.0 / 18;  // n mean(w^2) / mean(w)^2 of sin^4
  std::vector<double> beyond(n + 1);
  beyond[n] = 8 / (std::numbers::pi * std::numbers::pi * 9 * std::pow(last_bins, 9)) / square;
  for (int i = n - 1; i >= 0; --i) {
    beyond[static_cast<std::size_t>(i)] =
        beyond[static_cast<std::size_t>(i) + 1] + step_bins * lobe((i + 0.5) * step_bins) / square;
  }
  return beyond;
}

}  // namespace

double beyond_lobe(double bins) {
  static const std::vector<double> table = integrate_lobe();
  if (bins >= last_bins) return table.back() * std::pow(last_bins / bins, 9);
  const double place = std::max(bins, 0.0) / step_bins;
  const auto below = static_cast<std::size_t>(place);
  return std::lerp(table[below], table[below + 1], place - static_cast<double>(below));
}

VectorXd blackman_harris(Index n) {
  const double step = two_pi / static_cast<double>(n);
  return VectorXd::NullaryExpr(n, [step](Index k) {
    const double phase = step * static_cast<double>(k);
    return 0.35875 - 0.48829 * std::cos(phase) + 0.14128 * std::cos(2 * phase) -
           0.01168 * std::cos(3 * phase);
  });
}

}  // namespace stillframe::report

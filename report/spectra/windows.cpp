#include "report/spectra/windows.hpp"

#include <cmath>
#include <numbers>

namespace stillframe::report {

using Eigen::Index;
using Eigen::VectorXd;

VectorXd hann(Index n) {
  const double step = 2 * std::numbers::pi / static_cast<double>(n);
  return VectorXd::NullaryExpr(
      n, [step](Index k) { return 0.5 - 0.5 * std::cos(step * static_cast<double>(k)); });
}

VectorXd blackman_harris(Index n) {
  const double step = 2 * std::numbers::pi / static_cast<double>(n);
  return VectorXd::NullaryExpr(n, [step](Index k) {
    const double phase = step * static_cast<double>(k);
    return 0.35875 - 0.48829 * std::cos(phase) + 0.14128 * std::cos(2 * phase) -
           0.01168 * std::cos(3 * phase);
  });
}

}  // namespace stillframe::report

#pragma once

#include <Eigen/Core>
#include <cmath>

namespace stillframe {

/// 20 log10 of a ratio of amplitudes.
inline double decibels(double ratio) { return 20 * std::log10(ratio); }

/// The same of each entry.
inline Eigen::MatrixXd decibels(const Eigen::MatrixXd& ratios) {
  return 20 * ratios.array().log10();
}

}  // namespace stillframe

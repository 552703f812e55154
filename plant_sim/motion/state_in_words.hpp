#pragma once

#include <Eigen/Core>
#include <cstdio>
#include <string>

namespace stillframe {

/// The largest position and velocity of a state (q, q', ...) of n dofs, for messages.
inline std::string state_in_words(const Eigen::VectorXd& y, Eigen::Index n) {
  const auto largest = [](const auto& part) {
    Eigen::Index at = 0;
    const double value = part.size() > 0 ? part.cwiseAbs().maxCoeff(&at) : 0.0;
    char text[64];
    std::snprintf(text, sizeof text, "%.4g (dof %d)", value, static_cast<int>(at) + 1);
    return std::string(text);
  };
  return "largest displacement " + largest(y.head(n)) + ", largest rate " +
         largest(y.segment(n, n));
}

}  // namespace stillframe

#include "bench/simbody/runs.hpp"

#include <cmath>

namespace stillframe::simbody {

using Eigen::Index;

Eigen::MatrixXd sines(Index inputs, Index samples, double sample_time, double amplitude,
                      double lowest_hz, double highest_hz) {
  constexpr Index lines = 7;
  const double pi = std::acos(-1.0);
  Eigen::MatrixXd a(inputs, samples);
  for (Index i = 0; i < inputs; ++i) {
    for (Index k = 0; k < samples; ++k) {
      const double t = static_cast<double>(k) * sample_time;
      double sum = 0;
      for (Index line = 0; line < lines; ++line) {
        // Frequencies that no two inputs share, and phases without a pattern.
        const double step = (static_cast<double>(line) +
                             static_cast<double>(i + 1) / static_cast<double>(inputs + 1)) /
                            lines;
        const double hz = lowest_hz * std::pow(highest_hz / lowest_hz, step);
        const auto phase = static_cast<double>((7 * i + 3 * line * line) % 11);
        sum += std::sin(2 * pi * hz * t + phase);
      }
      a(i, k) = amplitude / std::sqrt(static_cast<double>(lines)) * sum;
    }
  }
  return a;
}

double difference(const Run& a, const Run& b) {
  return (a.accelerations - b.accelerations).norm() / b.accelerations.norm();
}

}  // namespace stillframe::simbody

#include "plant_sim/floor/multisine.hpp"

#include <cmath>
#include <complex>
#include <stdexcept>

#include "core/numerics/low_crest.hpp"
#include "core/numerics/two_pi.hpp"

namespace stillframe::floor {

namespace {

/// One period-long stretch (a window) of A sum_l exp(j (phi_l + 2 pi f_l t)): all channels and
/// blocks are this signal times a slow complex factor, and a window holds whole periods of every
/// line.
Eigen::VectorXcd analytic_window(const MultisinePlan& plan) {
  const auto n_lines = static_cast<Eigen::Index>(plan.frequencies_hz.size());
  const Eigen::VectorXd phases = low_crest_phases(plan.frequencies_hz, plan.window_s / 4.0);
  const double amplitude = plan.amplitude * std::sqrt(2.0 / static_cast<double>(n_lines));
  const Eigen::Index n = plan.window_samples();
  Eigen::VectorXcd signal = Eigen::VectorXcd::Zero(n);
  for (Eigen::Index l = 0; l < n_lines; ++l) {
    // Counting cycles in a window in whole numbers keeps the phase exact however long the window
    // is.
    const auto cycles = static_cast<Eigen::Index>(
        std::llround(plan.frequencies_hz[static_cast<std::size_t>(l)] * plan.window_s));
    for (Eigen::Index k = 0; k < n; ++k) {
      const double turns = static_cast<double>((cycles * k) % n) / static_cast<double>(n);
      signal(k) += std::polar(amplitude, phases(l) + two_pi * turns);
    }
  }
  return signal;
}

/// exp(2 pi j i b / n), and zero before block 0.
std::complex<double> block_factor(Eigen::Index channel, Eigen::Index block, Eigen::Index n) {
  if (block < 0) return 0.0;
  return std::polar(1.0,
                    two_pi * static_cast<double>((channel * block) % n) / static_cast<double>(n));
}

}  // namespace

double glide(double tau) {
  if (tau <= 0.0) return 0.0;
  if (tau >= 1.0) return 1.0;
  constexpr double a0 = 0.35875, a1 = 0.48829, a2 = 0.14128, a3 = 0.01168;
  return tau - (a1 * std::sin(two_pi * tau) - a2 * std::sin(2.0 * two_pi * tau) / 2.0 +
                a3 * std::sin(3.0 * two_pi * tau) / 3.0) /
                   (two_pi * a0);
}

Eigen::MatrixXd multisine_table(const MultisinePlan& plan) {
  const auto is_whole = [&](double seconds) {
    const double samples = seconds * plan.sample_rate_hz;
    return samples > 0.5 && std::abs(samples - std::round(samples)) <= 1e-9 * samples;
  };
  if (plan.frequencies_hz.empty() || plan.n_blocks < 1 || !is_whole(plan.ramp_s) ||
      !is_whole(plan.window_s)) {
    throw std::invalid_argument(
        "multisine_table: expected lines, blocks, and whole numbers of samples in ramp and window");
  }
  const Eigen::VectorXcd signal = analytic_window(plan);
  const Eigen::Index ramp = plan.ramp_samples(), period = signal.size(), n = plan.n_blocks;
  Eigen::MatrixXd table(n, plan.n_samples());
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index b = 0; b < n; ++b) {
      const auto before = block_factor(i, b - 1, n), after = block_factor(i, b, n);
      const Eigen::Index begin = plan.window_begin(b) - ramp;
      for (Eigen::Index k = 0; k < ramp + period; ++k) {
        const double share = glide(static_cast<double>(k) / static_cast<double>(ramp));
        const auto factor = before + share * (after - before);
        table(i, begin + k) = (factor * signal((begin + k) % period)).real();
      }
    }
  }
  return table;
}

}  // namespace stillframe::floor

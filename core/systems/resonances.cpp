#include "core/systems/resonances.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

#include "core/numerics/golden_section.hpp"
#include "core/numerics/infinity.hpp"
#include "core/numerics/two_pi.hpp"

namespace stillframe {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double narrow_damping = 0.3;
/// Half-width over frequency that an undamped resonance is drawn with: its peak is as high as
/// anybody likes.
constexpr double drawn_width = 1e-3;

/// Whether a response grows without bound towards the frequency of an undamped pole.
bool has(LargestGain& gain, const Resonance& resonance) {
  return gain(resonance.hz * (1 + 1e-6)) > 1.5 * gain(resonance.hz * (1 + 2e-6));
}

/// The highest point of a response at the inner points of a grid, refined.
Peak highest_inside(const VectorXd& grid_hz, LargestGain& gain) {
  Peak highest;
  Index at = 0;
  for (Index i = 1; i + 1 < grid_hz.size(); ++i) {
    const double value = gain(grid_hz(i));
    if (!(value > highest.value)) continue;
    highest = {grid_hz(i), value};
    at = i;
  }
  if (at == 0) return highest;
  // 0.618^24 of a bracket of half a half-width: to 1e-5 of that, and of second order in it.
  const auto [hz, value] = golden_section(gain, grid_hz(at - 1), grid_hz(at + 1), 24);
  return value > highest.value ? Peak{hz, value} : highest;
}

}  // namespace

std::vector<Resonance> resonances(const Eigen::VectorXcd& poles) {
  std::vector<Resonance> found;
  for (const Complex s : poles) {
    const bool narrow = s.imag() > 0 && std::abs(s.real()) < narrow_damping * std::abs(s);
    if (narrow) found.push_back({s.imag() / two_pi, std::abs(s.real()) / two_pi});
  }
  std::sort(found.begin(), found.end(),
            [](const Resonance& a, const Resonance& b) { return a.hz < b.hz; });
  return found;
}

std::vector<Resonance> resonances(const Eigen::VectorXcd& poles, double sample_time) {
  Eigen::VectorXcd continuous = Eigen::VectorXcd::Zero(poles.size());
  for (Index i = 0; i < poles.size(); ++i) {
    // What is gone after one sample rings no more.
    if (std::abs(poles(i)) > 1e-12) continuous(i) = std::log(poles(i)) / sample_time;
  }
  return resonances(continuous);
}

VectorXd with_resonances(const VectorXd& grid_hz, const std::vector<Resonance>& resonances) {
  const double lowest = grid_hz(0), highest = grid_hz(grid_hz.size() - 1);
  std::vector<double> all(grid_hz.begin(), grid_hz.end());
  const auto add = [&](double hz) {
    if (hz > lowest && hz < highest) all.push_back(hz);
  };
  for (const Resonance& resonance : resonances) {
    const double width =
        resonance.undamped() ? drawn_width * resonance.hz : resonance.half_width_hz;
    if (!resonance.undamped()) add(resonance.hz);
    const auto next = std::upper_bound(grid_hz.begin(), grid_hz.end(), resonance.hz);
    if (next == grid_hz.begin() || next == grid_hz.end()) continue;
    const double step = *next - *(next - 1);
    for (double offset = width / 4; offset < step;
         offset = offset < width ? offset + width / 4 : 1.6 * offset) {
      add(resonance.hz - offset);
      add(resonance.hz + offset);
    }
  }
  std::sort(all.begin(), all.end());
  // Legs that are alike have poles that are.
  const auto same = [](double a, double b) { return b - a < 1e-9 * b; };
  all.erase(std::unique(all.begin(), all.end(), same), all.end());
  return Eigen::Map<VectorXd>(all.data(), static_cast<Index>(all.size()));
}

LargestGain::LargestGain(const StateSpace& system, double sample_time)
    : sweep_(system),
      decomposition_(sweep_.n_outputs(), sweep_.n_inputs()),
      sample_time_(sample_time),
      G_(sweep_.n_outputs(), sweep_.n_inputs()),
      resonances_(sample_time > 0 ? stillframe::resonances(sweep_.poles(), sample_time)
                                  : stillframe::resonances(sweep_.poles())) {}

LargestGain::LargestGain(const StateSpace& system) : LargestGain(system, 0) {}

LargestGain::LargestGain(const LinearSystem& system, Index n_inputs)
    : LargestGain(proper_system(
          {system.A, system.B.leftCols(n_inputs), system.C, system.D.leftCols(n_inputs)})) {}

LargestGain::LargestGain(const SampledLoop& loop)
    : LargestGain(proper_system({loop.A, loop.B, loop.C, loop.D}), loop.sample_time) {}

double LargestGain::operator()(double hz) {
  const double omega = two_pi * hz;
  sweep_.evaluate(sample_time_ > 0 ? std::polar(1.0, omega * sample_time_) : Complex(0, omega), G_);
  VectorXd values(std::min(G_.rows(), G_.cols()));
  decomposition_.compute(&G_, 1, values);
  return values(0);
}

std::vector<Peak> peaks_between(const VectorXd& rows_hz, LargestGain& gain) {
  constexpr Index n_inside = 8;
  const double missed = std::pow(10, 1.0 / 20);
  std::vector<Peak> peaks;
  for (Index i = 0; i + 1 < rows_hz.size(); ++i) {
    const double from = rows_hz(i), to = rows_hz(i + 1);
    const VectorXd even =
        VectorXd::LinSpaced(n_inside + 2, std::log(from), std::log(to)).array().exp();
    Peak highest = highest_inside(with_resonances(even, gain.resonances()), gain);
    for (const Resonance& resonance : gain.resonances()) {
      const bool inside = resonance.hz > from && resonance.hz < to;
      if (!inside || !resonance.undamped() || !has(gain, resonance)) continue;
      highest = {resonance.hz, infinity};
    }
    const double beside = std::max(gain(from), gain(to));
    if (highest.value > missed * beside) peaks.push_back(highest);
  }
  return peaks;
}

}  // namespace stillframe

#include "core/numerics/low_crest.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <numeric>

#include "core/numerics/two_pi.hpp"
#include "kissfft/kissfft.hh"

namespace stillframe {

namespace {

/// Clips z at a share of its largest modulus, which is returned.
double clip_envelope(std::vector<std::complex<double>>& z, double share) {
  double peak = 0.0;
  for (const auto& value : z) peak = std::max(peak, std::abs(value));
  const double limit = share * peak;
  for (auto& value : z) {
    const double modulus = std::abs(value);
    if (modulus > limit) value *= limit / modulus;
  }
  return peak;
}

}  // namespace

Eigen::VectorXd schroeder_phases(const std::vector<double>& frequencies_hz, double period) {
  const auto n = static_cast<Eigen::Index>(frequencies_hz.size());
  Eigen::VectorXd phases = Eigen::VectorXd::Zero(n);
  for (Eigen::Index l = 0; l + 1 < n; ++l) {
    const auto i = static_cast<std::size_t>(l);
    const double delay = period * static_cast<double>(l + 1) / static_cast<double>(n);
    phases(l + 1) = std::remainder(
        phases(l) - two_pi * (frequencies_hz[i + 1] - frequencies_hz[i]) * delay, two_pi);
  }
  return phases;
}

Eigen::VectorXd low_crest_phases(const std::vector<double>& frequencies_hz, double period,
                                 std::size_t points) {
  if (frequencies_hz.size() < 2) return schroeder_phases(frequencies_hz, period);
  std::vector<std::size_t> bins;
  std::size_t divisor = 0;
  for (const double f : frequencies_hz) {
    bins.push_back(static_cast<std::size_t>(std::llround(f * period)));
    divisor = std::gcd(divisor, bins.back());
  }
  // The lines may repeat sooner than the period that was asked for.
  for (auto& bin : bins) bin /= divisor;
  Eigen::VectorXd phases = schroeder_phases(frequencies_hz, period / static_cast<double>(divisor));

  // Clipping at 0.8 of the peak settles within a thousand rounds, which longer signals than one is
  // likely to want do not get; four points a period of the highest line are enough to see the
  // envelope.
  constexpr double share = 0.8;
  const std::size_t n = std::bit_ceil(4 * bins.back());
  const std::size_t rounds = std::clamp<std::size_t>(points / n, 1, 1000);
  const kissfft<double> to_time(n, true), to_lines(n, false);
  std::vector<std::complex<double>> lines(n), signal(n);

  Eigen::VectorXd best = phases;
  double lowest = static_cast<double>(2 * bins.size());  // above any peak
  for (std::size_t round = 0; round < rounds; ++round) {
    std::fill(lines.begin(), lines.end(), 0.0);
    for (std::size_t l = 0; l < bins.size(); ++l) {
      lines[bins[l]] = std::polar(1.0, phases(static_cast<Eigen::Index>(l)));
    }
    to_time.transform(lines.data(), signal.data());
    const double peak = clip_envelope(signal, share);
    if (peak < lowest) {
      lowest = peak;
      best = phases;
    }
    to_lines.transform(signal.data(), lines.data());
    for (std::size_t l = 0; l < bins.size(); ++l) {
      phases(static_cast<Eigen::Index>(l)) = std::arg(lines[bins[l]]);
    }
  }
  return best;
}

}  // namespace stillframe

#include "report/page/thin_spectrum.hpp"

#include <algorithm>
#include <cmath>

namespace stillframe::page {

namespace {

/// The values at positive frequencies.
Curve positive_part(const Curve& curve) {
  Curve part{.name = curve.name, .frequencies_hz = {}, .values = {}};
  for (std::size_t i = 0; i < curve.frequencies_hz.size(); ++i) {
    if (!(curve.frequencies_hz[i] > 0) || !std::isfinite(curve.values[i])) continue;
    part.frequencies_hz.push_back(curve.frequencies_hz[i]);
    part.values.push_back(curve.values[i]);
  }
  return part;
}

/// Calls keep(first, last) for the range of points of each step.
template <class Keep>
void for_each_step(const Curve& curve, std::size_t n_steps, Keep keep) {
  const auto& f = curve.frequencies_hz;
  const double low = std::log(f.front()), width = std::log(f.back()) - low;
  const auto step_of = [&](std::size_t i) {
    const double place = (std::log(f[i]) - low) / width * static_cast<double>(n_steps);
    return std::min(static_cast<std::size_t>(place), n_steps - 1);
  };
  for (std::size_t first = 0; first < f.size();) {
    std::size_t last = first;
    while (last + 1 < f.size() && step_of(last + 1) == step_of(first)) ++last;
    keep(first, last);
    first = last + 1;
  }
}

}  // namespace

Curve thin_spectrum(const Curve& spectrum, std::size_t n_steps) {
  const Curve all = positive_part(spectrum);
  if (all.frequencies_hz.size() <= 2 * n_steps) return all;
  Curve thin{.name = spectrum.name, .frequencies_hz = {}, .values = {}};
  const auto keep_point = [&](std::size_t i) {
    thin.frequencies_hz.push_back(all.frequencies_hz[i]);
    thin.values.push_back(all.values[i]);
  };
  for_each_step(all, n_steps, [&](std::size_t first, std::size_t last) {
    const auto begin = all.values.begin();
    const auto [lowest, highest] = std::minmax_element(
        begin + static_cast<std::ptrdiff_t>(first), begin + static_cast<std::ptrdiff_t>(last) + 1);
    const auto a = static_cast<std::size_t>(lowest - begin),
               b = static_cast<std::size_t>(highest - begin);
    keep_point(std::min(a, b));
    if (a != b) keep_point(std::max(a, b));
  });
  return thin;
}

Curve thin_cumulative(const Curve& curve, std::size_t n_steps) {
  const Curve all = positive_part(curve);
  if (all.frequencies_hz.size() <= n_steps) return all;
  Curve thin{.name = curve.name, .frequencies_hz = {}, .values = {}};
  for_each_step(all, n_steps, [&](std::size_t, std::size_t last) {
    thin.frequencies_hz.push_back(all.frequencies_hz[last]);
    thin.values.push_back(all.values[last]);
  });
  return thin;
}

}  // namespace stillframe::page

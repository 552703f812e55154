#include "core/control/design/price_of_sampling.hpp"

#include <algorithm>
#include <cmath>

#include "core/mechanics/frequency_response.hpp"
#include "core/numerics/decibels.hpp"
#include "core/numerics/infinity.hpp"
#include "core/numerics/two_pi.hpp"

namespace stillframe {

double price_of_sampling(const ControlLoop& loop, double target, const LoopSettings& settings) {
  ControlLoop ideal = loop;
  ideal.gains.roll_off = 0;
  const SampledLoop sampled = close_loop(settings);
  const double to = std::min(4 * target, 0.49 / sampled.sample_time);
  double price = -infinity;
  for (const double hz : logarithmic_frequencies(target / 4, to, 15)) {
    const double without = singular_values(ideal.closed({0, two_pi * hz}))(0);
    const double real = singular_values(transfer(sampled, two_pi * hz))(0);
    const double excess = decibels(real / without);
    if (!(excess <= price)) price = excess;
    if (std::isnan(price)) break;
  }
  return price;
}

}  // namespace stillframe

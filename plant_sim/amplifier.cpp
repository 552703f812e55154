#include "plant_sim/amplifier.hpp"

#include <stdexcept>

#include "core/numerics/smooth_step.hpp"

namespace stillframe {

Amplifier::Amplifier(std::int64_t hold_samples, double fade_s, double sample_time)
    : hold_samples_(hold_samples), sample_time_(sample_time), fade_s_(fade_s) {
  if (hold_samples < 0 || !(fade_s > 0) || !(sample_time > 0)) {
    throw std::invalid_argument("Amplifier: a hold of 0 samples or more and times above 0");
  }
}

double Amplifier::part(std::int64_t n_samples) const noexcept {
  if (n_samples <= hold_samples_) return 1;
  return 1 - smooth_step(static_cast<double>(n_samples - hold_samples_) * sample_time_ / fade_s_);
}

}  // namespace stillframe

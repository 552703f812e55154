#include "plant_sim/floor/block_values.hpp"

#include <cmath>

#include "core/errors/formatted.hpp"

namespace stillframe::floor {

std::string text_of(double value) { return formatted("%.12g", value); }

double read_high_pass(const YamlReader& block, double sample_rate_hz, double otherwise) {
  const auto value = block.find("high_pass_hz");
  const double corner = value ? value->positive() : otherwise;
  if (!(corner < 0.5 * sample_rate_hz)) {
    const std::string message = "found " + text_of(corner) + ", allowed is a number below " +
                                text_of(0.5 * sample_rate_hz) + ", half the control rate";
    value ? value->fail(message) : block.fail("high_pass_hz (default): " + message);
  }
  return corner;
}

std::int64_t read_duration(const YamlReader& block, double sample_rate_hz, Eigen::Index channels) {
  const YamlReader value = block.require("duration_s");
  const double samples = std::round(value.positive() * sample_rate_hz);
  const double most = std::floor(most_values / static_cast<double>(channels));
  if (samples < 1.0 || samples > most) {
    value.fail("found " + text_of(value.number()) + ", allowed is from " +
               text_of(1.0 / sample_rate_hz) + " (one sample) to " +
               text_of(most / sample_rate_hz));
  }
  return static_cast<std::int64_t>(samples);
}

std::int64_t read_length(const YamlReader& block, double sample_rate_hz, double otherwise) {
  const auto value = block.find("duration_s");
  const double seconds = value ? value->positive() : otherwise;
  const double samples = std::ceil(seconds * sample_rate_hz);
  if (!(samples >= 1.0 && samples <= most_samples)) {
    const std::string message = "found " + text_of(seconds) + ", allowed is from one sample to " +
                                text_of(most_samples / sample_rate_hz);
    value ? value->fail(message) : block.fail("duration_s (default): " + message);
  }
  return static_cast<std::int64_t>(samples);
}

double read_below_half_rate(const YamlReader& value, double sample_rate_hz) {
  const double frequency = value.positive();
  if (!(frequency < 0.5 * sample_rate_hz)) {
    value.fail("found " + value.text() + ", allowed is a frequency below " +
               text_of(0.5 * sample_rate_hz) + " Hz, half the control rate");
  }
  return frequency;
}

}  // namespace stillframe::floor

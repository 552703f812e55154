#pragma once

#include <cstdint>
#include <string>

#include "core/yaml/reader.hpp"

// Values that several kinds of floor block have, and their bounds. All throw InputError.
namespace stillframe::floor {

/// Values of one table: 0.8 GB, more than any sensible run needs, and less than what brings a
/// machine down.
inline constexpr double most_values = 1e8;
/// Samples of a source without a table: a year at 1 MHz.
inline constexpr double most_samples = 3e13;

/// The value of a key if it is there.
template <typename T>
T value_or(const YamlReader& block, const std::string& key, T otherwise,
           T (YamlReader::*read)() const) {
  const auto value = block.find(key);
  return value ? ((*value).*read)() : otherwise;
}

/// A number as messages show it, with twelve digits at the most.
std::string text_of(double value);

/// Key high_pass_hz: a corner (Hz) below half the rate.
double read_high_pass(const YamlReader& block, double sample_rate_hz, double otherwise = 0.5);

/// Key duration_s of a table of so many channels, in samples.
std::int64_t read_duration(const YamlReader& block, double sample_rate_hz, Eigen::Index channels);

/// Key duration_s of a source without a table, otherwise (s) without it; in samples, rounded up.
std::int64_t read_length(const YamlReader& block, double sample_rate_hz, double otherwise);

/// A frequency (Hz) above 0, below half the rate.
double read_below_half_rate(const YamlReader& value, double sample_rate_hz);

}  // namespace stillframe::floor

#include "core/yaml/instruments_block.hpp"

#include <cstdint>

namespace stillframe {

namespace {

/// More is a mistake rather than an instrument.
constexpr std::int64_t most_age = 100;

}  // namespace

Instruments read_instruments(const YamlReader& block) {
  block.allow_only({"actuator_gain", "actuator_lag_hz", "sensor_filter_hz", "applied_force",
                    "report_age_samples"});
  Instruments instruments;
  if (const auto value = block.find("actuator_gain")) {
    instruments.actuator_gain = value->positive();
  }
  if (const auto value = block.find("actuator_lag_hz")) {
    instruments.actuator_lag_hz = value->positive();
  }
  if (const auto value = block.find("sensor_filter_hz")) {
    instruments.sensor_filter_hz = value->positive();
  }
  if (const auto value = block.find("applied_force")) {
    instruments.report = value->one_of({"measured", "commanded"}) == "measured"
                             ? Instruments::Report::measured
                             : Instruments::Report::commanded;
  }
  if (const auto value = block.find("report_age_samples")) {
    const std::int64_t age = value->integer(0);
    if (age > most_age) {
      value->fail("found " + value->text() + ", allowed is 0 to " + std::to_string(most_age));
    }
    instruments.report_age_samples = static_cast<int>(age);
  }
  return instruments;
}

}  // namespace stillframe

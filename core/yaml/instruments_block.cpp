#include "core/yaml/instruments_block.hpp"

#include <cstdint>

#include "core/systems/bouc_wen.hpp"
#include "core/yaml/loop_numbers.hpp"
#include "core/yaml/ranges.hpp"

namespace stillframe {

namespace {

Instruments read_linear(const YamlReader& block) {
  Instruments instruments;
  if (const auto value = block.find("actuator_gain")) {
    instruments.actuator_gain = number_within(*value, 1e-3, 1e3);
  }
  if (const auto value = block.find("actuator_lag_hz")) {
    instruments.actuator_lag_hz = positive_up_to(*value, highest_hz);
  }
  if (const auto value = block.find("sensor_filter_hz")) {
    instruments.sensor_filter_hz = positive_up_to(*value, highest_hz);
  }
  if (const auto value = block.find("applied_force")) {
    instruments.report = value->one_of({"measured", "commanded"}) == "measured"
                             ? Instruments::Report::measured
                             : Instruments::Report::commanded;
  }
  if (const auto value = block.find("report_age_samples")) {
    instruments.report_age_samples =
        static_cast<int>(integer_within(*value, 0, longest_delay_samples));
  }
  return instruments;
}

/// One number for all legs, or one for each.
std::vector<double> read_per_leg(const YamlReader& value, int n_legs) {
  if (!value.is_sequence()) return {value.number()};
  std::vector<double> numbers;
  for (const YamlReader& item : value.items()) numbers.push_back(item.number());
  if (n_legs >= 0 && numbers.size() != static_cast<size_t>(n_legs)) {
    value.fail("found " + std::to_string(numbers.size()) +
               " numbers, allowed are one, or one for each of the " + std::to_string(n_legs) +
               " legs");
  }
  return numbers;
}

HysteresisLoop read_hysteresis(const YamlReader& block) {
  block.allow_only({"width", "swing_n", "saturation_n", "gamma_over_beta"});
  HysteresisLoop loop;
  const YamlReader width = block.require("width");
  loop.width = width.positive();
  loop.swing_n = block.require("swing_n").positive();
  loop.saturation_n = loop.swing_n;
  if (const auto value = block.find("saturation_n")) loop.saturation_n = value->positive();
  if (const auto value = block.find("gamma_over_beta")) {
    loop.gamma_over_beta = value->number();
    if (loop.gamma_over_beta <= -1 || loop.gamma_over_beta > 1) {
      value->fail("found " + value->text() + ", allowed is above -1 up to 1");
    }
  }
  if (!(bouc_wen(loop).least_slope(loop.swing_n) > 0)) {
    width.fail("found " + width.text() +
               ": so wide a loop of this saturation_n would turn back on itself; allowed is less, "
               "or a larger saturation_n");
  }
  return loop;
}

std::uint64_t read_seed(const YamlReader& block) {
  const auto value = block.find("seed");
  return value ? static_cast<std::uint64_t>(value->integer(0)) : 1;
}

ForceSensorErrors read_force_sensors(const YamlReader& block, int n_legs) {
  block.allow_only({"noise_n_per_sqrt_hz", "flicker_below_hz", "offset_n", "drift_n_per_s",
                    "random_walk_n_per_sqrt_s", "range_n", "quantisation_n", "seed"});
  ForceSensorErrors errors;
  if (const auto value = block.find("noise_n_per_sqrt_hz")) errors.noise = value->non_negative();
  if (const auto value = block.find("flicker_below_hz")) {
    errors.flicker_below_hz = value->positive();
    if (errors.noise == 0) value->fail("needs noise_n_per_sqrt_hz, which it rises above");
  }
  if (const auto value = block.find("offset_n")) errors.offset = read_per_leg(*value, n_legs);
  if (const auto value = block.find("drift_n_per_s")) errors.drift = read_per_leg(*value, n_legs);
  if (const auto value = block.find("random_walk_n_per_sqrt_s")) {
    errors.random_walk = value->non_negative();
  }
  if (const auto value = block.find("range_n")) errors.range = value->positive();
  if (const auto value = block.find("quantisation_n")) {
    errors.quantisation = value->positive();
    if (errors.quantisation > errors.range) {
      value->fail("found " + value->text() + ", allowed is up to range_n");
    }
  }
  errors.seed = read_seed(block);
  return errors;
}

FloorSensorErrors read_floor_sensors(const YamlReader& block) {
  block.allow_only({"noise", "seed"});
  return {.noise = block.require("noise").non_negative(), .seed = read_seed(block)};
}

}  // namespace

Instruments read_instruments(const YamlReader& block) {
  block.allow_only({"actuator_gain", "actuator_lag_hz", "sensor_filter_hz", "applied_force",
                    "report_age_samples"});
  return read_linear(block);
}

Instruments read_scene_instruments(const YamlReader& block, int n_legs) {
  block.allow_only({"actuator_gain", "actuator_lag_hz", "sensor_filter_hz", "applied_force",
                    "report_age_samples", "force_rate_limit_n_per_s", "hysteresis", "force_sensors",
                    "floor_sensors"});
  Instruments instruments = read_linear(block);
  if (const auto value = block.find("force_rate_limit_n_per_s")) {
    instruments.force_rate_limit = value->positive();
  }
  if (const auto map = block.find("hysteresis")) instruments.hysteresis = read_hysteresis(*map);
  if (const auto map = block.find("force_sensors")) {
    instruments.force_sensors = read_force_sensors(*map, n_legs);
  }
  if (const auto map = block.find("floor_sensors")) {
    instruments.floor_sensors = read_floor_sensors(*map);
  }
  return instruments;
}

}  // namespace stillframe

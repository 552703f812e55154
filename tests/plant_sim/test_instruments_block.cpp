#include <gtest/gtest.h>

#include <string>

#include "core/yaml/instruments_block.hpp"

// The block of instruments as a scene has it, and what its reader refuses.
namespace stillframe {
namespace {

Instruments read(const std::string& text, int n_legs = 2) {
  return read_scene_instruments(YamlReader::from_text(text, "block.yaml"), n_legs);
}

TEST(InstrumentsBlock, SetsWhatItNamesAndNothingElse) {
  const Instruments none = read("{actuator_gain: 1.5}");
  EXPECT_FALSE(none.hysteresis || none.force_sensors || none.floor_sensors);
  EXPECT_EQ(none.force_rate_limit, std::numeric_limits<double>::infinity());
  const Instruments all = read(R"(
force_rate_limit_n_per_s: 2
hysteresis: {width: 0.1, swing_n: 3}
force_sensors: {noise_n_per_sqrt_hz: 4, flicker_below_hz: 5, offset_n: [6, 7], drift_n_per_s: 8,
  random_walk_n_per_sqrt_s: 9, range_n: 10, quantisation_n: 0.5, seed: 11}
floor_sensors: {noise: 12, seed: 13}
)");
  EXPECT_EQ(all.force_rate_limit, 2);
  ASSERT_TRUE(all.hysteresis && all.force_sensors && all.floor_sensors);
  EXPECT_EQ(all.hysteresis->width, 0.1);
  EXPECT_EQ(all.hysteresis->swing_n, 3);
  EXPECT_EQ(all.hysteresis->saturation_n, 3);  // unless it is named
  EXPECT_EQ(all.hysteresis->gamma_over_beta, 0);
  const ForceSensorErrors& sensors = *all.force_sensors;
  EXPECT_EQ(sensors.noise, 4);
  EXPECT_EQ(sensors.flicker_below_hz, 5);
  EXPECT_EQ(sensors.offset, (std::vector<double>{6, 7}));
  EXPECT_EQ(sensors.drift, std::vector<double>{8});
  EXPECT_EQ(sensors.random_walk, 9);
  EXPECT_EQ(sensors.range, 10);
  EXPECT_EQ(sensors.quantisation, 0.5);
  EXPECT_EQ(sensors.seed, 11u);
  EXPECT_EQ(all.floor_sensors->noise, 12);
  EXPECT_EQ(all.floor_sensors->seed, 13u);
  // The analysis does not count them.
  EXPECT_TRUE(all.ideal());
}

TEST(InstrumentsBlock, RefusesWithPlaceKeyAndReason) {
  const struct {
    const char *text, *message;
  } cases[] = {
      {"{force_rate_limit_n_per_s: 0}", "block.yaml:1:28: force_rate_limit_n_per_s"},
      {"{hysteresis: {swing_n: 1}}", "width"},
      {"{hysteresis: {width: 0.1}}", "swing_n"},
      {"{hysteresis: {width: 0.1, swing_n: 1, beta: 1}}", "beta"},
      {"{hysteresis: {width: 0.4, swing_n: 1}}", "found 0.4: so wide a loop"},
      {"{hysteresis: {width: 0.1, swing_n: 1, saturation_n: 0.05}}", "so wide a loop"},
      {"{hysteresis: {width: 0.1, swing_n: 1, gamma_over_beta: -1}}", "above -1 up to 1"},
      {"{force_sensors: {flicker_below_hz: 1}}", "needs noise_n_per_sqrt_hz"},
      {"{force_sensors: {noise_n_per_sqrt_hz: -1}}", "noise_n_per_sqrt_hz"},
      {"{force_sensors: {offset_n: [1, 2, 3]}}", "one for each of the 2 legs"},
      {"{force_sensors: {range_n: 1, quantisation_n: 2}}", "up to range_n"},
      {"{force_sensors: {seed: -1}}", "seed"},
      {"{floor_sensors: {seed: 1}}", "noise"},
  };
  for (const auto& [text, message] : cases) {
    try {
      read(text);
      ADD_FAILURE() << text << " was accepted";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(message), std::string::npos)
          << text << ": " << error.what();
    }
  }
  // The bound on the width is where the loop turns back.
  EXPECT_NO_THROW(read("{hysteresis: {width: 0.34, swing_n: 1}}"));
  // A gains file says what the analysis counts.
  EXPECT_THROW(
      read_instruments(YamlReader::from_text("{force_rate_limit_n_per_s: 1}", "gains.yaml")),
      InputError);
}

}  // namespace
}  // namespace stillframe

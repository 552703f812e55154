#include <gtest/gtest.h>

#include "core/yaml/reader.hpp"
#include "plant_sim/run_length.hpp"
#include "tests/plant_sim/frame.hpp"

namespace stillframe {
namespace {

floor::FloorSpec spec(const std::string& text) {
  return floor::read_floor_block(YamlReader::from_text(text, "floor.yaml"), 1000, 6);
}

TEST(RunLength, TheSceneSaysItForARecording) {
  const Scene scene = test::frame_scene();  // duration_s: 60
  const auto recording = spec("recording: {file: a.csv, axes: {a: x}}");
  EXPECT_EQ(run_length(scene, recording, 390001, std::nullopt), 60001);
  EXPECT_EQ(run_length(scene, recording, 390001, 2.5), 2501);
  EXPECT_THROW(run_length(scene, recording, 50000, std::nullopt), InputError);
}

TEST(RunLength, OtherFloorsSayItThemselves) {
  const Scene scene = test::frame_scene();
  const auto still = spec("still: {duration_s: 3}");
  EXPECT_EQ(run_length(scene, still, 3000, std::nullopt), 3001);
  EXPECT_THROW(run_length(scene, still, 3000, 4.0), InputError);
}

std::string refused(const floor::FloorSpec& floor, std::optional<double> duration_s) {
  try {
    Scene scene = test::frame_scene();
    scene.file = "frame.yaml";
    run_length(scene, floor, 50000, duration_s);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(RunLength, IsNamedAfterWhoAskedForIt) {
  const auto recording = spec("recording: {file: a.csv, axes: {a: x}}");
  const std::string allowed =
      " s, allowed is from 0.001 s, one sample, to 50 s, the length of the floor";
  EXPECT_EQ(refused(recording, std::nullopt),
            "frame.yaml: simulation.duration_s: found 60" + allowed);
  EXPECT_EQ(refused(recording, 4e-4), "--duration: found 0.0004" + allowed);
  EXPECT_EQ(refused(recording, 1e300), "--duration: found 1e+300" + allowed);
}

}  // namespace
}  // namespace stillframe

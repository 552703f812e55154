#include <gtest/gtest.h>

#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "core/certificate.hpp"
#include "core/scene/scene_reader.hpp"
#include "tests/core/scenes.hpp"

namespace stillframe::test {
namespace {

std::vector<std::string> scene_files() {
  std::vector<std::string> names;
  for (const auto& entry :
       std::filesystem::directory_iterator(STILLFRAME_SOURCE_DIR "/config/scenes")) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem());
  }
  std::sort(names.begin(), names.end());
  return names;
}

void expect_certified(const Scene& scene) {
  for (const BlockCertificate& block : certify(scene)) {
    std::cout << scene.title << ": " << block.block << " " << block.difference << " of "
              << block.size << "\n";
    // The number. Extrapolated differences over a hundredth of the scene's size reach 1e-11
    // where forces of stiff elements cancel, and 1e-13 elsewhere.
    EXPECT_LE(block.difference, 1e-9) << block.block;
  }
}

class Certificate : public testing::TestWithParam<std::string> {};

TEST_P(Certificate, EveryBlockIsTheDerivativeOfTheNonlinearEquations) {
  expect_certified(read_scene(STILLFRAME_SOURCE_DIR "/config/scenes/" + GetParam() + ".yaml"));
}

INSTANTIATE_TEST_SUITE_P(Scenes, Certificate, testing::ValuesIn(scene_files()),
                         [](const auto& param) { return param.param; });

TEST(Certificates, CoverTenScenesAndThreeInMotion) {
  EXPECT_GE(scene_files().size(), 10u);
  for (const char* name : {"turning_table", "spinning_arm", "free_body", "slider_crank"}) {
    double C = 0, N = 0;
    for (const auto& block : certify(
             read_scene(std::string(STILLFRAME_SOURCE_DIR "/config/scenes/") + name + ".yaml"))) {
      if (block.block == "C") C = block.size;
      if (block.block == "N") N = block.size;
    }
    EXPECT_GT(C, 0) << name;
    EXPECT_GT(N, 0) << name;
  }
}

TEST(Certificates, HoldForTheScenesOfTheTests) {
  Scene frame = preloaded_frame();
  use_all_signals_of_frame(frame);
  expect_certified(frame);
  Scene linkage = mechanism();
  use_all_signals_of_mechanism(linkage);
  expect_certified(linkage);
}

}  // namespace
}  // namespace stillframe::test

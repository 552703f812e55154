#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "core/errors/input_error.hpp"
#include "core/mechanics/linearisation/linearisation.hpp"
#include "core/mechanics/model/model.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "tests/core/bad_elements.hpp"
#include "tests/core/bad_motions.hpp"
#include "tests/core/bad_planar_scenes.hpp"
#include "tests/core/bad_scenes.hpp"

namespace stillframe::test {
namespace {

/// Everything that is done with a scene before it moves.
void read_and_model(const std::string& text) {
  const Scene scene = parse_scene(text, "swing.yaml");
  const Model model = make_model(scene);
  linearise(model, scene.inputs, scene.outputs);
}

/// "swing.yaml:line:column: " of the first occurrence of `what`.
std::string place_of(const std::string& what, const std::string& text) {
  const size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  const auto line =
      1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
  const size_t start = text.rfind('\n', at);  // before the first line: npos, which is -1
  return "swing.yaml:" + std::to_string(line) + ":" + std::to_string(at - start) + ": ";
}

std::string error_of(const std::string& text) {
  try {
    read_and_model(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(SoundScene, IsAccepted) {
  EXPECT_EQ(error_of(sound_scene), "");
  EXPECT_EQ(error_of(sound_crane), "");
  EXPECT_EQ(error_of(sound_crank), "");
}

void expect_message(const std::string& sound, const BadScene& bad) {
  ASSERT_NE(sound.find(bad.from), std::string::npos) << "the table is wrong: " << bad.from;
  const std::string text = changed(sound, bad.from, bad.to), message = error_of(text);
  ASSERT_NE(message, "") << "accepted";
  if (!bad.at.empty()) {
    EXPECT_TRUE(message.starts_with(place_of(bad.at, text))) << message;
  }
  for (const std::string& part : bad.parts) {
    EXPECT_NE(message.find(part), std::string::npos)
        << "message: " << message << "\nlacks:   " << part;
  }
  EXPECT_EQ(message.find('\n'), std::string::npos) << "one line: " << message;
}

std::string name_of(const testing::TestParamInfo<BadScene>& info) { return info.param.name; }

class SceneErrors : public testing::TestWithParam<BadScene> {};
class ElementErrors : public SceneErrors {};
class MotionErrors : public SceneErrors {};
class PlanarErrors : public SceneErrors {};

TEST_P(SceneErrors, SayWhereWhatAndHow) { expect_message(sound_scene, GetParam()); }
TEST_P(ElementErrors, SayWhereWhatAndHow) { expect_message(sound_crane, GetParam()); }
TEST_P(MotionErrors, SayWhereWhatAndHow) { expect_message(sound_crane, GetParam()); }
TEST_P(PlanarErrors, SayWhereWhatAndHow) { expect_message(sound_crank, GetParam()); }

INSTANTIATE_TEST_SUITE_P(Table, SceneErrors, testing::ValuesIn(bad_scenes), name_of);
INSTANTIATE_TEST_SUITE_P(Table, ElementErrors, testing::ValuesIn(bad_elements), name_of);
INSTANTIATE_TEST_SUITE_P(Table, MotionErrors, testing::ValuesIn(bad_motions), name_of);
INSTANTIATE_TEST_SUITE_P(Table, PlanarErrors, testing::ValuesIn(bad_planar_scenes), name_of);

/// A scene without a dependent coordinate has no condition to factorise.
TEST(Partition, WithoutDependentCoordinatesIsSoundOrSaysWhatIsTooMuch) {
  const std::string alone = R"(title: Mass
nodes:
  m: {position: [0, 0, 0]}
  wall: {position: [1, 0, 0]}
masses:
  - {node: m, mass: 1}
elements:
  spring: {type: truss, nodes: [m, wall], STIFFNESS}
supports:
  - {nodes: [wall], fix: [x, y, z]}
  - {nodes: [m], fix: [y, z]}
dofs:
  - {node: m, along: x}
)";
  EXPECT_EQ(error_of(changed(alone, "STIFFNESS", "stiffness: 5")), "");
  const std::string message = error_of(changed(alone, "STIFFNESS", "rigid: true"));
  EXPECT_NE(message.find("1 too many"), std::string::npos) << message;
  EXPECT_NE(message.find("'spring'"), std::string::npos) << message;
}

}  // namespace
}  // namespace stillframe::test

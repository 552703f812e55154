#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/errors/input_error.hpp"
#include "core/mechanics/model/model.hpp"
#include "core/mechanics/scene/scene_reader.hpp"

// Partitions of beams and hinges that cannot work: the message says which elements or nodes, and
// what to release or add.
namespace stillframe::test {
namespace {

const std::string beams = R"(title: Portal
planar: true
nodes:
  left: {position: [0, 0]}
  corner: {position: [0, 1]}
  right: {position: [1, 1]}
  foot: {position: [1, 0]}
masses: []
elements:
  post: {type: beam, nodes: [left, corner], EA: 1e4, EI: 1, mass_per_length: 1}
  lintel: {type: beam, nodes: [corner, right], EA: 1e4, EI: 1, mass_per_length: 1}
  stay: {type: truss, nodes: [right, foot], rigid: true}
)";

struct Bad {
  const char* name;
  std::string rest;
  std::vector<std::string> parts;
};
void PrintTo(const Bad& bad, std::ostream* out) { *out << bad.name; }

class PartitionErrors : public testing::TestWithParam<Bad> {};

TEST_P(PartitionErrors, IsRefusedWithWhatMovesOrWhatIsTooMuch) {
  try {
    make_model(parse_scene(beams + GetParam().rest, "portal"));
    FAIL() << "no InputError";
  } catch (const InputError& error) {
    for (const std::string& part : GetParam().parts) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
    EXPECT_EQ(std::string(error.what()).rfind("portal:", 0), 0u) << error.what();
  }
}

const std::string held =
    "supports: [{nodes: [left], fix: [x, y, rotation]}, "
    "{nodes: [foot], fix: [x, y]}]\n";

INSTANTIATE_TEST_SUITE_P(
    Portal, PartitionErrors,
    testing::Values(
        Bad{"underconstrained",
            "supports: [{nodes: [foot], fix: [x, y]}]\n"
            "dofs: [{deformations: post}, {deformations: lintel}]\n",
            {"the partition leaves 2 free motion(s)", "'left'", "add a dof"}},
        Bad{"overconstrained",
            held + "dofs: [{deformations: post}, {deformations: lintel}]\n",
            {"the conditions are 1 too many (overconstrained)", "'stay'", "take away a dof"}},
        Bad{"dofs_not_independent",
            held + "dofs: [{deformations: post}, {node: corner, along: x}, "
                   "{element: lintel, mode: 2}]\n",
            {"free motion(s)", "'right'", "release", "'post'", "not independent"}},
        Bad{"dof_twice",
            held + "dofs: [{deformations: post}, {element: post, mode: 2}]\n",
            {"this dof is named twice"}},
        Bad{"dof_of_a_rigid_element",
            held + "dofs: [{element: stay}]\n",
            {"'stay' is rigid, its deformation can be no dof"}},
        Bad{"prescribed_and_dof",
            held + "prescribed: [{element: post, mode: 1}]\ndofs: [{deformations: post}]\n",
            {"prescribed twice, or a dof as well"}},
        Bad{"rotation_dof_that_is_fixed",
            held + "dofs: [{node: left, rotation: true}]\n",
            {"node 'left' has no free rotation"}}),
    [](const auto& param) { return std::string(param.param.name); });

TEST(DependentConditions, OfAutomaticDofsNamesRigidElementsThatDependOnEachOther) {
  // A rigid triangle with a second rigid bar on one of its sides.
  const std::string text = R"(title: Doubled bar
planar: true
nodes:
  a: {position: [0, 0]}
  b: {position: [1, 0]}
  c: {position: [0, 1]}
masses: [{node: a, mass: 1}, {node: b, mass: 1}, {node: c, mass: 1}]
elements:
  ab: {type: truss, nodes: [a, b], rigid: true}
  again: {type: truss, nodes: [a, b], rigid: true}
  bc: {type: truss, nodes: [b, c], rigid: true}
dofs: auto
)";
  try {
    make_model(parse_scene(text, "doubled"));
    FAIL() << "no InputError";
  } catch (const InputError& error) {
    for (const char* part : {"'ab'", "'again'", "not independent"}) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
    EXPECT_EQ(std::string(error.what()).find("'bc'"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace stillframe::test

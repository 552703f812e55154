#include <gtest/gtest.h>

#include <string>

#include "core/equilibrium.hpp"
#include "core/modes.hpp"
#include "core/operating_point.hpp"
#include "core/scene/scene_reader.hpp"
#include "core/state_space.hpp"
#include "core/yaml/input_error.hpp"

namespace stillframe::test {
namespace {

const std::string massless_joint = R"(title: Two springs in a row, nothing heavy between them
nodes:
  wall: {position: [0, 0, 0]}
  joint: {position: [1, 0, 0]}
  body: {position: [2, 0, 0]}
masses:
  - {node: body, mass: 1}
elements:
  near: {type: truss, nodes: [wall, joint], stiffness: 100}
  far: {type: truss, nodes: [joint, body], stiffness: 100}
supports:
  - {nodes: [wall, joint, body], fix: [y, z]}
  - {nodes: [wall], fix: [x]}
loads:
  - {node: body, force: [2, 0, 0]}
)";

// A dof without mass has no equation of motion: what needs one says so and names the dof; statics
// need none.
TEST(MasslessDof, IsRefusedByNameWhereMotionIsAskedFor) {
  const Model model = make_model(parse_scene(
      massless_joint + "dofs: [{node: joint, along: x}, {node: body, along: x}]", "massless"));
  const Equilibrium at = solve_equilibrium(model);
  EXPECT_NEAR(at.motion.state.q_d(0), 0.02, 1e-15);  // 2 N on one spring of 100 N/m, then on two
  EXPECT_NEAR(at.motion.state.q_d(1), 0.04, 1e-15);
  const LinearModel linear = linearise(model, at.motion, {}, {});
  for (const auto& ask :
       {+[](const LinearModel& l) { modes(l); }, +[](const LinearModel& l) { state_matrix(l); }}) {
    try {
      ask(linear);
      FAIL() << "no Refusal";
    } catch (const Refusal& refusal) {
      EXPECT_NE(std::string(refusal.what()).find("x(joint)"), std::string::npos) << refusal.what();
    }
  }
}

}  // namespace
}  // namespace stillframe::test

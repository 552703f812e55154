#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "core/errors/input_error.hpp"
#include "core/mechanics/equilibrium.hpp"
#include "core/mechanics/modes.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "core/mechanics/state_space.hpp"

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

const std::string blade_on_an_arm = R"(title: A blade in no axis of space, at the end of an arm
nodes:
  ground: {position: [0, 0, 0]}
  elbow: {position: [0.3, 0.2, 0.1]}
  tip: {position: [0.9, 0.5, 0.25]}
masses:
  - {node: tip, mass: 1}
elements:
  arm: {type: rigid_beam, nodes: [ground, elbow]}
  blade: {type: beam, nodes: [elbow, tip], EA: 1e7, orientation: [0, 0, 1], GJ: 15, EI_y: 19, EI_z: 20, mass_per_length: 0.01INERTIA}
supports:
  - {nodes: [ground], fix: [x, y, z, rotation]}
dofs:
  - {deformations: blade}
)";

Scene blade(const std::string& inertia) {
  std::string text = blade_on_an_arm;
  text.replace(text.find("INERTIA"), 7, inertia);
  return parse_scene(text, "blade");
}

// Its twist has no inertia, but a difference of large numbers is left: not a mass of 1e-22 kg and a
// mode of 1e11 Hz.
TEST(MasslessDof, IsNoMassThatRoundingHasLeft) {
  const Model model = make_model(blade(""));
  try {
    modes(linearise(model, solve_equilibrium(model).motion, {}, {}));
    FAIL() << "no Refusal";
  } catch (const Refusal& refusal) {
    EXPECT_NE(std::string(refusal.what()).find("e_2(blade) moves no mass"), std::string::npos)
        << refusal.what();
  }
}

// However slim: twist alone is a bar with one end free, of linear twist, omega^2 = 3 G J / (j l^2).
TEST(MasslessDof, IsNoneThatHasAnyMass) {
  const double l = std::sqrt(0.6 * 0.6 + 0.3 * 0.3 + 0.15 * 0.15);
  for (const char* text : {"1e-9", "1e-12"}) {  // light enough that the twist is the highest mode
    const double inertia = std::stod(text);
    const Model model = make_model(blade(std::string(", inertia_per_length: ") + text));
    const Modes found = modes(linearise(model, solve_equilibrium(model).motion, {}, {}));
    const double omega = 2 * std::numbers::pi * found.natural_frequencies_hz.maxCoeff();
    // A hundred roundings of the beam's other inertia, m l^2 / 105 a length, beside the one about
    // its axis; and 1e-6, as the twist takes a little of the tip's mass along.
    const double rounding = 100 * 2.2e-16 * 0.01 * l * l / 105 / inertia;
    EXPECT_NEAR(omega * omega / (3 * 15 / (inertia * l * l)), 1, 1e-6 + rounding) << text;
  }
}

}  // namespace
}  // namespace stillframe::test

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "core/errors/input_error.hpp"
#include "core/mechanics/buckling.hpp"
#include "core/mechanics/frequency_response.hpp"
#include "core/mechanics/modes.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "core/numerics/worst.hpp"
#include "tests/core/differences.hpp"

// Stationary motions are those that stay what they are: the rest are refused, whatever the dofs.
namespace stillframe::test {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

std::string with(std::string text, const std::string& old, const std::string& now) {
  const size_t at = text.find(old);
  EXPECT_NE(at, std::string::npos) << old;
  return text.replace(at, old.size(), now);
}

LinearModel linear(const std::string& text) {
  const Scene scene = parse_scene(text, "scene");
  return linearise(make_model(scene), scene.inputs, scene.outputs);
}

/// What the refusal says, or "accepted".
std::string said(const std::string& text) {
  try {
    linear(text);
  } catch (const Refusal& refusal) {
    return refusal.what();
  }
  return "accepted";
}

/// An arm with an elastic joint, a motor and a tip that is heavy, about the axis that the text
/// says.
std::string arm(const std::string& axis, const std::string& motion) {
  return R"(title: Arm
gravity: [0, 0, -9.81]
nodes:
  ground: {position: [0, 0, 0]}
  hub: {position: [0, 0, 0]}
  tip: {position: [1, 0, 0]}
masses: [{node: tip, mass: 2, inertia: [0.1, 0.2, 0.3]}]
elements:
  axle: {type: hinge, nodes: [ground, hub], axis: )" +
         axis + R"(}
  blade: {type: beam, nodes: [hub, tip], orientation: y, EA: 1e5, GJ: 100, EI_y: 300, EI_z: 200}
supports: [{nodes: [ground], fix: [x, y, z, rotation]}]
prescribed: [{element: axle, )" +
         motion + R"(}]
dofs: [{deformations: blade}]
)";
}

TEST(Stationarity, AnArmThatTurnsUnderGravityIsRefusedAndOneAboutThePlumbLineIsNot) {
  EXPECT_EQ(said(arm("z", "rate: 3")), "accepted");
  EXPECT_EQ(said(arm("[0, 0, -2]", "rate: -3, value: 1")), "accepted");
  EXPECT_EQ(said(arm("y", "value: 1")), "accepted");  // at rest everything is
  const std::string text = said(arm("y", "rate: 3"));
  EXPECT_NE(text.find("not stationary"), std::string::npos) << text;
  EXPECT_NE(text.find("'axle' (rate 3)"), std::string::npos) << text;
  EXPECT_NE(text.find("operating_point: as_written"), std::string::npos) << text;
  // However slow, and however little the axis is off: finite times show it.
  EXPECT_NE(said(arm("y", "rate: 1e-6")), "accepted");
  EXPECT_NE(said(arm("[0.001, 0, 1]", "rate: 3")), "accepted");
  EXPECT_NE(said(arm("z", "rate: 3, acceleration: 2")), "accepted");
  EXPECT_NE(said(arm("z", "acceleration: 2")), "accepted");
  // The same as a snapshot is asked for, and is called one wherever the scene is named.
  const std::string snapshot =
      with(arm("y", "rate: 3"), "nodes:", "operating_point: as_written\nnodes:");
  EXPECT_EQ(said(snapshot), "accepted");
  EXPECT_EQ(parse_scene(snapshot, "scene").title, "Arm (snapshot)");
}

/// A mass between a floor that moves and nothing else: spring and damper in series of two.
std::string chain(const std::string& motion, const std::string& dofs) {
  return R"(title: Chain
planar: true
nodes: {floor: {position: [0, 0]}, first: {position: [1, 0]}, second: {position: [2, 0]}}
masses: [{node: first, mass: 2}, {node: second, mass: 1}]
elements:
  leg: {type: truss, nodes: [floor, first], stiffness: 800, damping: 4}
  top: {type: truss, nodes: [first, second], stiffness: 300, damping: 1, preload: 2}
supports: [{nodes: [first, second], fix: [y]}, {nodes: [floor], fix: [y]}]
prescribed: [{nodes: [floor], move: [x], )" +
         motion + R"(}]
loads: [{node: second, force: [5, 0]}]
dofs: [)" +
         dofs +
         R"(]
inputs: [{name: floor, acceleration: floor, along: x}, {name: push, force: second, along: x}]
outputs: [{name: force, stress: leg}, {name: shakes, acceleration: second, along: x},
          {name: top, deformation: top}]
)";
}

TEST(Stationarity, AMovingFloorIsTheSameForEveryChoiceOfDofs) {
  for (const char* motion : {"value: 0.1", "rate: 3", "rate: -0.5, value: 0.2", "acceleration: 2",
                             "rate: 1, acceleration: -3"}) {
    const LinearModel by_deformation = linear(chain(motion, "{element: leg}, {element: top}"));
    for (const char* dofs :
         {"{node: first, along: x}, {node: second, along: x}",
          "{element: leg}, {node: second, along: x}", "{node: first, along: x}, {element: top}"}) {
      const LinearModel other = linear(chain(motion, dofs));
      // Rounding of the balance, 1e-15 of 800 N over metres.
      EXPECT_LE(worst_of(other.y_0 - by_deformation.y_0), 1e-10) << motion << dofs << "\n"
                                                                 << other.y_0.transpose() << "\n"
                                                                 << by_deformation.y_0.transpose();
      for (const double f : {0.1, 2.0, 50.0}) {
        const std::complex<double> s(0, 2 * M_PI * f);
        EXPECT_LE(relative_error(transfer_function(other, s), transfer_function(by_deformation, s)),
                  1e-11)
            << motion << dofs;
      }
    }
  }
  // What ties the chain to the world as well sees the floor go away.
  const std::string tied = with(chain("rate: 1", "{element: leg}, {element: top}"), "  top: {type",
                                "  tie: {type: truss, nodes: [wall, first], "
                                "stiffness: 1}\n  top: {type");
  const std::string wall = with(with(tied, "second: {position: [2, 0]}",
                                     "second: {position: [2, 0]}, wall: {position: [-9, 0]}"),
                                "{nodes: [floor], fix: [y]}",
                                "{nodes: [floor], fix: [y]}, {nodes: [wall], fix: [x, y]}");
  EXPECT_NE(said(wall), "accepted");
  EXPECT_EQ(said(with(wall, "rate: 1", "rate: 0")), "accepted");
}

/// A mass on two springs on a table that turns; what else is there, and what is asked for.
std::string table(const std::string& elements, const std::string& signals,
                  const std::string& gravity = "[0, 0]",
                  const std::string& dofs = "{element: spring_x}, {element: spring_y}") {
  return R"(title: Table
planar: true
gravity: )" +
         gravity + R"(
nodes: {ground: {position: [0, 0]}, table: {position: [0, 0]}, end_x: {position: [1, 0]},
        end_y: {position: [0, 1]}, mass: {position: [0, 0]}, post: {position: [3, 2]}}
masses: [{node: mass, mass: 1}]
elements:
  axle: {type: hinge, nodes: [ground, table]}
  arm_x: {type: rigid_beam, nodes: [table, end_x]}
  arm_y: {type: rigid_beam, nodes: [table, end_y]}
  spring_x: {type: truss, nodes: [end_x, mass], stiffness: 100, damping: 0.1}
  spring_y: {type: truss, nodes: [end_y, mass], stiffness: 100, damping: 0.1}
)" + elements +
         R"(supports: [{nodes: [ground], fix: [x, y, rotation]}, {nodes: [post], fix: [x, y]}]
prescribed: [{element: axle, rate: 5}]
dofs: [)" +
         dofs + "]\n" + signals;
}

TEST(Stationarity, WhatIsFixedInTheWorldDoesNotTurnWithTheTable) {
  EXPECT_EQ(said(table("", "")), "accepted");
  EXPECT_EQ(said(table("",
                       "inputs: [{name: a, stress: spring_x}, {name: b, deformation: axle}]\n"
                       "outputs: [{name: c, deformation: spring_y}, {name: d, stress: axle}]\n")),
            "accepted");
  EXPECT_NE(said(table("", "", "[0, -0.01]")), "accepted");
  const std::string spring = "  tie: {type: truss, nodes: [post, mass], stiffness: 0.1}\n",
                    damper =
                        "  tie: {type: truss, nodes: [post, mass], stiffness: 0, damping: 0.1}\n";
  EXPECT_NE(said(table(spring, "")), "accepted");
  EXPECT_NE(said(table(damper, "")), "accepted");
  const std::string input = said(table("", "inputs: [{name: push, force: mass, along: x}]\n")),
                    output =
                        said(table("", "outputs: [{name: see, acceleration: mass, along: y}]\n")),
                    reaction =
                        said(table("", "outputs: [{name: hold, reaction: ground, along: x}]\n"));
  EXPECT_NE(input.find("input 'push'"), std::string::npos) << input;
  EXPECT_NE(output.find("output 'see'"), std::string::npos) << output;
  EXPECT_NE(reaction.find("output 'hold'"), std::string::npos) << reaction;
}

TEST(Stationarity, DofsThatDoNotGoAlongGiveTheSameAnswerOrNone) {
  // Two equal springs without dampers are the same from all sides: in the world the mass does not
  // see the table turn at all, and its frequencies are those without.
  const std::string world = "{node: mass, along: x}, {node: mass, along: y}";
  std::string round = table("", "", "[0, 0]", world);
  for (int i = 0; i < 2; ++i) round = with(round, ", damping: 0.1", "");
  const Modes result = modes(linear(round));
  EXPECT_NEAR(result.eigenvalues(0).imag(), 10, 1e-12);
  EXPECT_NEAR(result.eigenvalues(2).imag(), 10, 1e-12);
  // One stiffer than the other it does.
  const std::string text = said(with(round, "stiffness: 100", "stiffness: 101"));
  EXPECT_NE(text.find("those that do are deformations"), std::string::npos) << text;
}

/// 100 N/m and 1 kg on a table that turns by 5 rad/s: 100 - 25, without anyone saying that it
/// moves.
TEST(Stationarity, WhatMovesIsSeenFromTheMotionItself) {
  const Scene scene = parse_scene(table("", ""), "scene");
  const Model model = make_model(scene);
  EXPECT_NEAR(linearise(model, {}, {}).stiffness()(0, 0), 75, 1e-12);
  NominalMotion motion(model);
  EXPECT_FALSE(motion.moving());
  motion.state.q_r_dot(0) = 5;
  EXPECT_TRUE(motion.moving());
  EXPECT_NEAR(linearise(model, motion, {}, {}).stiffness()(0, 0), 75, 1e-12);
}

/// A wheel that turns fast on a boom that turns slowly: each is looked at at its own speed.
TEST(Stationarity, SlowMotionsBesideFastOnesAreSeen) {
  const auto boom = [](const std::string& axis) {
    return R"(title: Wheel on a boom
gravity: [0, 0, -9.81]
nodes:
  ground: {position: [0, 0, 0]}
  post: {position: [0, 0, 0]}
  end: {position: [1, 0, 0]}
  rim: {position: [1, 0, 0]}
masses: [{node: end, mass: 2}, {node: rim, mass: 1, inertia: [0.1, 0.1, 0.2]}]
elements:
  slow: {type: hinge, nodes: [ground, post], axis: )" +
           axis + R"(}
  boom: {type: beam, nodes: [post, end], orientation: y, EA: 1e6, GJ: 1e4, EI_y: 3e4, EI_z: 2e4}
  fast: {type: hinge, nodes: [end, rim], axis: z}
supports: [{nodes: [ground], fix: [x, y, z, rotation]}]
prescribed: [{element: slow, rate: 1e-3}, {element: fast, rate: 50}]
dofs: [{deformations: boom}]
)";
  };
  EXPECT_EQ(said(boom("z")), "accepted");
  const std::string text = said(boom("y"));
  EXPECT_NE(text.find("'slow' (rate 0.001), 'fast' (rate 50)"), std::string::npos) << text;
}

/// A column on a motor that has turned it by an angle under the load carries the component along
/// it.
TEST(Buckling, CountsThePrescribedValuesAndRefusesRates) {
  const auto column = [](const std::string& motion) {
    return make_model(parse_scene(R"(title: Column on a motor
planar: true
nodes: {foot: {position: [0, 0]}, hub: {position: [0, 0]}, top: {position: [1, 0]}}
masses: []
elements:
  motor: {type: hinge, nodes: [foot, hub]}
  column: {type: beam, nodes: [hub, top], rigid: [1], EI: 1, divide: 4}
supports: [{nodes: [foot], fix: [x, y, rotation]}]
prescribed: [{element: motor, )" + motion +
                                      R"(}]
loads: [{node: top, force: [-1, 0]}]
dofs: [{deformations: column}]
)",
                                  "scene"));
  };
  const double upright = buckling(column("value: 0")).load_multipliers(0);
  for (const double angle : {0.5, -1.2, 7.0}) {
    const double found = buckling(column("value: " + std::to_string(angle))).load_multipliers(0);
    EXPECT_NEAR(found * std::cos(angle), upright, 1e-12 * found) << angle;
  }
  EXPECT_THROW(buckling(column("rate: 0.5")), Refusal);
  EXPECT_THROW(buckling(column("acceleration: 0.5")), Refusal);
}

}  // namespace
}  // namespace stillframe::test

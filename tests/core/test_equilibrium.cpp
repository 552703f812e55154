#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <utility>

#include "core/errors/input_error.hpp"
#include "core/mechanics/equilibrium.hpp"
#include "core/mechanics/scene/scene_reader.hpp"

namespace stillframe::test {
namespace {

/// What the refusal says, or "accepted".
std::string said(const std::string& text) {
  try {
    solve_equilibrium(make_model(parse_scene(text, "scene")));
  } catch (const Refusal& refusal) {
    return refusal.what();
  }
  return "accepted";
}

/// The part of the loads up to which a refusal says that they can be followed.
double followed(const std::string& refusal) {
  const std::string before = "can be followed up to ";
  const size_t at = refusal.find(before);
  EXPECT_NE(at, std::string::npos) << refusal;
  return at == std::string::npos ? 0 : std::stod(refusal.substr(at + before.size()));
}

/// Two bars of stiffness k that a load P flattens: P = 2 k y (L_0 / L - 1), L^2 = a^2 + y^2, which
/// is largest where L^3 = L_0 a^2; beyond, it snaps through to an equilibrium that growing loads do
/// not lead to by themselves.
class FlatArch {
 public:
  explicit FlatArch(double unit) : unit_(unit) {}
  double limit() const {
    const double L = std::cbrt(L_0 * a * a), y = std::sqrt(L * L - a * a);
    return 2 * k * y * (L_0 / L - 1);
  }
  /// The height under a load below the limit, by halving between that of the limit and the start.
  double height(double P) const {
    const double L = std::cbrt(L_0 * a * a);
    double low = std::sqrt(L * L - a * a), high = h;
    for (int i = 0; i < 100; ++i) {
      const double y = 0.5 * (low + high);
      (2 * k * y * (L_0 / std::hypot(a, y) - 1) > P ? low : high) = y;
    }
    return high;
  }
  /// In metres of `unit`, kilograms and seconds; by the elongations of the bars or by positions.
  std::string text(double P, bool by_elongations) const {
    const auto number = [](double value) {
      char text[32];
      std::snprintf(text, sizeof text, "%.17g", value);
      return std::string(text);
    };
    const std::string x = number(a * unit_);
    return "title: A flat arch\nplanar: true\nnodes: {left: {position: [-" + x +
           ", 0]}, top: {position: [0, " + number(h * unit_) + "]}, right: {position: [" + x +
           ", 0]}}\nmasses: [{node: top, mass: 1}]\nelements:\n"
           "  one: {type: truss, nodes: [left, top], stiffness: " +
           number(k) +
           "}\n"
           "  other: {type: truss, nodes: [right, top], stiffness: " +
           number(k) +
           "}\n"
           "supports: [{nodes: [left, right], fix: [x, y]}]\n"
           "loads: [{node: top, force: [0, " +
           number(-P * unit_) + "]}]\ndofs: " +
           (by_elongations ? "[{element: one}, {element: other}]"
                           : "[{node: top, along: x}, {node: top, along: y}]") +
           "\n";
  }
  static constexpr double a = 1, h = 0.2, k = 1000;
  const double L_0 = std::hypot(a, h);

 private:
  double unit_;
};

// In millimetres and kilometres, and for every choice of dofs: the same.
TEST(Equilibrium, IsTheOneThatGrowingLoadsLeadTo) {
  for (const double unit : {1.0, 1e-3, 1e3}) {
    const FlatArch arch(unit);
    for (const bool by_elongations : {false, true}) {
      for (const double share : {0.1, 0.9, 0.999}) {
        const double P = share * arch.limit();
        const Model model = make_model(parse_scene(arch.text(P, by_elongations), "arch"));
        const Eigen::VectorXd x = solve_equilibrium(model).motion.x;
        const double fallen =
            -model.translation_row(model.node_index("top"), {0, 1, 0}).dot(x) / unit;
        // Rounding of 1e-16, made more by the stiffness that 0.1 % of the load leave: 1e-3.
        EXPECT_NEAR(fallen, arch.h - arch.height(P), 1e-12) << unit << " " << share;
      }
      // The path is followed until steps are 2^-16 of the load, some tenth of what is left.
      const std::string refusal = said(arch.text(1.5 * arch.limit(), by_elongations));
      EXPECT_NEAR(followed(refusal), 1 / 1.5, 3e-4);
      EXPECT_NE(refusal.find("there, node top has moved -"), std::string::npos) << refusal;
      EXPECT_NE(refusal.find(" m along y"), std::string::npos) << refusal;
    }
  }
}

/// A beam of EI = 1 N m^2 and 1 km, in 32 parts, under a moment at its end. The chain of its parts
/// bends by EI / l of moment at most.
std::string long_cantilever(double torque) {
  return "title: A cantilever that a moment would bend a thousand times round\nplanar: true\n"
         "nodes: {root: {position: [0, 0]}, tip: {position: [1000, 0]}}\nmasses: []\n"
         "elements: {beam: {type: beam, nodes: [root, tip], rigid: [1], EI: 1, divide: 32}}\n"
         "supports: [{nodes: [root], fix: [x, y, rotation]}]\n"
         "loads: [{node: tip, torque: " +
         std::to_string(torque) + "}]\ndofs: [{deformations: beam}]\n";
}
constexpr double most_torque = 1 / (1000.0 / 32);

// What is asked for is 200 times what the chain bears, and the first step of the loads that can be
// made is a thousandth of it.
TEST(Equilibrium, OfFarTooLargeALoadSaysHowFarItWasFollowed) {
  const double torque = 2 * std::numbers::pi, most = most_torque / torque;
  const std::string refusal = said(long_cantilever(torque));
  EXPECT_NEAR(followed(refusal), most, 3e-4 * most);
  EXPECT_NE(refusal.find("node tip has turned"), std::string::npos) << refusal;
  // Long before the number of steps would end it.
  EXPECT_EQ(refusal.find(" steps"), std::string::npos) << refusal;
}

// Steps that turn the tip by half a radian at most, of more than forty, each with the four or so of
// Newton's method: 139 and 575 as this was written, twice as many are allowed.
TEST(Equilibrium, OfManyTurnsTakesStepsByTheirNumber) {
  const Model model = make_model(parse_scene(long_cantilever(0.99 * most_torque), "cantilever"));
  const Equilibrium found = solve_equilibrium(model);
  EXPECT_LT(found.load_steps, 300);
  EXPECT_LT(found.iterations, 1200);
}

/// A clamped strip of EI = 400 N m^2 and 1 m, Euler's load 987 N, under a force at its tip.
std::string strip(const std::string& dofs, double push, double aside) {
  return "title: A strip\nplanar: true\nnodes: {root: {position: [0, 0]}, tip: {position: [1, "
         "0]}}\n"
         "masses: []\nelements: {strip: {type: beam, nodes: [root, tip], EA: 4e6, EI: 400, divide: "
         "20}}\nsupports: [{nodes: [root], fix: [x, y, rotation]}]\nloads: [{node: tip, force: [" +
         std::to_string(-push) + ", " + std::to_string(-aside) + "]}]\ndofs: " + dofs + "\n";
}

/// The angle of its tip as a differential equation has it, without length changes: EI theta'' = F_x
/// sin(theta) - F_y cos(theta), theta' = 0 at the tip, which bends aside from where it is clamped.
double elastica_tip_angle(double push, double aside) {
  constexpr int n_steps = 2000;
  const auto bent_back = [&](double tip) {  // the angle at the clamp of a strip of this tip angle
    double theta = tip, slope = 0;
    for (int k = 0; k < n_steps; ++k) {  // midpoint rule, from the tip back
      const double h = -1.0 / n_steps;
      const auto bend = [&](double angle) {
        return (-push * std::sin(angle) + aside * std::cos(angle)) / 400;
      };
      const double theta_half = theta + 0.5 * h * slope, slope_half = slope + 0.5 * h * bend(theta);
      theta += h * slope_half;
      slope += h * bend(theta_half);
    }
    return theta;
  };
  // The smallest bend at which the clamp is where it is.
  double large = -1e-3;
  while (bent_back(large) > 0) large *= 1.1;
  double small = large / 1.1;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (small + large);
    (bent_back(middle) > 0 ? small : large) = middle;
  }
  return large;
}

// Beyond Euler's load there is an equilibrium on the other side as well, where nothing stays, and
// Newton's method contracts to it from the start, as the stiffness of the loads is in its first
// step.
TEST(Equilibrium, BeyondBucklingIsWhereTheStripWasPushedTo) {
  for (const double push : {900.0, 1100.0, 1500.0, 2000.0, 3000.0}) {
    const double expected = elastica_tip_angle(push, 20);
    for (const std::string dofs : {"auto", "[{deformations: strip}]"}) {
      const Model model = make_model(parse_scene(strip(dofs, push, 20), "strip"));
      const Eigen::VectorXd x = solve_equilibrium(model).motion.x;
      const double turned =
          x(model.nodes[static_cast<size_t>(model.node_index("tip"))].rotation.column[0]);
      // 20 parts bend by 0.2 to 0.5 % too much, and shorten by P / EA, less than 0.1 %.
      EXPECT_NEAR(turned / expected, 1, 6e-3) << push << " " << dofs;
    }
  }
}

// And not by how far its parts, which hardly stretch, would be stretched on the way.
TEST(Equilibrium, OfAStripTakesStepsByHowFarItBends) {
  const auto steps = [](const std::string& dofs) {
    return solve_equilibrium(make_model(parse_scene(strip(dofs, 2000, 20), "strip"))).load_steps;
  };
  // 118 and 73; with the geometric stiffness of the strains on the way 1000 did not lead there.
  EXPECT_LT(steps("auto"), 3 * steps("[{deformations: strip}]"));
}

// However little out of straight: where it bends to does not depend on the dofs, nor is it beside
// the other branch.
TEST(Equilibrium, OfAColumnHardlyOutOfStraightIsWhereItBends) {
  const auto tip = [](const std::string& dofs) -> Eigen::Vector2d {
    const Model model = make_model(parse_scene(
        "title: A column\nplanar: true\nnodes: {a: {position: [0, 0]}, b: {position: [1e-5, 1]}}\n"
        "masses: []\nelements: {s: {type: beam, nodes: [a, b], EA: 1e5, EI: 1, divide: 4}}\n"
        "supports: [{nodes: [a], fix: [x, y, rotation]}]\nloads: [{node: b, force: [0, -6.1685]}]\n"
        "dofs: " +
            dofs + "\n",
        "column"));
    const Eigen::VectorXd x = solve_equilibrium(model).motion.x;
    const Index b = model.node_index("b");
    return {model.translation_row(b, {1, 0, 0}).dot(x), model.translation_row(b, {0, 1, 0}).dot(x)};
  };
  // By another program, which minimises the energy along the path: 0.72297, -1.28018.
  EXPECT_LE((tip("auto") - Eigen::Vector2d(0.72297, -1.28018)).norm(), 1e-4);
  EXPECT_LE((tip("[{deformations: s}]") - tip("auto")).norm(), 1e-9);
}

// So little that the path turns within less than a step: no other branch, but where it ends, which
// is 1.2 % above Euler's load, as four parts have it.
TEST(Equilibrium, OfAColumnNearlyStraightIsRefusedAtItsBucklingLoad) {
  for (const std::string dofs : {"auto", "[{deformations: s}]"}) {
    const std::string refusal = said(
        "title: A column\nplanar: true\nnodes: {a: {position: [0, 0]}, b: {position: [1e-7, 1]}}\n"
        "masses: []\nelements: {s: {type: beam, nodes: [a, b], EA: 1e5, EI: 1, divide: 4}}\n"
        "supports: [{nodes: [a], fix: [x, y, rotation]}]\nloads: [{node: b, force: [0, -6.1685]}]\n"
        "dofs: " +
        dofs + "\n");
    EXPECT_NEAR(followed(refusal), 0.4 * 1.012, 1e-3) << refusal;
  }
}

// The straight column itself goes on, unstable, where nothing pushes it aside.
TEST(Equilibrium, OfAStraightStripBeyondBucklingIsStraight) {
  for (const std::string dofs : {"auto", "[{deformations: strip}]"}) {
    const Model model = make_model(parse_scene(strip(dofs, 1100, 0), "strip"));
    const Eigen::VectorXd x = solve_equilibrium(model).motion.x;
    EXPECT_NEAR(model.translation_row(model.node_index("tip"), {1, 0, 0}).dot(x), -1100 / 4e6,
                1e-12);
  }
}

/// A column of EA = 1e4 N, 1 m long, under a load along it.
std::string column(const std::string& force) {
  return "title: A column\nplanar: true\n"
         "nodes: {root: {position: [0, 0]}, tip: {position: [1, 0]}}\nmasses: []\n"
         "elements: {column: {type: beam, nodes: [root, tip], EA: 1e4, EI: 1, mass_per_length: 1,\n"
         "  second_order: true, divide: 4}}\n"
         "supports: [{nodes: [root], fix: [x, y]}, {nodes: [tip], fix: [y]}]\n"
         "loads: [{node: tip, force: [" +
         force + ", 0]}]\ndofs: auto\n";
}

// It is linear: the steps grow with what has been pulled out, and do not become more in proportion.
TEST(Equilibrium, OfALongPullTakesStepsByItsLogarithm) {
  for (const auto& [force, longer] : {std::pair{"1e6", 1e2}, {"1e9", 1e5}, {"1e12", 1e8}}) {
    const Model model = make_model(parse_scene(column(force), "column"));
    const Equilibrium result = solve_equilibrium(model);
    const double moved =
        model.translation_row(model.node_index("tip"), {1, 0, 0}).dot(result.motion.x);
    // Rounding, which the balance may leave at 1e-7 of the load.
    EXPECT_NEAR(moved, longer, 1e-7 * longer) << force;
    // Steps of half the size and growing by half: log(1e8) / log(1.5) = 45; here and there one
    // again.
    EXPECT_LT(result.load_steps, 100) << force;
  }
}

// Pushed together to nothing at its load itself, so that the last digit of the share matters.
TEST(Equilibrium, WhatCannotBeFollowedToTheEndIsNotSaidToBe) {
  const double share = followed(said(column("-1e4")));
  EXPECT_LT(share, 1);
  EXPECT_GT(share, 0.999);
}

// A spring that is wound up has no end and no shorter way: the number of steps ends it.
TEST(Equilibrium, OfALoadThatWindsUpWithoutEndIsRefusedInTime) {
  const std::string refusal = said(R"(title: A spring that is wound up
planar: true
nodes: {root: {position: [0, 0]}, tip: {position: [0, 0]}}
masses: [{node: tip, mass: 1, inertia: 1}]
elements: {spring: {type: hinge, nodes: [root, tip], stiffness: 1}}
supports: [{nodes: [root], fix: [x, y, rotation]}]
loads: [{node: tip, torque: 1e7}]
dofs: [{element: spring}]
)");
  EXPECT_NE(refusal.find(" in 1000 steps, and are far too large"), std::string::npos) << refusal;
  EXPECT_NE(refusal.find("node tip has turned"), std::string::npos) << refusal;
  // Every step turns it by half a radian at most, of 1e7.
  EXPECT_GT(followed(refusal), 1e-5);
  EXPECT_LT(followed(refusal), 1e-4);
}

// Its path ends at 8 % of the weight; the whole weight, from the start, has an equilibrium that
// Newton's method contracts to by a quarter, where the tripod hangs below the points it stands on.
TEST(Equilibrium, IsNotWhereATripodHangsThatHasSnappedThrough) {
  EXPECT_NEAR(followed(said(R"(title: A flat tripod
gravity: [0, 0, -9.81]
nodes:
  frame: {position: [0, 0, 0]}
  floor_1: {position: [-0.209989, -0.0800989, 0.0364995]}
  floor_2: {position: [0.0724115, 0.174476, -0.0467626]}
  floor_3: {position: [0.274823, -0.281502, -0.198979]}
masses: [{node: frame, mass: 189.273}]
elements:
  leg_1: {type: truss, nodes: [floor_1, frame], stiffness: 383830}
  leg_2: {type: truss, nodes: [floor_2, frame], stiffness: 213370}
  leg_3: {type: truss, nodes: [floor_3, frame], stiffness: 237755}
supports: [{nodes: [floor_1, floor_2, floor_3], fix: [x, y, z]}]
dofs: auto
)")),
              0.0805, 1e-3);  // `modes` of smaller loads: the frequency falls to nothing there
}

TEST(Equilibrium, OfAMechanismSaysWhatNothingResists) {
  const std::string text = said(R"(title: Pendulum, written level
gravity: [0, 0, -9.81]
nodes: {pivot: {position: [0, 0, 0]}, bob: {position: [1, 0, 0]}}
masses: [{node: bob, mass: 1}]
elements: {rod: {type: truss, nodes: [pivot, bob], rigid: true}}
supports: [{nodes: [pivot], fix: [x, y, z]}, {nodes: [bob], fix: [y]}]
dofs: [{node: bob, along: z}]
)");
  EXPECT_NE(text.find("mechanism, nothing resists a motion of dof z(bob)"), std::string::npos)
      << text;
}

}  // namespace
}  // namespace stillframe::test

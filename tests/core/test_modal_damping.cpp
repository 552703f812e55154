#include <gtest/gtest.h>

#include <cmath>

#include "core/errors/input_error.hpp"
#include "core/mechanics/modes.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/mechanics/scene/scene_reader.hpp"

namespace stillframe {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

Scene scene_with(const std::string& name, std::vector<SceneModalDamping::Point> points) {
  Scene scene = read_scene(std::string(STILLFRAME_SOURCE_DIR "/config/scenes/") + name + ".yaml");
  scene.modal_damping = {std::move(points), "scene"};
  return scene;
}

LinearModel linear_of(const Scene& scene) {
  return linearise(make_model(scene), scene.inputs, scene.outputs);
}

constexpr const char* pendulum = R"(
title: A body on a rod, and another on a spring
planar: true
gravity: [0, -9.81]
nodes: {top: {position: [0, 0]}, bob: {position: [0, -1]}, wall: {position: [1, 0]}, slider: {position: [2, 0]}}
masses: [{node: bob, mass: 1}, {node: slider, mass: 1}]
elements:
  rod: {type: truss, nodes: [top, bob], rigid: true}
  spring: {type: truss, nodes: [wall, slider], stiffness: 1000}
supports: [{nodes: [top, wall], fix: [x, y]}, {nodes: [slider], fix: [y]}]
dofs: auto
)";

/// V^T D V over 2 omega of what modal damping adds: a diagonal of ratios, and nothing beside it.
MatrixXd added_ratios(Scene scene) {
  const LinearModel damped = linear_of(scene);
  scene.modal_damping.reset();
  const LinearModel own = linear_of(scene);
  const Modes natural = modes(own);
  const VectorXd omega = 2 * M_PI * natural.natural_frequencies_hz;
  const VectorXd roots = (2 * omega).cwiseSqrt().cwiseInverse();
  return roots.asDiagonal() * natural.shapes.transpose() * (damped.D - own.D) * natural.shapes *
         roots.asDiagonal();
}

/// Stiff and soft, heavy enough to soften and to stiffen, damped and not, with a mesh, with modes
/// that come twice.
TEST(ModalDamping, GivesEachModeItsRatioAndLeavesItAMode) {
  for (const char* name : {"metrology_frame", "frame_under_gravity", "preloaded_frame", "cart",
                           "frame_flexible", "meshed_frame", "leaf_spring_guide", "lens_frame",
                           "loaded_pinned_beam", "cantilever", "frame_slow_actuators"}) {
    const Scene scene = scene_with(name, {{5, 0.02}, {20, 0.03}, {200, 0.005}});
    Scene own = scene;
    own.modal_damping.reset();
    const VectorXd hz = modes(linear_of(own)).natural_frequencies_hz;
    const VectorXd wanted =
        hz.unaryExpr([&](double f) { return scene.modal_damping->ratio_at(f); });
    const MatrixXd found = added_ratios(scene);
    // Shapes are known to the root of rounding where frequencies lie close together.
    EXPECT_LE((found - MatrixXd(wanted.asDiagonal())).cwiseAbs().maxCoeff(), 1e-8) << name;
  }
}

TEST(ModalDamping, IsLinearBetweenItsFrequencies) {
  const SceneModalDamping damping{.points = {{10, 0.02}, {20, 0.04}, {40, 0}}, .place = ""};
  for (const auto& [hz, ratio] :
       {std::pair{0.0, 0.02}, {10, 0.02}, {15, 0.03}, {20, 0.04}, {35, 0.01}, {40, 0}, {1e6, 0}}) {
    EXPECT_NEAR(damping.ratio_at(hz), ratio, 1e-15) << hz;
  }
  // The default written out is no damping, also where some would be refused.
  for (const char* none :
       {"modal_damping: 0\n", "modal_damping: [[1, 0], [2, 0]]\nreduce: {modes: 1}\n"}) {
    EXPECT_FALSE(parse_scene(std::string(pendulum) + none, "a.yaml").modal_damping) << none;
  }
}

/// Modes that lie next to each other are not told apart: which dofs are chosen makes no difference,
/// nor does a leg that is a millionth stiffer more than that.
TEST(ModalDamping, DoesNotDependOnHowDoubleModesAreTurned) {
  Scene scene = scene_with("metrology_frame", {{5, 0.05}, {200, 0.005}});
  const auto eigenvalues = [](const Scene& of) { return modes(linear_of(of)).eigenvalues; };
  const Eigen::VectorXcd legs = eigenvalues(scene);
  Scene stiffer = scene;
  scene.automatic_dofs = true;
  EXPECT_LE((eigenvalues(scene) - legs).norm(), 1e-8 * legs.norm());
  stiffer.elements.front().stiffness *= 1 + 1e-6;
  for (SceneElement& element : stiffer.elements) {
    if (element.name == "leg_1t") element.stiffness *= 1 + 1e-6;
  }
  EXPECT_LE((eigenvalues(stiffer) - legs).norm(), 1e-5 * legs.norm());
}

/// Dampers on the rates of these dofs would hold the body to the world.
constexpr const char* on_two_feet = R"(
title: A body on two struts and a spring
planar: true
nodes: {body: {position: [0.2, 1]}, left: {position: [-1, 0]}, right: {position: [1, 0.1]}, side: {position: [-2, 1.3]},
  hook: {position: [0.1, 1.2]}}
masses: [{node: body, mass: 3, inertia: 0.2}]
elements:
  a: {type: truss, nodes: [left, body], stiffness: 1e4}
  b: {type: truss, nodes: [right, hook], stiffness: 2e4}
  c: {type: truss, nodes: [side, hook], stiffness: 3e3}
  arm: {type: rigid_beam, nodes: [body, hook]}
prescribed: [{nodes: [left, right, side], move: [x, y]}]
dofs: [{node: body, along: x}, {node: body, along: y}, {node: body, rotation: true}]
inputs:
  - {name: left_x, velocity: left, along: x}
  - {name: left_y, velocity: left, along: y}
  - {name: right_x, velocity: right, along: x}
  - {name: right_y, velocity: right, along: y}
  - {name: side_x, velocity: side, along: x}
  - {name: side_y, velocity: side, along: y}
outputs: []
modal_damping: 0.1
)";

TEST(ModalDamping, DoesNotResistTheFloorAndTheFrameTogether) {
  const LinearModel linear = linear_of(parse_scene(on_two_feet, "feet.yaml"));
  MatrixXd frame(3, 3), floor(6, 3);
  frame << 1, 0, -1,  //
      0, 1, 0.2,      //
      0, 0, 1;
  floor << 1, 0, 0, 0, 1, -1,  // along x, along y, about the origin
      1, 0, -0.1, 0, 1, 1,     //
      1, 0, -1.3, 0, 1, -2;
  const MatrixXd of_frame = linear.D * frame, of_floor = linear.D_r * floor;
  EXPECT_GT(of_frame.colwise().norm().minCoeff(), 1);
  EXPECT_LE((of_frame + of_floor).norm(), 1e-12 * of_frame.norm());
}

TEST(ModalDamping, IsNoneOfAMotionThatNothingHolds) {
  const Modes found = modes(linear_of(scene_with("free_free_beam", {{0, 0.01}})));
  const VectorXd& hz = found.natural_frequencies_hz;
  ASSERT_GT(hz.size(), 4);
  for (Index i = 0; i < hz.size(); ++i) {
    const bool free = found.eigenvalues(2 * i) == 0.0;
    EXPECT_EQ(free, hz(i) < 1e-3) << hz(i);
    if (!free) EXPECT_NEAR(found.damping_ratios(i), 0.01, 1e-9) << hz(i);
  }
  EXPECT_EQ(found.n_growing, 0);
}

TEST(ModalDamping, CannotBeOfAModeThatWeightHolds) {
  std::string refused;
  try {
    make_model(parse_scene(std::string(pendulum) + "modal_damping: 0.01\n", "pendulum.yaml"));
  } catch (const Refusal& refusal) {
    refused = refusal.what();
  }
  EXPECT_NE(
      refused.find("pendulum.yaml:12:16: modal_damping: mode 1, of 0.4985 Hz, is held by weight"),
      std::string::npos)
      << refused;
  const Scene allowed =
      parse_scene(std::string(pendulum) + "modal_damping: [[1, 0], [3, 0.01]]\n", "pendulum.yaml");
  const Modes found = modes(linear_of(allowed));
  EXPECT_EQ(found.damping_ratios(0), 0);
  EXPECT_NEAR(found.damping_ratios(1), 0.01, 1e-12);
}

/// What pushes itself away has no ratio, and is left alone by what damps the rest.
TEST(ModalDamping, LeavesWhatIsUnstableAlone) {
  const std::string scene = R"(
title: A mass on two struts, pressed
planar: true
nodes: {m: {position: [0, 1]}, a: {position: [0, 0]}, b: {position: [1, 1]}, c: {position: [1, 2]}}
masses: [{node: m, mass: 1}]
elements:
  a: {type: truss, nodes: [a, m], stiffness: 1e4, preload: -200}
  b: {type: truss, nodes: [b, m], stiffness: 100}
  c: {type: truss, nodes: [c, m], stiffness: 50}
supports: [{nodes: [a, b, c], fix: [x, y]}]
operating_point: as_written
dofs: auto
)";
  const auto of = [&](const std::string& more) {
    return linear_of(parse_scene(scene + more, "pressed.yaml"));
  };
  const LinearModel plain = of(""), damped = of("modal_damping: 0.02\n");
  EXPECT_FALSE(stability(plain).stable.value());
  EXPECT_FALSE(stability(damped).stable.value());
  const NaturalShapes natural = natural_shapes(plain);
  const MatrixXd found = natural.V.transpose() * damped.D * natural.V;
  ASSERT_LT(natural.squares(0), 0);
  const double wanted = 2 * 0.02 * std::sqrt(natural.squares(1));
  EXPECT_NEAR(found(1, 1), wanted, 1e-12 * wanted);
  EXPECT_LE(std::abs(found(0, 0)) + std::abs(found(0, 1)), 1e-12 * wanted);
}

}  // namespace
}  // namespace stillframe

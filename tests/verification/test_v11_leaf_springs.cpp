#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <iostream>

#include "core/mechanics/equilibrium.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "tests/verification/convergence.hpp"
#include "tests/verification/scene_text.hpp"

// V11: a stage on two parallel leaf springs.
namespace stillframe::verification {
namespace {

constexpr double length = 0.1, stiffness = 1000;  // m, and 24 EI / L^3 of the scene in N/m

/// The guide at rest, unloaded, its leaves in n parts, which push its stage sideways.
std::string unloaded(int n) {
  std::string text = without_signals(scene_text("leaf_spring_guide"));
  text = with(text, "loads:\n  - {node: stage_1, force: [5, 0]}\n", "");
  text = with(text, "dofs:\n  - {node: stage_1, along: x}\n", "dofs: auto\n");
  return divided(text, n) +
         "inputs: [{name: drive, force: stage_1, along: x}]\n"
         "outputs: [{name: sideways, position: stage_1, along: x},"
         " {name: down, velocity: stage_1, along: y}]\n";
}

struct Guide {
  double stiffness = 0;   ///< N/m
  double shortening = 0;  ///< times u^2 / L
};

/// Both from the linear model: the stage moves along its static deflection s q at the rate 1, where
/// the row of dy/dt is (D2F q') with q' = s, so that y = s^T D2F s u^2 / 2.
Guide guide(const std::string& text) {
  const Scene scene = parse_scene(text, "scene");
  const Model model = make_model(scene);
  Lineariser lineariser(model, scene.inputs, scene.outputs);
  NominalMotion motion(model);
  const LinearModel rest = lineariser.about(motion);
  Eigen::VectorXd shape = rest.K.partialPivLu().solve(rest.B.col(0));
  const double compliance = rest.Y_p.row(0) * shape;
  shape /= compliance;
  motion.state.q_d_dot = shape;
  const LinearModel& moving = lineariser.about(motion);
  return {1 / compliance, -0.5 * moving.Y_p.row(1).dot(shape) * length};
}

TEST(V11, StiffnessIsExactWithOneElement) {
  for (const int n : {1, 2, 4}) {
    // A leaf bends as a cubic, as its elements do. Rounding grows with the condition, as n^4.
    const double tolerance = 1e-14 * n * n * n * n;
    EXPECT_NEAR(guide(unloaded(n)).stiffness / stiffness, 1, tolerance) << n;
    EXPECT_NEAR(guide(first_order(unloaded(n))).stiffness / stiffness, 1, tolerance) << n;
  }
}

TEST(V11, ShorteningFromTheSecondOrderTransferFunction) {
  for (const int n : {1, 2, 4, 8, 16}) {
    const double h = 1.0 / n;
    EXPECT_NEAR(guide(unloaded(n)).shortening, 0.6, 1e-13 * n * n * n * n) << n;
    // Chords of a cubic leave out half of the variance of its slope in each part:
    // h^2 / 2 (1 - 4 h^2 / 5).
    const double chords = 0.6 - h * h / 2 * (1 - 0.8 * h * h);
    EXPECT_NEAR(guide(first_order(unloaded(n))).shortening, chords, 1e-13 * n * n * n * n) << n;
  }
  print_counts("V11 second_order", [](int n) { return guide(unloaded(n)).shortening / 0.6 - 1; });
  const Error first = [](int n) { return guide(first_order(unloaded(n))).shortening / 0.6 - 1; };
  print_counts("V11 first order", first, 1, 32);
  std::cout << "V11 first order, extrapolated: 1e-5 with " << extrapolated_count(first, 32, 2, 1e-5)
            << "\n";
}

/// The equilibrium itself: y = -0.6 u^2 / L up to terms of the order of (u / L)^2 of it.
TEST(V11, ShorteningOfTheLoadedGuide) {
  double previous = 0;
  for (const double force : {10.0, 5.0, 2.5}) {
    const LinearModel m = linear_model(with(scene_text("leaf_spring_guide"), "force: [5, 0]",
                                            "force: [" + number(force) + ", 0]"));
    const double u = m.y_0(0), y = m.y_0(1);
    EXPECT_NEAR(u, force / stiffness, 1e-12);  // linear in the element's own deformations
    const double error = y / (-0.6 * u * u / length) - 1;
    EXPECT_LE(std::abs(error), std::pow(u / length, 2));
    if (previous != 0) {
      EXPECT_NEAR(previous / error, 4, 0.1) << force;  // next: (u / L)^4, 1 % of it
    }
    previous = error;
    // Moments about the feet and forces balance: two S-shaped leaves.
    EXPECT_NEAR(m.y_0(3) * 2, force * length / 2, 0.05 * force * length / 2);
  }
}

}  // namespace
}  // namespace stillframe::verification

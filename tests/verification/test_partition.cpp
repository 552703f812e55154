#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>
#include <numbers>

#include "core/mechanics/frequency_response.hpp"
#include "core/numerics/worst.hpp"
#include "tests/verification/scene_text.hpp"

// The choice of q^d changes no transfer function, for the scenes that the core's own tests do not
// have (those of the cart and the frame are in tests/core/test_partition_invariance.cpp). About a
// stationary motion this holds for coordinates that turn with it, in which it is stationary.
namespace stillframe::verification {
namespace {

/// Largest difference of two transfer functions, relative to their size, over frequencies in Hz.
double worst_difference(const std::string& a, const std::string& b, double from, double to) {
  const LinearModel m_a = linear_model(a), m_b = linear_model(b);
  double worst = 0;
  for (const double f : logarithmic_frequencies(from, to, 100)) {
    const std::complex<double> s(0, 2 * std::numbers::pi * f);
    const Eigen::MatrixXcd G_a = transfer_function(m_a, s), G_b = transfer_function(m_b, s);
    worst = worst_of(worst, (G_a - G_b).norm() / G_a.norm());
  }
  return worst;
}

/// 1e-10 is what the project asks for; poles of little damping amplify the rounding of M and K.
void expect_same(const std::string& name, const std::string& a, const std::string& b, double from,
                 double to) {
  const double worst = worst_difference(a, b, from, to);
  std::cout << "q^d of " << name << ": transfer functions differ by " << worst << "\n";
  EXPECT_LE(worst, 1e-10) << name;
}

TEST(Partition, CantileverByDeformationsAndByNodes) {
  // Damped, as the relative difference of two undamped resonances has no bound.
  const std::string text =
      with(scene_text("cantilever"), "divide: 8", "damping_time: 1e-5, divide: 8");
  expect_same("cantilever.yaml", text,
              with(text,
                   "dofs:                                   # all deformations of the eight\n"
                   "  - {deformations: beam}\n",
                   "dofs: auto\n"),
              0.1, 100);
}

TEST(Partition, FrameUnderItsWeightByLegsAndByTheLens) {
  const std::string text = scene_text("preloaded_frame");
  const size_t from = text.find("\ndofs:"), to = text.find("# What disturbs");
  std::string by_lens = text;
  by_lens.replace(from, to - from,
                  "\ndofs:\n  - {node: lens, along: x}\n  - {node: lens, along: y}\n"
                  "  - {node: lens, along: z}\n  - {node: lens, euler_parameter: 1}\n"
                  "  - {node: lens, euler_parameter: 2}\n  - {node: lens, euler_parameter: 3}\n");
  expect_same("preloaded_frame.yaml", text, by_lens, 0.1, 1000);
}

TEST(Partition, LeafSpringGuideByTheStageAndByBending) {
  const std::string text = scene_text("leaf_spring_guide");
  for (const char* dof : {"{element: leaf_1, mode: 2}", "{element: leaf_2, mode: 3}"}) {
    expect_same("leaf_spring_guide.yaml", text,
                with(text, "{node: stage_1, along: x}\n\n", std::string(dof) + "\n\n"), 0.1, 100);
  }
}

/// Springs without stiffness from posts on the table measure the mass along other directions.
TEST(Partition, TurningTableBySpringsAndByObliqueProbes) {
  const std::string text =
      with(scene_text("turning_table"), "stiffness: 1}", "stiffness: 1, damping: 0.1}");
  std::string probed = with(text, "  mass: {position: [0, 0]}\n",
                            "  mass: {position: [0, 0]}\n  post_1: {position: [0.7, 0.4]}\n"
                            "  post_2: {position: [-0.2, 0.9]}\n");
  probed = with(probed, "  spring_x: {type",
                "  holder_1: {type: rigid_beam, nodes: [table, post_1]}\n"
                "  holder_2: {type: rigid_beam, nodes: [table, post_2]}\n"
                "  probe_1: {type: truss, nodes: [post_1, mass], stiffness: 0}\n"
                "  probe_2: {type: truss, nodes: [post_2, mass], stiffness: 0}\n  spring_x: {type");
  probed = with(probed, "  - {element: spring_x}\n  - {element: spring_y}\n",
                "  - {element: probe_1}\n  - {element: probe_2}\n");
  expect_same("turning_table.yaml", text, probed, 0.01, 10);
}

/// The tip of a rotating blade by its deformations and by four probes from posts on the hub.
TEST(Partition, RotatingBladeByDeformationsAndByProbes) {
  const std::string text =
      with(with(divided(blade_without_twist(), 1), "deformation: blade/1", "deformation: blade"),
           "stress: blade/1", "stress: blade");
  const std::string damped =
      with(text, "second_order: true", "damping_time: 1e-3, second_order: true");
  std::string probed = damped;
  std::string nodes, elements, dofs = "dofs:\n";
  const char* posts[] = {"[0.8, 0.9, 0.1]", "[1, 0.2, 1.1]", "[1.4, -0.8, 0.1]",
                         "[1.3, 0.1, -0.9]"};
  const char* points[] = {"[1, 0.1, 0]", "[1.1, 0, 0.1]", "[1.3, 0, 0]", "[1.2, 0.1, 0.1]"};
  for (int i = 0; i < 4; ++i) {
    const std::string k = std::to_string(i + 1);
    nodes += "  post_" + k + ": {position: " + posts[i] + "}\n  point_" + k +
             ": {position: " + points[i] + "}\n";
    elements += "  holder_" + k + ": {type: rigid_beam, nodes: [hub, post_" + k + "]}\n  arm_" + k +
                ": {type: rigid_beam, nodes: [tip, point_" + k + "]}\n  probe_" + k +
                ": {type: truss, nodes: [post_" + k + ", point_" + k + "], stiffness: 0}\n";
    dofs += "  - {element: probe_" + k + "}\n";
  }
  probed = with(probed, "  tip: {position: [1, 0, 0]}\n", "  tip: {position: [1, 0, 0]}\n" + nodes);
  probed = with(probed, "  blade: {type", elements + "  blade: {type");
  probed = with(probed, "dofs:\n  - {deformations: blade}\n", dofs);
  expect_same("rotating_cantilever.yaml", damped, probed, 0.1, 1000);
}

}  // namespace
}  // namespace stillframe::verification

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <complex>
#include <numbers>
#include <string>

#include "core/errors/input_error.hpp"
#include "core/mechanics/frequency_response.hpp"
#include "core/mechanics/linearisation/linearisation.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "core/numerics/worst.hpp"
#include "tests/hard_cases/reached.hpp"

namespace stillframe::test {
namespace {

/// A planar frame on three legs. Their lines are y = x + 1 (through a), y = 1 - x (through b) and,
/// with a gap of 0, x = 0 (through c): they meet in (0, 1) and hold no rotation about it. A gap (m)
/// moves the foot of the third sideways.
std::string frame_on_three_legs(double gap, const std::string& dofs) {
  char foot[64];
  std::snprintf(foot, sizeof foot, "%.17g", gap);
  return std::string(R"(title: Three legs that nearly meet in one point
planar: true
nodes:
  body: {position: [0, 0]}
  a: {position: [-1, 0]}
  b: {position: [1, 0]}
  c: {position: [0, 0.5]}
  floor_a: {position: [-2, -1]}
  floor_b: {position: [2, -1]}
  floor_c: {position: [)") +
         foot + R"(, -1]}
masses:
  - {node: body, mass: 10, inertia: 2}
elements:
  arm_a: {type: rigid_beam, nodes: [body, a]}
  arm_b: {type: rigid_beam, nodes: [body, b]}
  arm_c: {type: rigid_beam, nodes: [body, c]}
  leg_a: {type: truss, nodes: [floor_a, a], stiffness: 1e6, damping: 100}
  leg_b: {type: truss, nodes: [floor_b, b], stiffness: 1e6, damping: 100}
  leg_c: {type: truss, nodes: [floor_c, c], stiffness: 1e6, damping: 100}
supports:
  - {nodes: [floor_a, floor_b, floor_c], fix: [x, y]}
inputs:
  - {name: push, force: body, along: x}
  - {name: drive, stress: leg_a}
outputs:
  - {name: x, position: body, along: x}
  - {name: a, acceleration: body, along: [1, 1, 0]}
  - {name: s, stress: leg_c}
dofs: )" +
         dofs + "\n";
}

constexpr const char* legs = "[{element: leg_a}, {element: leg_b}, {element: leg_c}]";
constexpr const char* body =
    "[{node: body, along: x}, {node: body, along: y}, {node: body, rotation: true}]";

using Quad = long double;
using Complex = std::complex<Quad>;

/// The same frame by hand in extended precision: E takes (x, y, phi) to the elongations, so that
/// M = diag(m, m, J), K = k E^T E and D = d E^T E; outputs x, (a_x + a_y) / sqrt(2) and sigma of
/// leg c, inputs a force along x and a driving stress of leg a.
Eigen::Matrix<Complex, 3, 2> exact(double gap, double frequency_hz) {
  using Matrix = Eigen::Matrix<Quad, 3, 3>;
  const Quad points[3][2] = {{-1, 0}, {1, 0}, {0, 0.5L}};
  const Quad feet[3][2] = {{-2, -1}, {2, -1}, {static_cast<Quad>(gap), -1}};
  Matrix E;
  for (int i = 0; i < 3; ++i) {
    const Quad dx = points[i][0] - feet[i][0], dy = points[i][1] - feet[i][1];
    const Quad l = std::sqrt(dx * dx + dy * dy);
    E.row(i) << dx / l, dy / l, (points[i][0] * dy - points[i][1] * dx) / l;
  }
  const Complex s(0, 2 * std::numbers::pi_v<Quad> * static_cast<Quad>(frequency_hz));
  const Complex leg = Quad(1e6) + s * Quad(100);
  Eigen::Matrix<Complex, 3, 3> Z = (E.transpose() * E).cast<Complex>() * leg;
  Z(0, 0) += s * s * Quad(10);
  Z(1, 1) += s * s * Quad(10);
  Z(2, 2) += s * s * Quad(2);
  Eigen::Matrix<Complex, 3, 2> force;
  force.col(0) << 1, 0, 0;
  force.col(1) = -E.row(0).transpose().cast<Complex>();
  const Eigen::Matrix<Complex, 3, 2> q = Z.fullPivLu().solve(force);
  Eigen::Matrix<Complex, 3, 2> G;
  G.row(0) = q.row(0);
  G.row(1) = s * s * (q.row(0) + q.row(1)) / std::sqrt(Quad(2));
  G.row(2) = leg * (E.row(2).cast<Complex>() * q);
  return G;
}

/// Largest error of any entry of G(s), relative to the largest in its row over both inputs.
double error_of(double gap, const char* dofs, double& condition) {
  const Scene scene = parse_scene(frame_on_three_legs(gap, dofs), "three legs");
  const LinearModel linear = linearise(make_model(scene), scene.inputs, scene.outputs);
  condition = condition_number(linear.M) * condition_number(linear.K);
  double worst = 0;
  for (const double f : logarithmic_frequencies(0.1, 1000, 60)) {
    const Eigen::MatrixXcd G = transfer_function(linear, {0, 2 * M_PI * f});
    const Eigen::MatrixXcd reference = exact(gap, f).cast<std::complex<double>>();
    for (Index i = 0; i < 3; ++i) {
      worst = worst_of(worst, (G - reference).row(i).norm() / reference.row(i).norm());
    }
  }
  return worst;
}

// A motion that hardly strains the legs is hardly resisted: its stiffness is gap^2 of the others,
// and K in the coordinates of the body, and M in those of the legs, have a condition number of
// 1 / gap^2. What is lost is epsilon times that; the elongations lose more, as their geometry has
// been inverted. 100: the size of the constants, over two decades of gap.
TEST(NearlySingularLegs, LoseEpsilonTimesTheConditionNumber) {
  for (const double gap : {1e-2, 1e-4, 1e-6}) {
    for (const auto& [name, dofs] : {std::pair("legs", legs), std::pair("body", body)}) {
      double condition = 0;
      const double error = error_of(gap, dofs, condition);
      char what[80];
      std::snprintf(what, sizeof what, "legs %.0e from singular, G(s), dofs: %s", gap, name);
      reached(what, error, condition);
      EXPECT_LE(error, 100 * 1e-16 * condition) << name << " " << gap;
      EXPECT_GT(condition, 1 / (gap * gap)) << "the case is not hard";
    }
  }
}

TEST(NearlySingularLegs, AreRefusedWhereTheyAreSingular) {
  EXPECT_THROW(make_model(parse_scene(frame_on_three_legs(0, legs), "singular")), InputError);
}

}  // namespace
}  // namespace stillframe::test

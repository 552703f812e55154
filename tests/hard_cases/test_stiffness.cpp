#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <cmath>
#include <string>

#include "core/mechanics/equilibrium.hpp"
#include "core/mechanics/modes.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "core/numerics/worst.hpp"
#include "tests/hard_cases/reached.hpp"

namespace stillframe::test {
namespace {

constexpr int n = 5;

/// Masses of 1 kg in a row on springs of 1, 1e3, 1e6, 1e9 and 1e12 N/m.
std::string row_of_masses(const std::string& dofs) {
  std::string nodes = "nodes:\n  m0: {position: [0, 0, 0]}\n", masses = "masses:\n",
              springs = "elements:\n", held = "m0";
  for (int i = 1; i <= n; ++i) {
    const std::string k = std::to_string(i);
    nodes += "  m" + k + ": {position: [" + k + ", 0, 0]}\n";
    masses += "  - {node: m" + k + ", mass: 1}\n";
    springs += "  s" + k + ": {type: truss, nodes: [m" + std::to_string(i - 1) + ", m" + k +
               "], stiffness: 1e" + std::to_string(3 * (i - 1)) + "}\n";
    held += ", m" + k;
  }
  return "title: Row of masses\n" + nodes + masses + springs + "supports:\n  - {nodes: [" + held +
         "], fix: [y, z]}\n  - {nodes: [m0], fix: [x]}\ndofs: " + dofs + "\n";
}

/// The natural frequencies (rad/s) are the singular values of S^(1/2) B, B = diag(1) - subdiagonal:
/// in extended precision, and of frequencies instead of their squares, 12 digits are left of the
/// smallest.
Eigen::Matrix<long double, n, 1> exact() {
  Eigen::Matrix<long double, n, n> B = Eigen::Matrix<long double, n, n>::Zero();
  for (int i = 0; i < n; ++i) {
    const long double root = std::sqrt(std::pow(10.0L, 3 * i));
    B(i, i) = root;
    if (i > 0) B(i, i - 1) = -root;
  }
  return B.jacobiSvd().singularValues().reverse();
}

double largest_error(const std::string& dofs, double& condition) {
  const Scene scene = parse_scene(row_of_masses(dofs), "row");
  const Model model = make_model(scene);
  const LinearModel linear = linearise(model, {}, {});
  condition = condition_number(linear.K);
  const Eigen::VectorXd omega = 2 * M_PI * modes(linear).natural_frequencies_hz;
  const auto reference = exact();
  double worst = 0;
  for (int i = 0; i < n; ++i) {
    worst = worst_of(worst, std::abs(omega(i) / static_cast<double>(reference(i)) - 1));
  }
  return worst;
}

// With the elongations as dofs every stiffness stands alone in K, and the frequencies are singular
// values of a graded matrix, which Jacobi's method finds to epsilon times the condition of what is
// left when the grading is taken out.
TEST(StiffnessRatio, OfTwelveDecadesCostsNothingWithDeformationsAsDofs) {
  std::string dofs = "[";
  for (int i = 1; i <= n; ++i) dofs += "{element: s" + std::to_string(i) + "}, ";
  double condition = 0;
  const double error = largest_error(dofs + "]", condition);
  reached("stiffness ratio 1e12, deformations as dofs", error, condition);
  EXPECT_LE(error, 1e-10);  // epsilon omega_max / omega_min = 2e-16 * 1e6, if nothing was graded
}

// With positions as dofs K holds the sums 1 + 1e3, 1e3 + 1e6, ...: the smallest stiffness keeps
// epsilon times the next one, here 1e-13, but through four such steps and a Cholesky factor.
TEST(StiffnessRatio, OfTwelveDecadesCostsDigitsWithPositionsAsDofs) {
  double condition = 0;
  const double error = largest_error("auto", condition);
  reached("stiffness ratio 1e12, positions as dofs", error, condition);
  EXPECT_LE(error, 1e-16 * 1e12);  // epsilon times the condition number of K
}

}  // namespace
}  // namespace stillframe::test

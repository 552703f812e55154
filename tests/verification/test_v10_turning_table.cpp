#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <complex>
#include <vector>

#include "core/mechanics/modes.hpp"
#include "core/mechanics/state_space.hpp"
#include "core/numerics/worst.hpp"
#include "tests/verification/scene_text.hpp"

// V10: a mass on two springs on a turning table. With z = x + j y on the table, w0 = 1 and the spin
// W, z'' + (d + 2 j W) z' + (1 - W^2) z = 0.
namespace stillframe::verification {
namespace {

using Complex = std::complex<double>;

std::string text_at(double spin, double damping) {
  const std::string text = with(scene_text("turning_table"), "rate: 0.1", "rate: " + number(spin));
  return with(text, "stiffness: 1}", "stiffness: 1, damping: " + number(damping) + "}");
}

/// Largest distance from a root to its nearest computed neighbour.
double distance(const std::vector<Complex>& roots, const Eigen::VectorXcd& computed) {
  double worst = 0;
  for (const Complex& root : roots)
    worst = worst_of(worst, (computed.array() - root).abs().minCoeff<Eigen::PropagateNaN>());
  return worst;
}

TEST(V10, PolesWithoutDampingStayOnTheImaginaryAxis) {
  for (const double spin : {0.0, 0.1, 0.5, 0.9, 1.5, 3.0}) {
    const Modes result = modes(linear_model(text_at(spin, 0)));
    const Complex j(0, 1);
    const double error = distance({j * (1 + spin), j * (1 - spin), -j * (1 + spin), j * (spin - 1)},
                                  result.eigenvalues);
    // Where the two pairs meet (no spin) rounding eps moves them by its square root.
    EXPECT_LE(error, spin == 0 ? 1e-7 : 1e-13) << spin;
    // Above the critical spin Coriolis forces keep stable what springs alone would not.
    EXPECT_LE(worst_of(result.eigenvalues.real()), spin == 0 ? 1e-7 : 1e-13) << spin;
  }
}

TEST(V10, DampingOnTheTableMakesItUnstableAboveTheCriticalSpin) {
  const double d = 0.05;
  for (const double spin : {0.1, 0.9, 0.999, 1.001, 1.5, 3.0}) {
    const Complex b(d, 2 * spin), root = std::sqrt(b * b - 4.0 * (1 - spin * spin));
    const Complex s_1 = (-b + root) / 2.0, s_2 = (-b - root) / 2.0;
    const Modes result = modes(linear_model(text_at(spin, d)));
    EXPECT_LE(distance({s_1, s_2, std::conj(s_1), std::conj(s_2)}, result.eigenvalues), 1e-13)
        << spin;
    EXPECT_EQ(result.eigenvalues.real().maxCoeff<Eigen::PropagateNaN>() > 0, spin > 1) << spin;
    EXPECT_EQ(result.n_growing, spin > 1 ? 2 : 0) << spin;
  }
}

/// Finite eigenvalues of [A - s I, B; C, D].
Eigen::VectorXcd transmission_zeros(const Eigen::MatrixXd& A, const Eigen::VectorXd& B,
                                    const Eigen::RowVectorXd& C, double D) {
  const Eigen::Index n = A.rows();
  Eigen::MatrixXd P(n + 1, n + 1), Q = Eigen::MatrixXd::Zero(n + 1, n + 1);
  P << A, B, C, Eigen::MatrixXd::Constant(1, 1, D);
  Q.topLeftCorner(n, n).setIdentity();
  const Eigen::GeneralizedEigenSolver<Eigen::MatrixXd> solver(P, Q, false);
  std::vector<Complex> finite;
  for (Eigen::Index i = 0; i <= n; ++i) {
    if (std::abs(solver.betas()(i)) > 1e-12)
      finite.push_back(solver.alphas()(i) / solver.betas()(i));
  }
  return Eigen::Map<Eigen::VectorXcd>(finite.data(), static_cast<Eigen::Index>(finite.size()));
}

TEST(V10, ZerosOfTheForceSensor) {
  for (const double spin : {0.1, 0.3}) {
    const LinearModel m = linear_model(text_at(spin, 0));
    const StateSpace s = state_space(m);
    const Eigen::VectorXcd zeros = transmission_zeros(s.A, s.B.col(0), s.C.row(0), s.D(0, 0));
    ASSERT_EQ(zeros.size(), 4);
    // No force: the spring keeps e = -sigma_a and the other one moves:
    // s^4 + (1 + 2 W^2) s^2 - W^2 (1 - W^2) = 0.
    const double p = 1 + 2 * spin * spin, q = spin * spin * (1 - spin * spin);
    const double real = std::sqrt((std::sqrt(p * p + 4 * q) - p) / 2),
                 imaginary = std::sqrt((std::sqrt(p * p + 4 * q) + p) / 2);
    EXPECT_LE(distance({real, -real, {0, imaginary}, {0, -imaginary}}, zeros), 1e-13);
    if (spin == 0.1) {  // half a unit of the last digit of the table
      EXPECT_NEAR(imaginary, 1.014700, 5e-7);
      EXPECT_NEAR(real, 0.098057, 5e-7);
    }
  }
}

}  // namespace
}  // namespace stillframe::verification

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "core/control/design/gain_design.hpp"
#include "core/errors/input_error.hpp"
#include "core/numerics/balance.hpp"
#include "tests/core/random_pairs.hpp"

// Poles against those of the plant with the state space of the law, and against det(I - G_22 C) =
// 0.
namespace stillframe::test {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;

constexpr double omega_d = 20, zeta = 0.7;

LegMatrices three_legs() {
  std::mt19937 engine(51);
  return {random_spd(3, 20, engine), 1e4 * random_spd(3, 20, engine)};
}

struct Law {
  const char* name;
  double leak, high_pass, roll_off;
  Index poles_a_leg;
};

constexpr Law laws[] = {
    {"leak", 0.4, 0, 0, 3},
    {"high-pass", 0, 0.4, 0, 3},
    {"leak and high-pass", 0.4, 0.9, 0, 4},
    {"leak and roll-off", 0.4, 0, 900, 4},
    {"high-pass and roll-off", 0, 0.4, 900, 4},
    {"all three", 0.4, 0.9, 900, 5},
};

ForceFeedback gains_of(const LegMatrices& legs, const Law& law, GainOrder order) {
  ForceFeedback gains = design_gains(legs, omega_d, zeta, order, law.leak);
  gains.high_pass = law.high_pass;
  gains.roll_off = law.roll_off;
  return gains;
}

/// Eigenvalues of q'' = -M^-1 (K q + u) with the law on the strain forces K q, u = F K q.
VectorXcd by_state_space(const LegMatrices& legs, const ForceFeedback& gains) {
  const LinearSystem law = strain_feedback(gains);
  const Index m = legs.M.rows(), n = law.A.rows();
  const Eigen::LLT<MatrixXd> M(legs.M);
  MatrixXd A = MatrixXd::Zero(2 * m + n, 2 * m + n);
  A.block(0, m, m, m) = MatrixXd::Identity(m, m);
  A.block(m, 0, m, m) = -M.solve(legs.K + law.D * legs.K);
  A.block(m, 2 * m, m, n) = -M.solve(law.C);
  A.block(2 * m, 0, n, m) = law.B * legs.K;
  A.block(2 * m, 2 * m, n, n) = law.A;
  return balanced(A).eigenvalues();
}

TEST(ClosedLoopPoles, AreThoseOfThePlantWithTheStateSpaceOfTheLaw) {
  const LegMatrices legs = three_legs();
  for (const GainOrder order : {GainOrder::exact, GainOrder::deck}) {
    for (const Law& law : laws) {
      const ForceFeedback gains = gains_of(legs, law, order);
      const VectorXcd poles = closed_loop_poles(legs, gains, omega_d);
      const VectorXcd expected = by_state_space(legs, gains);
      ASSERT_EQ(poles.size(), 3 * law.poles_a_leg) << law.name;
      ASSERT_EQ(expected.size(), poles.size()) << law.name;
      // Matrices of about 1e4 (K M^-1 / omega_d), eigenvectors of condition 1e2 or so, in doubles.
      for (const Complex pole : poles) {
        EXPECT_LE((expected.array() - pole).abs().minCoeff(), 1e-9 * omega_d) << law.name;
      }
      for (const Complex pole : expected) {
        EXPECT_LE((poles.array() - pole).abs().minCoeff(), 1e-9 * omega_d) << law.name;
      }
    }
  }
}

TEST(ClosedLoopPoles, MakeTheReturnDifferenceSingular) {
  const LegMatrices legs = three_legs();
  const MatrixXcd K = legs.K.cast<Complex>(), M = legs.M.cast<Complex>();
  for (const Law& law : laws) {
    const ForceFeedback gains = gains_of(legs, law, GainOrder::exact);
    const auto smallest = [&](Complex s) -> double {
      // sigma = G_22 u + ..., G_22 = s^2 M (s^2 M + K)^-1.
      const MatrixXcd G_22 = s * s * M * (s * s * M + K).inverse();
      return (MatrixXcd::Identity(3, 3) - G_22 * gains(s)).jacobiSvd().singularValues()(2);
    };
    for (const Complex s : closed_loop_poles(legs, gains, omega_d)) {
      // Linear in the distance: a pole that were wrong by 1e-6 would show. The formula loses some
      // eight digits of its own, where slow poles meet the almost perfect cancellation of the
      // roll-off with 1.
      EXPECT_LE(smallest(s), 1e-4 * smallest(1.01 * s)) << law.name << " " << s;
    }
  }
}

TEST(ClosedLoopPoles, DoNotDependOnTheScaleOfTheStates) {
  const LegMatrices legs = three_legs();
  const ForceFeedback gains = gains_of(legs, laws[5], GainOrder::deck);
  const VectorXcd a = closed_loop_poles(legs, gains, omega_d);
  const VectorXcd b = closed_loop_poles(legs, gains, 1e6 * omega_d);
  for (const Complex pole : a) {
    EXPECT_LE((b.array() - pole).abs().minCoeff<Eigen::PropagateNaN>(),
              4e-16 * std::abs(pole));  // two roundings
  }
}

TEST(ClosedLoopPoles, RefuseALoopWithoutLaw) {
  const LegMatrices legs = three_legs();
  ForceFeedback gains = gains_of(legs, laws[0], GainOrder::exact);
  gains.K_P = -MatrixXd::Identity(3, 3);  // cancels every force: I + K_P = 0
  EXPECT_THROW(closed_loop_poles(legs, gains, omega_d), Refusal);
  gains.K_P.setZero();
  EXPECT_THROW(closed_loop_poles({MatrixXd::Zero(3, 3), legs.K}, gains, omega_d), Refusal);
}

}  // namespace
}  // namespace stillframe::test

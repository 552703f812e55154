#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <string>

#include "core/control/design/gain_design.hpp"
#include "core/errors/input_error.hpp"
#include "tests/core/random_pairs.hpp"

// More legs than dofs, and fewer: what the gains are designed for, and what they then do.
namespace stillframe::test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

constexpr double omega_d = 20, zeta = 0.7;

MatrixXd random_matrix(Index rows, Index columns, std::mt19937& engine) {
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(rows, columns, [&]() -> double { return normal(engine); });
}

/// A frame of n dofs on m legs of stiffnesses S and, where they are fewer, on passive springs too.
struct Frame {
  MatrixXd M, K, E, S;

  Frame(Index m, Index n, unsigned seed) {
    std::mt19937 engine(seed);
    M = random_spd(n, 30, engine);
    E = random_matrix(m, n, engine);
    S = 1e4 *
        VectorXd(random_matrix(m, 1, engine).array().abs() + 0.5).asDiagonal().toDenseMatrix();
    K = E.transpose() * S * E;
    if (m < n) K += 1e4 * random_spd(n, 10, engine);
  }

  /// The same with q^d = T q.
  Frame by(const MatrixXd& T) const {
    Frame other = *this;
    const MatrixXd inverse = T.inverse();
    other.M = inverse.transpose() * M * inverse;
    other.K = inverse.transpose() * K * inverse;
    other.E = E * inverse;
    return other;
  }
};

ForceFeedback gains_of(const Frame& frame, Reduction reduction = Reduction::modes) {
  return design_gains(design_model(frame.M, frame.K, frame.E, reduction), {{omega_d, zeta}},
                      GainOrder::exact);
}

/// Eigenvalues of the whole frame with a PI law on its legs, from
///   M q'' = -E^T sigma - (K - E^T S E) q,  (I + K_P) sigma' = S E q' - K_I sigma
/// in doubles, smallest modulus first.
VectorXcd poles_of_frame(const Frame& frame, const ForceFeedback& gains) {
  const Index n = frame.M.rows(), m = frame.E.rows();
  const MatrixXd I = MatrixXd::Identity(m, m),
                 K_rest = frame.K - frame.E.transpose() * frame.S * frame.E;
  const Eigen::PartialPivLU<MatrixXd> X(I + gains.K_P);
  const Eigen::LLT<MatrixXd> M(frame.M);
  MatrixXd A = MatrixXd::Zero(2 * n + m, 2 * n + m);
  A.block(0, n, n, n) = MatrixXd::Identity(n, n);
  A.block(n, 0, n, n) = -M.solve(K_rest);
  A.block(n, 2 * n, n, m) = -M.solve(frame.E.transpose());
  A.block(2 * n, n, m, n) = X.solve(frame.S * frame.E);
  A.block(2 * n, 2 * n, m, m) = -X.solve(gains.K_I);
  VectorXcd poles = A.eigenvalues();
  std::sort(poles.begin(), poles.end(), [](auto a, auto b) { return std::abs(a) < std::abs(b); });
  return poles;
}

// The matrices here have conditions of 1e3 at most: eps times that and the 20-fold sums of their
// products is below 1e-11, which is the tolerance of what follows unless it says otherwise.
constexpr double rounding = 1e-11;

TEST(RedundantLegs, AllPolesStandOnTheTargetAndSelfStressIsLeftAlone) {
  const Frame frame(8, 6, 31);
  const ForceFeedback gains = gains_of(frame);
  ASSERT_EQ(gains.K_P.rows(), 8);
  const VectorXcd poles = poles_of_frame(frame, gains);
  // 6 integrators and the 2 states of self-stress at zero, sqrt(eps) apart from it where they make
  // Jordan blocks with the position; twelve on the target.
  EXPECT_LE(std::abs(poles(7)), 1e-5 * omega_d);
  EXPECT_LE(distance_from_target(poles.tail(12), omega_d, zeta), rounding);
  // Self-stress: sums of legs that load no dof.
  const MatrixXd Z = Eigen::FullPivLU<MatrixXd>(frame.E.transpose()).kernel();
  ASSERT_EQ(Z.cols(), 2);
  for (const MatrixXd& K : {gains.K_P, gains.K_I}) {
    EXPECT_LE((K * Z).norm(), rounding * K.norm() * Z.norm());              // is not measured
    EXPECT_LE((Z.transpose() * K).norm(), rounding * K.norm() * Z.norm());  // and not made
  }
  EXPECT_GT((MatrixXd::Identity(8, 8) + gains.K_P).fullPivLu().rank(), 7);
}

TEST(RedundantLegs, ForcesAreThoseOfLeastSquaresForTheDesignInTheDofs) {
  const Frame frame(8, 6, 32);
  const ForceFeedback gains = gains_of(frame);
  const MatrixXd X = frame.M.llt().solve(frame.K).transpose() / (omega_d * omega_d);
  const MatrixXd share = frame.E * (frame.E.transpose() * frame.E).inverse();
  const MatrixXd K_P = share * (X - MatrixXd::Identity(6, 6)) * frame.E.transpose();
  const MatrixXd K_I = 2 * zeta * omega_d * share * X * frame.E.transpose();
  EXPECT_LE(relative_error(gains.K_P, K_P), rounding);
  EXPECT_LE(relative_error(gains.K_I, K_I), rounding);
}

TEST(RedundantLegs, AsManyLegsAsDofsIsTheSameFormula) {
  const Frame frame(6, 6, 33);
  const ForceFeedback gains = gains_of(frame);
  const LegMatrices legs = leg_matrices(frame.M, frame.K, frame.E);
  EXPECT_EQ(gains.K_P, design_gains(legs, omega_d, zeta, GainOrder::exact, 0).K_P);
  // Statically determinate: the stiffness of the legs is their own.
  EXPECT_LE(relative_error(legs.K, frame.S), rounding);
  const MatrixXd inverse = frame.E.inverse();
  EXPECT_LE(relative_error(legs.M, MatrixXd(inverse.transpose() * frame.M * inverse)), rounding);
  EXPECT_LE(distance_from_target(poles_of_frame(frame, gains).tail(12), omega_d, zeta), rounding);
}

TEST(LegReduction, GainsDoNotDependOnTheChoiceOfTheDofs) {
  std::mt19937 engine(34);
  const MatrixXd T = random_matrix(6, 6, engine);
  for (const Index m : {3, 6, 8}) {
    const Frame frame(m, 6, 35);
    for (const Reduction reduction : {Reduction::modes, Reduction::static_shapes}) {
      const ForceFeedback here = gains_of(frame, reduction),
                          there = gains_of(frame.by(T), reduction);
      // T of condition 1e2 or so enters twice.
      EXPECT_LE(relative_error(there.K_P, here.K_P), 1e2 * rounding) << m;
      EXPECT_LE(relative_error(there.K_I, here.K_I), 1e2 * rounding) << m;
    }
  }
}

TEST(FewerLegs, OnTheSlowestModesTheModelHasThese) {
  const Frame frame(3, 6, 36);
  const LegMatrices legs = design_model(frame.M, frame.K, frame.E, Reduction::modes).legs;
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> whole(frame.K, frame.M);
  const VectorXd frequencies = virtual_frequencies(legs);
  for (Index i = 0; i < 3; ++i) {
    EXPECT_NEAR(frequencies(i) / std::sqrt(whole.eigenvalues()(i)), 1, rounding);
  }
  const MatrixXd inverse = (frame.E * whole.eigenvectors().leftCols(3)).inverse();
  EXPECT_LE(relative_error(legs.M, MatrixXd(inverse.transpose() * inverse)), 1e2 * rounding);
  // Two of the three modes, moving alone, are felt by the legs as the model says.
  for (Index i = 0; i < 3; ++i) {
    const VectorXd e = frame.E * whole.eigenvectors().col(i);
    EXPECT_LE((legs.K * e - whole.eigenvalues()(i) * legs.M * e).norm(),
              1e2 * rounding * (legs.K * e).norm());
    EXPECT_NEAR(e.dot(legs.M * e), 1, 1e2 * rounding);
  }
}

TEST(FewerLegs, OnStaticShapesTwoMomentsOfTheComplianceAgree) {
  const Frame frame(3, 6, 37);
  const LegMatrices legs = design_model(frame.M, frame.K, frame.E, Reduction::static_shapes).legs;
  const auto whole = [&](double s2) -> MatrixXd {
    return frame.E * (s2 * frame.M + frame.K).ldlt().solve(frame.E.transpose());
  };
  const auto reduced = [&](double s2) -> MatrixXd { return (s2 * legs.M + legs.K).inverse(); };
  EXPECT_LE(relative_error(reduced(0), whole(0)), rounding);
  // What is left is of the order s^4: a sixteenth of s^2 makes it 256 times smaller. The highest
  // s^2 is a hundredth of the slowest mode's.
  const double slow = std::pow(virtual_frequencies(legs)(0), 2) / 100;
  const double far = relative_error(reduced(slow), whole(slow));
  const double near = relative_error(reduced(slow / 16), whole(slow / 16));
  EXPECT_NEAR(std::log2(far / near), 8, 0.1);  // 8 but for terms of the order s^6
  EXPECT_GT(far, 1e-8);                        // not all rounding
  // Of the mode that the legs feel slowest, Rayleigh's quotient is too high, if at all.
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> all(frame.K, frame.M);
  EXPECT_GE(virtual_frequencies(legs)(0), std::sqrt(all.eigenvalues()(0)));
}

/// Two oscillators that know nothing of each other, 1 kg on 100 N/m and 1 kg on 900 N/m.
TEST(FewerLegs, AModeThatStrainsNoLegIsRefusedByNameAndStaticShapesGetBy) {
  const MatrixXd M = MatrixXd::Identity(2, 2), K = VectorXd{{100.0, 900.0}}.asDiagonal();
  const MatrixXd E{{0.0, 1.0}};
  try {
    design_model(M, K, E, Reduction::modes);
    FAIL() << "no Refusal";
  } catch (const Refusal& refusal) {
    const std::string text = refusal.what();
    EXPECT_NE(text.find("a motion of dof 1 strains none of them; take other legs, or reduce by "
                        "static_shapes"),
              std::string::npos)
        << text;
    // Of K alone, which is not the frame's where weight and preload count.
    EXPECT_EQ(text.find("Hz"), std::string::npos) << text;
  }
  const LegMatrices legs = design_model(M, K, E, Reduction::static_shapes).legs;
  EXPECT_NEAR(legs.M(0, 0), 1, 1e-15);  // a few roundings
  EXPECT_NEAR(legs.K(0, 0), 900, 1e-12);
}

template <class F>
std::string refusal_of(const F& f) {
  try {
    f();
  } catch (const Refusal& refusal) {
    return refusal.what();
  }
  return "accepted";
}

TEST(LegReduction, WhatTheLegsCannotDoIsRefusedInWords) {
  const MatrixXd I2 = MatrixXd::Identity(2, 2), I3 = MatrixXd::Identity(3, 3);
  const DesignNames names{.dofs = {"x(lens)", "y(lens)", "z(lens)"}, .legs = {"left", "right"}};
  const auto refused = [&](const MatrixXd& M, const MatrixXd& K, const MatrixXd& E,
                           Reduction reduction = Reduction::modes) {
    return refusal_of([&] { design_model(M, K, E, reduction, names); });
  };
  // Legs that move as one are no help against y, whether they are as many as the dofs or more.
  const std::string still = "a motion of y(lens) strains none of them";
  EXPECT_NE(refused(I2, I2, MatrixXd{{1, 0}, {2, 0}}).find(still), std::string::npos);
  EXPECT_NE(refused(I2, I2, MatrixXd{{1, 0}, {2, 0}, {3, 0}})
                .find(still + "; take legs that strain it, or leave 2 of the 3 legs out"),
            std::string::npos);
  EXPECT_NE(refused(I3, I3, MatrixXd{{1, 1, 0}, {2, 2, 0}})
                .find("the elongations of left and right depend on each other"),
            std::string::npos);
  // By a hair they do not, as where a weight bends the frame: every motion has its stiffness.
  const std::string hair =
      refused(I3, I3, MatrixXd{{1, 1, 0}, {2, 2, 1e-9}}, Reduction::static_shapes);
  EXPECT_NE(hair.find("the elongations of left and right depend on each other"), std::string::npos)
      << hair;
  EXPECT_EQ(hair.find("without stiffness"), std::string::npos) << hair;
  const MatrixXd K = VectorXd{{1.0, 4.0, 4.0}}.asDiagonal();
  const MatrixXd both{{1, 1, 0}, {0, 1, 1}};
  EXPECT_NE(refused(I3, K, both).find("2 legs cannot tell mode 2 (0.31831 Hz) from mode 3"),
            std::string::npos);
  EXPECT_EQ(refused(I3, K, both, Reduction::static_shapes), "accepted");
  EXPECT_NE(refused(I3, VectorXd{{0.0, 4.0, 5.0}}.asDiagonal(), both, Reduction::static_shapes)
                .find("such a motion is one of x(lens): give it a spring"),
            std::string::npos);
  // Static shapes would refuse it as well.
  EXPECT_NE(refused(I3, VectorXd{{0.0, 4.0, 5.0}}.asDiagonal(), MatrixXd{{0, 1, 0}, {0, 0, 1}})
                .find("a motion of x(lens) strains none of them; take other legs, or give it a "
                      "spring"),
            std::string::npos);
  EXPECT_NE(
      refused(VectorXd{{1.0, 0.0}}.asDiagonal(), I2, MatrixXd{{1, 1}, {0, 1}}).find("mass matrix"),
      std::string::npos);
  EXPECT_NE(
      refusal_of([&] { leg_matrices(I2, I2, both.topLeftCorner(1, 2)); }).find("as many legs"),
      std::string::npos);
  EXPECT_THROW(design_model(I2, I3, I2), std::invalid_argument);
}

TEST(LegReduction, LegsThatAreDependentToRoundingAreRefused) {
  std::mt19937 engine(38);
  for (int k = 0; k < 20; ++k) {
    // Of rank 2, but for the rounding of its entries.
    const MatrixXd E = random_matrix(3, 2, engine) * random_matrix(2, 3, engine);
    const MatrixXd I = MatrixXd::Identity(3, 3);
    EXPECT_THROW(leg_matrices(I, I, E), Refusal);
  }
}

TEST(LegReduction, StaticShapesNeedAStiffnessBeyondRounding) {
  std::mt19937 engine(39);
  for (int k = 0; k < 20; ++k) {
    // Of rank 2, but for rounding, which makes about half of them positive definite.
    const MatrixXd A = random_matrix(3, 2, engine), E = random_matrix(2, 3, engine);
    EXPECT_THROW(
        design_model(MatrixXd::Identity(3, 3), A * A.transpose(), E, Reduction::static_shapes),
        Refusal);
  }
}

TEST(LegReduction, AlmostDependentLegsAreNotRefused) {
  // A thousand times above the threshold of 1e-12: the gains are large, and it is for the analysis
  // to say what they do.
  const MatrixXd E{{1, 1}, {1, 1 + 1e-9}};
  const LegMatrices legs = leg_matrices(MatrixXd::Identity(2, 2), MatrixXd::Identity(2, 2), E);
  // E^-T E^-1 = (E E^T)^-1, whose trace is |E|^2 / det(E)^2; 1 + 1e-9 has an ulp of 2e-16.
  EXPECT_NEAR(legs.M.trace() * std::pow(E(1, 1) - 1, 2) / E.squaredNorm(), 1, 1e-14);
}

}  // namespace
}  // namespace stillframe::test

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>
#include <random>

#include "core/mechanics/modes.hpp"
#include "core/mechanics/own_values.hpp"

namespace stillframe::test {
namespace {

using Complex = std::complex<double>;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Springs and dampers between masses, in coordinates of which the elongations are E q.
LinearModel model_of(const MatrixXd& M, const MatrixXd& E, const VectorXd& c, const VectorXd& k) {
  LinearModel model;
  model.M = M;
  model.D = E.transpose() * c.asDiagonal() * E;
  model.K = E.transpose() * k.asDiagonal() * E;
  model.C = model.N = model.G = MatrixXd::Zero(M.rows(), M.rows());
  model.q_names.assign(static_cast<size_t>(M.rows()), "q");
  return model;
}

/// An oscillator (m, c, k), and 1 kg on 1000 N/m beside it with a damper of any strength: x_1 = q_1
/// + q_2, x_2 = q_2, so that it shows in none of the entries, which are exact.
LinearModel beside(double c, double k, double damper) {
  const Eigen::Matrix2d T{{1, 1}, {0, 1}};
  return model_of(T.transpose() * T, T, Eigen::Vector2d(c, damper), Eigen::Vector2d(k, 1000));
}

// The overdamped pole is 1e3 to 1e13 times as fast. Both slow motions keep what they are known to.
TEST(OwnValues, SlowMotionsBesideAStrongDamperAreNoZeros) {
  for (const double damper : {1e3, 1e7, 1e10, 1e13}) {
    const Modes found = modes(beside(0.1, 1, damper));
    const Complex slow(-0.05, std::sqrt(1 - 0.0025));
    const double root = std::sqrt(damper * damper / 4 - 1000), creeps = -1000 / (damper / 2 + root);
    int seen = 0;
    for (Index i = 0; i < 4; ++i) {
      const Complex s = found.eigenvalues(i);
      // Two units of the last place, of numbers whose entries are exact.
      if (s.imag() > 0) {
        EXPECT_LE(std::abs(s - slow), 1e-15) << damper;
        EXPECT_NEAR(found.damping_ratios(i / 2), 0.05, 1e-15) << damper;
        ++seen;
      }
      if (s.imag() == 0 && std::abs(s) < damper / 2) {
        EXPECT_NEAR(s.real() / creeps, 1, 1e-15) << damper;
        EXPECT_EQ(found.damping_ratios(i / 2), 1.0) << damper;
        ++seen;
      }
    }
    EXPECT_EQ(seen, 2) << damper;
    EXPECT_EQ(found.n_growing, 0);
    EXPECT_EQ(own_frequencies_hz(beside(0.1, 1, damper)).size(), 3) << damper;
  }
}

TEST(OwnValues, SlowGrowthBesideAStrongDamperIsSeen) {
  for (const double damper : {0.0, 1e7, 1e12}) {
    LinearModel model = beside(0, -0.03, damper);
    model.C(0, 1) = 1e-30;  // in motion, or it would be refused
    model.C(1, 0) = -1e-30;
    const Modes found = modes(model);
    EXPECT_EQ(found.n_growing, 1) << damper;
    EXPECT_EQ(found.damping_ratios.minCoeff(), -1) << damper;
  }
}

LinearModel of_unit_masses(Index n) {
  const MatrixXd I = MatrixXd::Identity(n, n);
  return model_of(I, I, VectorXd::Zero(n), VectorXd::Ones(n));
}

// From a start without these terms, 1 rad/s for both, refinement would not find the way.
TEST(OwnValues, TurningAndWeightCountFromTheStart) {
  // (1 - omega^2)^2 = (50 omega)^2.
  LinearModel turning = of_unit_masses(2);
  turning.C << 0, 50, -50, 0;
  const double fast = 25 + std::sqrt(626.0);
  VectorXd found = 2 * M_PI * own_frequencies_hz(turning);
  ASSERT_EQ(found.size(), 2);
  EXPECT_NEAR(found(0), 1 / fast, 1e-14 / fast);
  EXPECT_NEAR(found(1), fast, 1e-14 * fast);
  // Weight takes all but 2^-14 of the stiffness of one, exact in its entry, and adds to the other.
  LinearModel heavy = of_unit_masses(2);
  heavy.G.diagonal() << std::ldexp(1, -14) - 1, 99;
  found = 2 * M_PI * own_frequencies_hz(heavy);
  ASSERT_EQ(found.size(), 2);
  EXPECT_NEAR(found(0), std::ldexp(1, -7), std::ldexp(1e-14, -7));
  EXPECT_NEAR(found(1), 10, 1e-13);
}

MatrixXd rotation(std::mt19937_64& random, Index n) {
  std::normal_distribution<double> normal;
  const MatrixXd any = MatrixXd::NullaryExpr(n, n, [&] { return normal(random); });
  return Eigen::HouseholderQR<MatrixXd>(any).householderQ();
}

/// A chain of masses, free or with its first spring at a wall, in coordinates at random.
LinearModel chain(std::mt19937_64& random, Index n, bool free, double decades) {
  std::uniform_real_distribution<double> part(-0.5, 0.5);
  const auto spread = [&] { return std::pow(10.0, decades * part(random)); };
  const MatrixXd Q = rotation(random, n);
  MatrixXd E = MatrixXd::Identity(n, n);
  E.diagonal(-1).setConstant(-1);
  VectorXd m(n), k(n), c(n);
  for (Index i = 0; i < n; ++i) {
    m(i) = std::pow(10.0, part(random));
    k(i) = spread();
    c(i) = 2 * spread() * std::sqrt(k(i));
  }
  if (free) k(0) = c(0) = 0;
  const MatrixXd M = Q.transpose() * m.asDiagonal() * Q;
  return model_of((M + M.transpose()) / 2, E * Q, c, k);
}

// With what turning and weight add, symmetric or not: the sums of the eigenvalues and of their
// squares are traces, which they have only if each is found, and once.
TEST(OwnValues, OfMovingModelsHaveTheTracesOfTheStateMatrix) {
  std::mt19937_64 random(6);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int round = 0; round < 40; ++round) {
    const Index n = 2 + round % 5;
    LinearModel model = chain(random, n, false, 1);
    const auto any = [&] { return MatrixXd::NullaryExpr(n, n, [&] { return unit(random); }); };
    const MatrixXd turning = any();
    model.C = 10 * (turning - turning.transpose());
    model.N = 3 * any();
    model.G = 3 * any();
    const Eigen::PartialPivLU<MatrixXd> mass(model.M);
    const MatrixXd damping = mass.solve(model.damping()), stiffness = mass.solve(model.stiffness());
    const OwnValues own = own_values(model);
    const VectorXd moduli = own.values.cwiseAbs();
    // Twenty times what rounding was seen to do to such sums.
    const double largest = moduli.maxCoeff(), known = 2e-14;
    EXPECT_LE(std::abs(own.values.sum() + damping.trace()), known * largest) << round;
    const Complex squares = own.values.array().square().sum();
    EXPECT_LE(std::abs(squares - (damping * damping).trace() + 2 * stiffness.trace()),
              known * largest * largest)
        << round;
    // Of neighbours that are real the first is the smaller one.
    for (Index i = 2; i < 2 * n; i += 2) EXPECT_LE(moduli(i - 2), moduli(i)) << round;
  }
}

int zeros(const OwnValues& own) {
  int count = 0;
  for (Index i = 0; i < own.values.size(); ++i) count += own.is_zero(i);
  return count;
}

// A free chain has one free motion, which is a double zero, defective: rounding leaves it the root
// of epsilon. What it has beside that, and a chain at a wall, is no zero. 40 masses are more than
// twice the working precision is taken for.
TEST(OwnValues, FreeMotionsAreZerosAndNothingElseIs) {
  std::mt19937_64 random(4);
  for (int round = 0; round < 60; ++round) {
    const Index n = round % 20 == 19 ? 40 : 2 + round % 6;
    const bool free = round % 2 == 1;
    LinearModel model = chain(random, n, free, 6);
    if (round % 3 == 0) model.D.setZero();
    const OwnValues own = own_values(model);
    EXPECT_EQ(zeros(own), free ? 2 : 0) << round;
    for (Index i = 0; i < own.values.size(); ++i) {
      EXPECT_LE(own.values(i).real(), own.known_to(i)) << round << " " << own.values(i);
    }
    EXPECT_EQ(modes(model).n_growing, 0) << round;
  }
}

// Entries that are moved by a rounding each, of what their terms are, move no eigenvalue further
// than it is said to be known; most of them by no less than a ten-thousandth of it, a tenth of what
// it was seen to be, or the bound would say nothing and what only is slow would be taken for zero.
TEST(OwnValues, AreKnownToWhatRoundingOfTheEntriesDoes) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(-2.2e-16, 2.2e-16);
  int telling = 0, all = 0;
  for (int round = 0; round < 40; ++round) {
    const LinearModel model = chain(random, 2 + round % 5, round % 4 == 3, 6);
    LinearModel other = model;
    for (MatrixXd* block : {&other.M, &other.D, &other.K}) {
      const VectorXd size = block->diagonal().cwiseSqrt();
      for (Index i = 0; i < size.size(); ++i) {
        for (Index j = 0; j <= i; ++j) {
          (*block)(i, j) += unit(random) * size(i) * size(j);
          (*block)(j, i) = (*block)(i, j);
        }
      }
    }
    const OwnValues one = own_values(model), two = own_values(other);
    for (Index i = 0; i < one.values.size(); ++i) {
      double moved = INFINITY;
      for (const Complex& value : two.values) {
        moved = std::min(moved, std::abs(value - one.values(i)));
      }
      EXPECT_LE(moved, one.known_to(i)) << round << " " << one.values(i);
      telling += moved >= 1e-4 * one.known_to(i);
      ++all;
    }
  }
  EXPECT_GE(telling, 0.8 * all);
}

// A force that weight and motion balance is no smaller for it: where terms of 1e6 leave one, moving
// one of them by a rounding moves the eigenvalue 1 by 1e6 / 2 roundings.
TEST(OwnValues, TermsThatCancelAreKnownNoBetterThanEach) {
  LinearModel model = of_unit_masses(2);
  model.G.diagonal().setConstant(1e6);
  model.N.diagonal().setConstant(-1e6);
  const OwnValues own = own_values(model);
  for (Index i = 0; i < 4; ++i) {
    EXPECT_NEAR(std::abs(own.values(i)), 1, 1e-15);
    EXPECT_GE(own.known_to(i), 1e6 / 2 * 2.2e-16);
  }
}

// Nothing couples them, but directions of elements are known to epsilon only, and so is what of the
// fast one's stiffness may be the slow one's.
TEST(OwnValues, AreKnownToEpsilonOfTheFastestAtBest) {
  LinearModel model = of_unit_masses(2);
  model.K.diagonal() << 1e-6, 1e12;
  const OwnValues own = own_values(model);
  EXPECT_NEAR(own.known_to(0), 1e6 * std::ldexp(1, -52), 1e-12 * own.known_to(0));
  EXPECT_FALSE(own.is_zero(0));
}

TEST(OwnValues, FrequenciesAreModuliWithoutWhatIsZero) {
  // A free body, an oscillator of 3 rad/s, damped, and one that creeps: s^2 + 200 s + 100.
  const LinearModel model = model_of(MatrixXd::Identity(3, 3), MatrixXd::Identity(3, 3),
                                     Eigen::Vector3d(0, 0.6, 200), Eigen::Vector3d(0, 9, 100));
  const VectorXd found = 2 * M_PI * own_frequencies_hz(model);
  ASSERT_EQ(found.size(), 3);
  EXPECT_NEAR(found(0), 100 / (100 + std::sqrt(9900.0)), 1e-14);
  EXPECT_NEAR(found(1), 3, 1e-14);
  EXPECT_NEAR(found(2), 100 + std::sqrt(9900.0), 1e-12);
}

}  // namespace
}  // namespace stillframe::test

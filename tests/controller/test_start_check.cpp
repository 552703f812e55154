#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <cstdio>
#include <optional>
#include <random>

#include "controller/law.hpp"
#include "controller/start_check.hpp"
#include "core/errors/input_error.hpp"
#include "core/numerics/balance.hpp"
#include "core/numerics/worst.hpp"
#include "core/systems/sampled_loop.hpp"
#include "tests/controller/loop_simulation.hpp"
#include "tests/controller/toy_plant.hpp"

namespace stillframe::controller {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

double radius_of(const MatrixXd& A) { return worst_of(balanced(A).eigenvalues()); }

Gains naive(double design_hz, double rate_hz, int delay) {
  Gains gains = toy::gains(design_hz, rate_hz, delay);
  gains.realisation = Realisation::naive_pi;
  return gains;
}

// How the toy loop grows a sample, measured by running it from a random state.
double measured_growth(const Gains& gains, int settle, int measure) {
  toy::LoopSimulation loop(gains, law_from_gains(gains), gains.delay_samples);
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  loop.state() = VectorXd::NullaryExpr(loop.size(), [&] { return normal(random); });
  double log_growth = 0;
  for (int k = 0; k < settle + measure; ++k) {
    loop.step();
    const double norm = loop.state().norm();
    if (k >= settle) log_growth += std::log(norm);
    loop.state() /= norm;
  }
  return std::exp(log_growth / measure);
}

class Rates : public testing::TestWithParam<double> {};

// THEORY fact 3: the sampled PI is a loop of gain K_P around its delay, at every rate.
TEST_P(Rates, NaivePiIsUnstableWithTheLargestEigenvalueOfItsGain) {
  for (const double design_hz : {1.0, 5.0, 10.0}) {
    for (const int delay : {0, 1}) {
      const Gains gains = naive(design_hz, GetParam(), delay);
      const double radius = closed_loop_radius(gains);
      // |z|^(delay + 1) is the gain K_P and half a sample of K_I, which is up to 5 % at 1 kHz.
      const double gain = gains.K_P.diagonal().maxCoeff();
      EXPECT_NEAR(std::pow(radius, delay + 1), gain, 0.05 * gain);
      // The loop simulated in time grows by the same factor. 200 samples forget all other modes.
      EXPECT_NEAR(measured_growth(gains, 400, 1000), radius, 0.01 * radius);
      EXPECT_THROW(require_stable(gains), Refusal);
    }
  }
}

TEST_P(Rates, ImplicitFeedthroughIsStableEvenWithEverythingALittleWrong) {
  for (const double design_hz : {1.0, 2.0, 5.0}) {
    for (const int delay : {0, 1}) {
      const Gains gains = toy::gains(design_hz, GetParam(), delay);
      EXPECT_LT(closed_loop_radius(gains), largest_stable_radius);
      EXPECT_NO_THROW(require_stable(gains));
    }
    const Gains gains = toy::gains(design_hz, GetParam(), 1);
    for (const int delay : {0, 1, 2}) {
      for (const toy::Imperfections& imperfect :
           {toy::Imperfections{}, toy::Imperfections{.actuator_gain = 1.5},
            toy::Imperfections{.actuator_lag_hz = 300}}) {
        const toy::LoopSimulation loop(gains, law_from_gains(gains), delay, imperfect);
        EXPECT_LT(radius_of(toy::step_matrix(loop)), 1)
            << design_hz << " Hz, delay " << delay << ", gain " << imperfect.actuator_gain
            << ", lag " << imperfect.actuator_lag_hz;
      }
    }
  }
}

TEST_P(Rates, BothWaysGiveTheSameRadius) {
  for (const int delay : {0, 1}) {
    for (const double leak : {0.05, 1.0}) {
      Gains gains = toy::gains(5, GetParam(), delay, leak);
      for (const auto roll_off : {std::optional<double>{}, std::optional<double>{200}}) {
        gains.roll_off_hz = roll_off;
        const toy::LoopSimulation loop(gains, law_from_gains(gains), delay);
        // Eigenvalues of balanced matrices of norm about 1e3: 1e-13, times what is left unbalanced.
        EXPECT_NEAR(closed_loop_radius(gains), radius_of(toy::step_matrix(loop)), 1e-10);
      }
    }
  }
}

// A target near or at half the sample rate is no design to want, but its verdict has to be right.
TEST_P(Rates, TargetsNearHalfTheSampleRateAreJudgedRightly) {
  for (const double part : {0.1, 0.25, 0.4, 0.49, 0.4999}) {
    for (const int delay : {0, 1}) {
      Gains gains = toy::gains(part * GetParam(), GetParam(), delay);
      for (const double lead : {0.0, delay + 0.5}) {
        gains.lead_samples = lead;
        const toy::LoopSimulation loop(gains, law_from_gains(gains), delay);
        const double radius = closed_loop_radius(gains);
        const double other = radius_of(toy::step_matrix(loop));
        // X = (13.9 / target)^2 is as small as 8e-6, and the law's gain its inverse, which costs as
        // much of 16 digits.
        EXPECT_NEAR(radius, other, 1e-9 * std::max(1.0, radius))
            << part << " " << delay << " " << lead;
        EXPECT_EQ(radius < largest_stable_radius, other < largest_stable_radius);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Rates, Rates, testing::Values(1000.0, 4000.0, 10000.0));

// THEORY fact 3: the applied force one sample old makes the radius 1.2, a roll-off at 200 Hz mends
// it.
TEST(StartCheck, MisalignedAppliedForceIsUnstableAndARollOffMendsIt) {
  Gains gains = toy::gains(5, 1000, 1);
  const toy::Imperfections stale{.stale_samples = 1};
  EXPECT_NEAR(radius_of(toy::step_matrix({gains, law_from_gains(gains), 1, stale})), 1.2, 0.05);
  gains.roll_off_hz = 200;
  EXPECT_LT(radius_of(toy::step_matrix({gains, law_from_gains(gains), 1, stale})), 1);
}

// Without a leak there is a pole at 1 to rounding, and a leak of 1 mHz is told from it at every
// rate.
TEST_P(Rates, NoLeakIsAPoleAtOne) {
  for (const double design_hz : {1.0, 5.0, 10.0}) {
    for (const int delay : {0, 1}) {
      const Gains without = toy::gains(design_hz, GetParam(), delay, 0);
      EXPECT_NEAR(closed_loop_radius(without), 1, 1e-12);  // measured: 2e-14 at worst
      EXPECT_THROW(require_stable(without), Refusal);
      EXPECT_LT(closed_loop_radius(toy::gains(design_hz, GetParam(), delay, 1e-3)),
                largest_stable_radius);
    }
  }
}

std::string refusal(const Gains& gains) {
  try {
    require_stable(gains);
  } catch (const Refusal& error) {
    return error.what();
  }
  return {};
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(StartCheck, RefusalSaysWhyAndWhatMends) {
  std::string text = refusal(naive(5, 1000, 0));
  EXPECT_TRUE(contains(text, "K_P (largest eigenvalue 95.04)")) << text;
  EXPECT_TRUE(contains(text, "realisation: implicit_feedthrough")) << text;
  EXPECT_FALSE(contains(text, "sample_rate_hz")) << text;  // raising the rate does not help

  text = refusal(toy::gains(5, 1000, 1, 0));
  EXPECT_TRUE(contains(text, "static stiffness")) << text;
  EXPECT_TRUE(contains(text, "What mends it: leak_hz: 0.05")) << text;

  Gains both = naive(5, 1000, 1);
  both.leak_hz = 0;
  text = refusal(both);
  EXPECT_TRUE(contains(text, "realisation: implicit_feedthrough with leak_hz: 0.05")) << text;

  text = refusal(toy::gains(5, 120, 1));
  EXPECT_TRUE(contains(text, "delay_samples: 0")) << text;
  EXPECT_TRUE(contains(text, "sample_rate_hz: 240")) << text;

  // Decays in 1600 s, at a rate at which a decay of 1000 s is 1e-9 a sample.
  text = refusal(toy::gains(5, 1e6, 1, 1e-4));
  EXPECT_TRUE(contains(text, "0.9999999993")) << text;  // known to 1e-11
  EXPECT_TRUE(contains(text, "and what takes longer than 1000 s to settle")) << text;
  EXPECT_TRUE(contains(text, "What mends it: leak_hz: ")) << text;
  EXPECT_FALSE(contains(text, "static stiffness")) << text;

  Gains hopeless = toy::gains(5, 1000, 1);
  hopeless.K_P = -30 * MatrixXd::Identity(4, 4);
  text = refusal(hopeless);
  EXPECT_TRUE(contains(text, "None of the changes of one or two settings that were tried")) << text;
}

/// The toy with one motion more, of frequency hz, beside the legs.
Gains with_motion_beside(Gains gains, double hz, double damping = 0) {
  const Eigen::Index n = gains.plant.A.rows(), m = gains.n_legs();
  const double w = two_pi * hz;
  gains.plant.A.conservativeResizeLike(MatrixXd::Zero(n + 2, n + 2));
  gains.plant.A(n, n + 1) = 1;
  gains.plant.A(n + 1, n) = -w * w;
  gains.plant.A(n + 1, n + 1) = -damping;
  gains.plant.B.conservativeResizeLike(MatrixXd::Zero(n + 2, m));
  gains.plant.C.conservativeResizeLike(MatrixXd::Zero(m, n + 2));
  gains.plant.B_w.conservativeResizeLike(MatrixXd::Zero(n + 2, gains.plant.B_w.cols()));
  return gains;
}

// Every pole of modulus 1 is not one at 1. 700 Hz is above half the rate.
TEST(StartCheck, AMotionThatTheLawDoesNotReachIsNamedByItsFrequency) {
  for (const double leak : {0.05, 0.0}) {
    for (const double hz : {0.1, 27.57, 700.0}) {
      const Gains gains = with_motion_beside(toy::gains(5, 1000, 1, leak), hz);
      const std::string text = refusal(gains);
      char words[64];
      std::snprintf(words, sizeof words, "does not reach what moves at %.4g Hz", hz);
      EXPECT_TRUE(contains(text, words)) << text;
      ASSERT_EQ(unreached_motions_hz(gains).size(), 1u) << hz;
      EXPECT_NEAR(unreached_motions_hz(gains).front(), hz, 1e-9 * hz);
      // The toy has no other springs: without a leak it drifts besides.
      EXPECT_EQ(contains(text, "drift for ever"), leak == 0) << text;
      EXPECT_FALSE(contains(text, "mends it: ")) << text;
      EXPECT_FALSE(contains(text, "anew")) << text;
      EXPECT_EQ(refusal(with_motion_beside(toy::gains(5), hz, 1)), "") << hz;
    }
  }
  // On its own nothing holds it: a double pole at 1 that the law did not make.
  const std::string text = refusal(with_motion_beside(toy::gains(5), 0));
  EXPECT_TRUE(contains(text, "does not reach what moves at 0 Hz")) << text;
  EXPECT_FALSE(contains(text, "integrator")) << text;
  EXPECT_TRUE(unreached_motions_hz(toy::gains(5, 1000, 1, 0)).empty());
}

// What is named must really mend: apply each remedy by hand and simulate.
TEST(StartCheck, RemediesAreStableInTheSimulation) {
  const auto remedies = find_remedies(toy::gains(5, 120, 1));
  ASSERT_FALSE(remedies.empty());
  EXPECT_EQ(remedies.front().change, "delay_samples: 0");
  const Gains mended = toy::gains(5, 120, 0);
  EXPECT_NEAR(radius_of(toy::step_matrix({mended, law_from_gains(mended), 0})),
              remedies.front().radius, 1e-10);
}

TEST(Balance, KeepsTheEigenvaluesAndLowersTheNorm) {
  // Similar to a symmetric matrix by a diagonal of 20 decades: eigenvalues known from that one.
  std::mt19937_64 random(8);
  std::normal_distribution<double> normal;
  const MatrixXd R = MatrixXd::NullaryExpr(6, 6, [&] { return normal(random); });
  const MatrixXd symmetric = R + R.transpose();
  const VectorXd scale = Eigen::exp(VectorXd::LinSpaced(6, -23, 23).array());
  const MatrixXd A = scale.asDiagonal() * symmetric * scale.cwiseInverse().asDiagonal();
  VectorXd expected = symmetric.selfadjointView<Eigen::Lower>().eigenvalues();
  VectorXd found = balanced(A).eigenvalues().real();
  std::sort(found.begin(), found.end());
  EXPECT_LT((found - expected).norm(), 1e-12 * expected.norm());  // well conditioned once balanced
  EXPECT_GT((A.eigenvalues().real().norm() - expected.norm()), 0);
  EXPECT_LT(balanced(A).norm(), 10 * symmetric.norm());
}

// With a part w of the law's force the loop of the toy is that of a plant simulated in time with
// the law's matrices scaled.
TEST(Ramp, RadiusIsTheLargestOnTheWay) {
  const Gains gains = toy::gains(5);
  double largest = 0;
  for (int i = 1; i < 20; ++i) {
    DiscreteLaw law = law_from_gains(gains);
    law.C *= i / 20.0;
    law.D *= i / 20.0;
    toy::LoopSimulation loop(gains, law, 1);
    largest = worst_of(largest, radius_of(toy::step_matrix(loop)));
  }
  // Two ways to matrices whose poles crowd near 1, where rounding is magnified: seen 2e-11.
  EXPECT_NEAR(ramp_radius(gains), largest, 1e-9);
  EXPECT_LT(require_stable_ramp(gains), 1);
}

// Every packet of numbers that once passed with "spectral radius 4.64e-310" or a crash.
TEST(StartCheck, AbsurdNumbersAreNeverStable) {
  const auto refused = [](auto change) {
    Gains gains = toy::gains(5);
    change(gains);
    try {
      return !(closed_loop_radius(gains) < largest_stable_radius) && !refusal(gains).empty();
    } catch (const Refusal&) {
      return true;
    }
  };
  EXPECT_TRUE(refused([](Gains& g) { g.plant.A(0, 0) = 1e6; }));
  EXPECT_TRUE(refused([](Gains& g) { g.plant.A(1, 1) = 1e18; }));
  EXPECT_TRUE(refused([](Gains& g) { g.leak_hz = 1e308; }));
  EXPECT_TRUE(refused([](Gains& g) { g.sample_rate_hz = 1e-300; }));
  EXPECT_TRUE(refused([](Gains& g) { g.K_I(1, 2) = 1e308; }));
  EXPECT_TRUE(refused([](Gains& g) { g.K_P(0, 0) = std::nan(""); }));
  EXPECT_THROW(closed_loop_radius([] {
                 Gains gains = toy::gains(5);
                 gains.delay_samples = 3e9;
                 return gains;
               }()),
               std::invalid_argument);
}

TEST(ForceLimit, IsTheLowerOfTwoAndWithoutAnyRefused) {
  Gains gains = toy::gains(5);
  Policy policy;
  const auto limit = [&](std::optional<double> of_gains, std::optional<double> of_policy) {
    gains.force_limit_n = of_gains;
    policy.force_limit_n = of_policy;
    return force_limit(gains, policy);
  };
  EXPECT_EQ(limit(200, 100), 100);
  EXPECT_EQ(limit(100, 200), 100);
  EXPECT_EQ(limit(200, {}), 200);
  EXPECT_EQ(limit({}, 100), 100);
  EXPECT_THROW(limit({}, {}), Refusal);
}

// At every fault the loop lets go of the frame: one that grows by itself must not be held at all,
// however slowly it grows.
TEST(Ramp, AFrameThatCreepsAwayByItselfIsRefused) {
  for (const double growth : {0.003, 0.01, 0.1}) {  // 1/s
    Gains gains = toy::gains(5);
    const Eigen::Index m = gains.n_legs();
    gains.plant.A.bottomRightCorner(m, m).diagonal().array() += 2 * growth;
    EXPECT_LT(ramp_radius(gains), 1) << growth;
    EXPECT_THROW(require_stable_ramp(gains), Refusal) << growth;
  }
}

TEST(Ramp, AFrameThatDoesNotStandByItselfIsRefused) {
  Gains gains = toy::gains(5);
  const Eigen::Index m = gains.n_legs();
  // Every mode grows by 10 1/s when left alone; the loop, with 2 zeta omega_d = 44 1/s, damps it.
  gains.plant.A.bottomRightCorner(m, m).diagonal().array() += 20;
  EXPECT_LT(require_stable(gains), 1);
  EXPECT_GT(ramp_radius(gains), 1);
  EXPECT_THROW(require_stable_ramp(gains), Refusal);
}

}  // namespace
}  // namespace stillframe::controller

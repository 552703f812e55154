#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <complex>
#include <random>

#include "controller/law.hpp"
#include "core/errors/input_error.hpp"
#include "core/numerics/worst.hpp"
#include "core/systems/linear_system.hpp"
#include "tests/controller/toy_plant.hpp"
#include "tests/support/allocation_count.hpp"

namespace stillframe::controller {
namespace {

using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Complex = std::complex<double>;

// Gains whose matrices neither commute nor are symmetric: X = K M^-1 / w_d^2 with full K and M.
Gains coupled_gains(double rate_hz, double leak_hz) {
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal;
  const auto spd = [&](double scale) {
    const MatrixXd R = MatrixXd::NullaryExpr(4, 4, [&] { return normal(random); });
    return MatrixXd(scale * (R * R.transpose() + 0.5 * MatrixXd::Identity(4, 4)));
  };
  const MatrixXd K = spd(1e6), M = spd(10);
  Gains gains = toy::gains(5, rate_hz, 1, leak_hz);
  const double w_d = two_pi * 5;
  const MatrixXd X = K * M.inverse() / (w_d * w_d);
  gains.K_P = X - MatrixXd::Identity(4, 4);
  gains.K_I = 2 * toy::damping_ratio * w_d * X;
  return gains;
}

// Tustin's warped frequency, at which the sampled response equals the continuous one exactly.
Complex warped(Complex z, double T) { return 2.0 / T * (z - 1.0) / (z + 1.0); }

MatrixXcd closed_form(const Gains& gains, Complex s) {
  const double w_l = two_pi * gains.leak_hz;
  const MatrixXcd I = MatrixXcd::Identity(gains.n_legs(), gains.n_legs());
  const double w_h = two_pi * gains.high_pass_hz;
  const MatrixXcd P =
      (gains.K_P * s + gains.K_I) / (s + w_l) * (w_h > 0 ? s / (s + w_h) : Complex(1));
  MatrixXcd C = gains.realisation == Realisation::naive_pi ? MatrixXcd(-P)
                                                           : MatrixXcd(-(I + P).inverse() * P);
  if (gains.roll_off_hz) {
    const double w_r = two_pi * *gains.roll_off_hz;
    C *= w_r / (s + w_r);
  }
  return C;
}

MatrixXcd response(const DiscreteLaw& law, Complex z) {
  const MatrixXcd I = MatrixXcd::Identity(law.A.rows(), law.A.cols());
  return law.C * (z * I - law.A).inverse() * law.B + law.D;
}

struct Case {
  Realisation realisation;
  double leak_hz;
  std::optional<double> roll_off_hz;
  double lead_samples = 0;
  double high_pass_hz = 0;
};

class LawResponse : public testing::TestWithParam<Case> {};

TEST_P(LawResponse, EqualsTheClosedFormAtTheWarpedFrequency) {
  for (const double rate : {1000.0, 4000.0, 10000.0}) {
    Gains gains = coupled_gains(rate, GetParam().leak_hz);
    gains.realisation = GetParam().realisation;
    gains.roll_off_hz = GetParam().roll_off_hz;
    gains.lead_samples = GetParam().lead_samples;
    gains.high_pass_hz = GetParam().high_pass_hz;
    const DiscreteLaw law = law_from_gains(gains);
    EXPECT_EQ(law.subtract_applied, gains.realisation == Realisation::implicit_feedthrough);
    for (const double part : {1e-5, 1e-4, 1e-3, 0.01, 0.1, 0.25, 0.4, 0.49}) {
      const Complex z = std::polar(1.0, two_pi * part);
      const MatrixXcd expected = closed_form(gains, warped(z, gains.sample_time())) *
                                 (1.0 + gains.lead_samples * (1.0 - 1.0 / z));
      // Rounding only: z I - A loses log10(1 / (2 pi 1e-5)), 4 to 5 digits of 16, I + K_P 2 more.
      EXPECT_LT((response(law, z) - expected).norm(), 1e-9 * expected.norm())
          << part << " of " << rate << " Hz";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, LawResponse,
    testing::Values(Case{Realisation::implicit_feedthrough, 0.05, {}},
                    Case{Realisation::implicit_feedthrough, 0.0, {}},
                    Case{Realisation::implicit_feedthrough, 2.0, 200.0},
                    Case{Realisation::naive_pi, 0.05, {}}, Case{Realisation::naive_pi, 1.0, 300.0},
                    Case{Realisation::implicit_feedthrough, 0.05, {}, 1.5},
                    Case{Realisation::implicit_feedthrough, 0.05, 200.0, 0.5},
                    Case{Realisation::implicit_feedthrough, 0.05, {}, 0, 0.2},
                    Case{Realisation::implicit_feedthrough, 0.0, 200.0, 0, 0.2},
                    Case{Realisation::naive_pi, 0.05, 200.0, 0, 0.2}));

TEST(Law, ImplicitOneIsStableAndHasItsStaticGain) {
  for (const double rate : {1000.0, 10000.0}) {
    const Gains gains = coupled_gains(rate, 0.05);
    const DiscreteLaw law = law_from_gains(gains);
    EXPECT_EQ(law.A.rows(), gains.n_legs());
    EXPECT_LT(worst_of(law.A.eigenvalues()), 1.0);
    const MatrixXd W =
        two_pi * gains.leak_hz * MatrixXd::Identity(4, 4) + gains.K_I;  // C'(0) = -W^-1 K_I
    const MatrixXd expected = -W.inverse() * gains.K_I;
    // Rounding of I - A, whose entries are of order 1e-3 at the least.
    EXPECT_LT((response(law, 1.0).real() - expected).norm(), 1e-10);
  }
}

TEST(Law, StepsAreTheMatrices) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  const auto any = [&](Eigen::Index rows, Eigen::Index cols) {
    return MatrixXd(MatrixXd::NullaryExpr(rows, cols, [&] { return normal(random); }));
  };
  for (const bool subtract : {true, false}) {
    const DiscreteLaw matrices{0.2 * any(5, 5), any(5, 3), any(3, 5), any(3, 3), subtract};
    Law law(matrices);
    VectorXd x = VectorXd::Zero(5), force(3);
    for (int k = 0; k < 100; ++k) {
      const VectorXd sigma = any(3, 1), applied = any(3, 1);
      const VectorXd e = subtract ? VectorXd(sigma - applied) : sigma;
      const VectorXd expected = matrices.C * x + matrices.D * e;
      law.step(sigma, applied, force);
      x = matrices.A * x + matrices.B * e;
      // A few roundings of numbers of order 10; the order of the sums is free.
      EXPECT_LT((force - expected).norm(), 1e-13 * (1 + expected.norm()));
      EXPECT_LT((law.state() - x).norm(), 1e-13 * (1 + x.norm()));
    }
    law.reset();
    EXPECT_EQ(law.state().norm(), 0.0);
  }
}

// What A has only zeros beside is multiplied by itself: of any structure, also one entry far off
// the diagonal on either side, that is A x.
TEST(Law, TakesEveryStructureOfAForWhatItIs) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> normal(-1, 1);
  const auto draw = [&](Eigen::Index rows, Eigen::Index columns) {
    return MatrixXd(MatrixXd::NullaryExpr(rows, columns, [&] { return normal(random); }));
  };
  for (int i = 0; i < 200; ++i) {
    const auto n = static_cast<Eigen::Index>(random() % 40);
    DiscreteLaw law{.A = MatrixXd::Zero(n, n), .B = draw(n, 3), .C = draw(3, n), .D = draw(3, 3)};
    for (Eigen::Index at = 0; at < n;) {
      const auto size = std::min<Eigen::Index>(n - at, 1 + random() % 12);
      law.A.block(at, at, size, size) = 0.2 * draw(size, size);
      at += size;
    }
    for (auto k = random() % 3; n > 0 && k > 0; --k) law.A(random() % n, random() % n) = 0.5;
    Law tried(law);
    VectorXd x = VectorXd::Zero(n), force(3);
    for (int k = 0; k < 5; ++k) {
      const VectorXd sigma = draw(3, 1), applied = draw(3, 1), e = sigma - applied;
      tried.step(sigma, applied, force);
      const VectorXd expected = law.C * x + law.D * e;
      // Sums of 40 products of one size, in another order.
      ASSERT_LT((force - expected).norm(), 1e-12 * (1 + expected.norm())) << i << ", " << k;
      x = law.A * x + law.B * e;
    }
  }
}

TEST(Law, AGapIsARampOfTheForce) {
  const DiscreteLaw matrices = law_from_gains(coupled_gains(1000, 0.05));
  Law with_gap(matrices), without(matrices);
  const VectorXd zero = VectorXd::Zero(4), first = VectorXd::LinSpaced(4, 1, 4), last = -3 * first;
  VectorXd expected(4), force(4);
  without.step(first, zero, expected);
  for (int j = 1; j <= 5; ++j) without.step(first + j / 5.0 * (last - first), zero, expected);
  with_gap.step(first, zero, force);
  with_gap.step_over(5, last, zero, force);
  EXPECT_LT((force - expected).norm(), 1e-14 * expected.norm());  // rounding of the ramp
}

// One oscillator of 49 Hz in closed form, at 1 kHz with one sample of delay; the law hears every
// n-th sample only and its command is held until the next one, as when a machine is late.
double force_after_a_second(int every, bool made_up_for) {
  Gains gains = toy::gains(5, 1000, 1);
  gains.lead_samples = 1.5;
  Law law(law_from_gains(gains));
  const double w = two_pi * 49, c = std::cos(w * 1e-3), s = std::sin(w * 1e-3);
  const Eigen::Index leg = 3;  // toy::gains: M = I, K = diag((2 pi f)^2), the last f is 49 Hz
  double e = 1e-6, v = 0, applied = 0, pending = 0;
  VectorXd sigma = VectorXd::Zero(4), taken = sigma, force = sigma;
  for (int k = 0; k < 1000; ++k) {
    if (k % every == 0) {
      sigma(leg) = w * w * e + applied;
      taken(leg) = applied;
      law.step_over(made_up_for ? every : 1, sigma, taken, force);
    }
    const double rest = -pending / (w * w), x = e - rest;
    e = rest + c * x + s * v / w;
    v = -s * w * x + c * v;
    applied = pending;
    pending = force(leg);
  }
  return std::abs(applied) / (w * w * 1e-6);
}

TEST(Law, StaysStableWhenSamplesAreMissed) {
  // A leg that starts 1 um long: without static stiffness the force stays of that order for
  // seconds.
  const double undisturbed = force_after_a_second(1, true);
  EXPECT_LT(undisturbed, 2.0);
  for (const int every : {2, 3, 4, 6}) {
    EXPECT_LT(force_after_a_second(every, true), undisturbed) << every;
  }
  EXPECT_GT(force_after_a_second(4, false), 1e3);  // what is made up for
}

// An actuator at its limit must not wind the law up: after 1 s and after 100 s at the limit the law
// comes back in the same way. A leakless sampled PI under the same load is a hundred times further
// away.
TEST(Law, SaturationDoesNotWindUp) {
  const auto state_after = [](Realisation realisation, int seconds) {
    Gains gains = toy::gains(5, 1000, 1, realisation == Realisation::naive_pi ? 0 : 0.05);
    gains.realisation = realisation;
    Law law(law_from_gains(gains));
    const VectorXd sigma_p = VectorXd::Constant(4, 100.0), limit = VectorXd::Constant(4, -1.0);
    VectorXd force(4);
    for (int k = 0; k < 1000 * seconds; ++k) law.step(sigma_p + limit, limit, force);
    return law.state();
  };
  const VectorXd early = state_after(Realisation::implicit_feedthrough, 1);
  const VectorXd late = state_after(Realisation::implicit_feedthrough, 100);
  // The law forgets as exp(-2 zeta w_d t), 1e-19 after one second; what is left is rounding.
  EXPECT_LT((late - early).norm(), 1e-12 * early.norm());
  const double growth =
      state_after(Realisation::naive_pi, 100).norm() / state_after(Realisation::naive_pi, 1).norm();
  EXPECT_NEAR(growth, 100, 0.1);  // the first sample of the trapezoid weighs 1/1000
}

TEST(Law, StepDoesNotAllocate) {
  for (const Eigen::Index m : {1, 6, 24}) {
    const MatrixXd A = 0.5 * MatrixXd::Identity(2 * m, 2 * m);
    Law law(
        {A, MatrixXd::Ones(2 * m, m), MatrixXd::Ones(m, 2 * m), MatrixXd::Identity(m, m), true});
    const VectorXd sigma = VectorXd::Ones(m), applied = VectorXd::Zero(m);
    VectorXd force(m);
    const auto before = test::allocation_count();
    for (int k = 0; k < 10; ++k) law.step(sigma, applied, force);
    law.reset();
    EXPECT_EQ(test::allocation_count(), before) << m << " legs";
  }
}

TEST(Law, AllocationsAreSeenByTheCounter) {
  const auto before = test::allocation_count();
  const VectorXd vector = VectorXd::Ones(3);
  EXPECT_EQ(vector.sum(), 3);
  EXPECT_GT(test::allocation_count(), before);
}

TEST(Law, BadShapesAndSingularGainsAreRefused) {
  EXPECT_THROW(Law({MatrixXd::Zero(2, 2), MatrixXd::Zero(2, 3), MatrixXd::Zero(3, 1),
                    MatrixXd::Zero(3, 3), true}),
               std::invalid_argument);
  Gains gains = toy::gains(5);
  gains.K_I = MatrixXd::Zero(3, 3);
  EXPECT_THROW(law_from_gains(gains), std::invalid_argument);
  gains = toy::gains(5);
  gains.K_P = -MatrixXd::Identity(4, 4);
  EXPECT_THROW(law_from_gains(gains), Refusal);
  EXPECT_THROW(tustin({}, 0), std::invalid_argument);
}

}  // namespace
}  // namespace stillframe::controller

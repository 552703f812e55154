#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "core/numerics/worst.hpp"
#include "plant_sim/floor/courses.hpp"
#include "plant_sim/floor/held_acceleration.hpp"

namespace stillframe::floor {
namespace {

/// What held accelerations integrate to from rest, exactly but for the rounding of long double.
struct Integral {
  long double position = 0, velocity = 0;
  double largest_position = 0;

  Integral(const Eigen::VectorXd& acceleration, double rate) {
    const long double T = 1.0L / rate;
    for (const double a : acceleration) {
      position += T * (velocity + T * a / 2);
      velocity += T * a;
      largest_position = worst_of(largest_position, std::abs(static_cast<double>(position)));
    }
  }
};

TEST(HeldAcceleration, IntegratesBackToThePositionsItIsMadeFrom) {
  const double rate = 1000.0;
  Eigen::VectorXd d(500);
  for (Eigen::Index k = 0; k < d.size(); ++k) {
    d(k) = 1e-3 * std::sin(static_cast<double>(k * k % 997));
  }
  const Eigen::VectorXd a = held_accelerations(d, rate);
  for (Eigen::Index k = 1; k < d.size(); ++k) {
    const Integral integral(a.head(k), rate);  // x and v at instant k
    // x = (d[k] + d[k-1]) / 2, v = (d[k] - d[k-1]) rate; accelerations of 1e3 m/s^2 round by 1e-13,
    // which k steps of a millisecond take to 1e-13 * 1e-6 * k^1.5 = 1e-15 m, and v to 2e-15 m/s.
    EXPECT_NEAR(static_cast<double>(integral.position), 0.5 * (d(k) + d(k - 1)), 1e-14) << k;
    EXPECT_NEAR(static_cast<double>(integral.velocity), (d(k) - d(k - 1)) * rate, 1e-13) << k;
  }
}

TEST(HeldAcceleration, GainIsThatOfTheSecondDifferenceOfASine) {
  const double rate = 800.0;
  for (const double f : {1e-3, 0.5, 30.0, 399.0}) {
    const double w = 2.0 * std::numbers::pi * f / rate, phase = 0.3;
    const auto d = [&](int k) { return std::sin(phase + w * k); };
    // Second differences of sines of size 1 round by 4e-16 rate^2.
    EXPECT_NEAR(held_acceleration(d(6), d(7), d(8), rate), -held_acceleration_gain(f, rate) * d(7),
                4e-16 * rate * rate);
  }
  // (2 pi f)^2 less (pi f / rate)^2 / 3 of it: at 1 mHz that is 5e-12.
  const double omega = 2.0 * std::numbers::pi * 1e-3;
  EXPECT_NEAR(held_acceleration_gain(1e-3, rate) / (omega * omega), 1.0, 1e-11);
}

TEST(StepCourse, EndsAtItsHeightAndAtRest) {
  for (const double rate : {512.0, 1000.0, 1000.0 / 3.0}) {
    const StepCourse step{.height = -2e-3, .rise_s = 0.1234};
    const Eigen::VectorXd a = held_accelerations(positions(step, rate), rate);
    const Integral end(a, rate);
    // Positions of millimetres round by 1e-19 m, accelerations of 1 m/s^2 by 1e-16.
    EXPECT_NEAR(static_cast<double>(end.position), step.height, 1e-17);
    EXPECT_NEAR(static_cast<double>(end.velocity), 0.0, 1e-15);
    EXPECT_LT(end.largest_position, 2.0000001e-3);  // without overshoot
    // s'' = 60 p (1 - p) (1 - 2 p), largest 10 / root 3; samples miss the peak by (1/4 of a
    // step)^2.
    const double peak = 10.0 / std::sqrt(3.0) * 2e-3 / std::pow(step.rise_s, 2);
    EXPECT_NEAR(worst_of(a), peak, 0.01 * peak);
  }
}

TEST(ImpactCourse, PeaksInItsMiddleAndReturns) {
  const double rate = 4000.0;
  const ImpactCourse impact{.peak = 3.0, .width_s = 0.02};
  const Eigen::VectorXd d = positions(impact, rate), a = held_accelerations(d, rate);
  const Integral end(a, rate);
  EXPECT_NEAR(static_cast<double>(end.position), 0.0, 1e-19);  // rounding of 3e-5 m: 4e-21
  EXPECT_NEAR(static_cast<double>(end.velocity), 0.0, 1e-16);
  // The middle is sample 40. The second difference is low by d'''' T^2 / 12 = 4 w^2 T^2 / 12 ... of
  // the peak, w = 2 pi / width: sin^4 has lines at w and 2 w, of which 2 w has the larger share.
  const double w = 2.0 * std::numbers::pi / (impact.width_s * rate);
  EXPECT_NEAR(a(40), impact.peak, impact.peak * 4.0 * w * w / 12.0);
  EXPECT_EQ(a.maxCoeff(), a(40));
  EXPECT_NEAR(a.minCoeff(), -9.0 / 16.0 * impact.peak, 0.01 * impact.peak);
  EXPECT_NEAR(d.minCoeff(), -impact.peak * std::pow(impact.width_s / (2 * std::numbers::pi), 2),
              1e-19);
}

class Sweeps : public ::testing::TestWithParam<SweepCourse> {};

TEST_P(Sweeps, HasTheAmplitudeAndPhaseAskedAndEndsAtRest) {
  const SweepCourse sweep = GetParam();
  const double rate = 1000.0;
  const Eigen::VectorXd d = positions(sweep, rate), a = held_accelerations(d, rate);
  const Integral end(a, rate);
  EXPECT_NEAR(static_cast<double>(end.position), 0.0, 1e-15);  // 6e4 roundings of 1 m/s^2
  EXPECT_NEAR(static_cast<double>(end.velocity), 0.0, 1e-15);
  EXPECT_LT(end.largest_position, 1.2 * sweep.amplitude / std::pow(2 * std::numbers::pi, 2));
  for (Eigen::Index k = 0; k < a.size(); k += 7) {
    const double t = static_cast<double>(k) / rate;
    if (t < 2.1 || t > sweep.sweep_s - 2.1) continue;
    const double f = sweep_frequency(sweep, t);
    const double slope = (sweep_frequency(sweep, t + 1e-3) - f) / 1e-3;
    // d = -A sin(phi) / g(f), g near (2 pi f)^2: its second derivative has -4 f'/f A cos(phi) /
    // (2 pi f) + f'/f A cos(phi) / (2 pi f) beside A sin(phi).
    const double allowed = 4.0 * std::abs(slope) / f / (2.0 * std::numbers::pi * f) + 1e-3;
    EXPECT_NEAR(a(k), sweep.amplitude * std::sin(sweep_phase(sweep, t)), sweep.amplitude * allowed)
        << t;
  }
}

TEST(SweepCourse, PhaseIsTheIntegralOfFrequency) {
  for (const bool linear : {false, true}) {
    const SweepCourse sweep{1.0, 90.0, 1.0, 60.0, linear};
    for (const double t : {0.0, 1.0, 33.3, 59.0}) {
      const double h = 1e-4, slope = (sweep_phase(sweep, t + h) - sweep_phase(sweep, t)) / h;
      // A one-sided difference: off by h f' / 2 * 2 pi = 2e-3 rad/s at most, f' up to 7 Hz/s.
      EXPECT_NEAR(slope, 2 * std::numbers::pi * sweep_frequency(sweep, t), 3e-3);
    }
    EXPECT_NEAR(sweep_frequency(sweep, 60.0), 90.0, 1e-12);
    EXPECT_NEAR(sweep_frequency(sweep, 30.0), linear ? 45.5 : std::sqrt(90.0), 1e-12);
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, Sweeps,
                         ::testing::Values(SweepCourse{1.0, 100.0, 1e-2, 60.0, false},
                                           SweepCourse{1.0, 100.0, 1e-2, 60.0, true},
                                           SweepCourse{100.0, 1.0, 1e-2, 60.0, false},
                                           SweepCourse{20.0, 20.0, 1e-2, 60.0, true}));

TEST(Courses, WantARateAndALength) {
  EXPECT_THROW(positions(StepCourse{1.0, 0.0}, 1000.0), std::invalid_argument);
  EXPECT_THROW(positions(ImpactCourse{1.0, 1.0}, 0.0), std::invalid_argument);
}

}  // namespace
}  // namespace stillframe::floor

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <iostream>
#include <numbers>

#include "core/errors/input_error.hpp"
#include "tests/verification/convergence.hpp"
#include "tests/verification/scene_text.hpp"

// V12: a cantilever that a moment at its tip bends into a circle.
namespace stillframe::verification {
namespace {

constexpr double pi = std::numbers::pi;

struct Tip {
  double x = 0, y = 0, angle = 0;  ///< displacement, m, and rad
};

Tip computed(int n, bool second) {
  std::string text = without_signals(scene_text("beam_to_circle"));
  if (second) text = with(text, "divide:", "second_order: true, divide:");
  const LinearModel m = linear_model(divided(text, n) +
                                     "inputs: []\noutputs: [{name: x, position: tip, along: x}, "
                                     "{name: y, position: tip, along: y},"
                                     " {name: angle, rotation: tip}]\n");
  return {m.y_0(0), m.y_0(1), m.y_0(2)};
}

/// The same by hand. All n elements bend alike, by an angle 2 phi over a chord C, with deformations
/// e_2 = e_3 = -C sin phi and the energy 2 EI (C sin phi)^2 / l^3; M = dE / d(2 phi). The chord is
/// l, or with second-order terms C + (C sin phi)^2 / (6 l) = l.
Tip by_hand(int n, bool second) {
  const double l = 1.0 / n;
  double phi = pi / n, C = l;
  for (int i = 0; i < 60; ++i) {
    const auto moment = [&](double p) {
      const double s = std::sin(p), c = std::cos(p), a = second ? s * s / (6 * l) : 0;
      C = second ? (std::sqrt(1 + 4 * a * l) - 1) / (2 * a) : l;
      const double dC = second ? -C * C * s * c / (3 * l) / (1 + 2 * C * a) : 0;
      return 2 / (l * l * l) * C * s * (dC * s + C * c);
    };
    const double step = 1e-6, slope = (moment(phi + step) - moment(phi - step)) / (2 * step);
    phi += (2 * pi - moment(phi)) / slope;
    moment(phi);
  }
  std::complex<double> r = 0;
  for (int k = 0; k < n; ++k) r += std::polar(C, (2 * k + 1) * phi);
  return {r.real() - 1, r.imag(), 2 * n * phi};
}

TEST(V12, EquilibriumIsThatOfTheChainByHand) {
  for (const bool second : {false, true}) {
    for (const int n : {12, 16, 32, 64}) {
      const Tip tip = computed(n, second), hand = by_hand(n, second);
      // Newton's method ends at rounding, 1e-16 n^2 (condition of n angles in a row) of a turn.
      const double tolerance = 1e-14 * n * n;
      EXPECT_NEAR(tip.angle, hand.angle, tolerance) << n;
      EXPECT_NEAR(tip.x, hand.x, tolerance) << n;
      EXPECT_NEAR(tip.y, hand.y, tolerance) << n;
    }
  }
}

/// The sine of half the angle of a part, theta = 2 pi / n, makes it too soft by theta^2 / 6, and
/// with the shortening of the chord by twice that. The circle closes to the same part of its
/// length.
TEST(V12, ClosesToACircleWithTheSquareOfTheLength) {
  for (const bool second : {false, true}) {
    const Error angle = [&](int n) { return computed(n, second).angle / (2 * pi) - 1; };
    const Error gap = [&](int n) {
      const Tip tip = computed(n, second);
      return std::hypot(1 + tip.x, tip.y);
    };
    for (const int n : {32, 64}) {
      const double theta = 2 * pi / n, leading = theta * theta / (second ? 3 : 6);
      // Next terms: theta^4 with coefficients of order one.
      EXPECT_NEAR(angle(n), leading, std::pow(theta, 4)) << n;
      EXPECT_NEAR(gap(n), leading, 3 * std::pow(theta, 4) + leading * leading) << n;
    }
    EXPECT_NEAR(observed_order(angle, 32), 2, 0.1);
    std::cout << "V12 " << (second ? "second_order" : "first order") << ", gap with 64 elements "
              << gap(64) << ", extrapolated: 1e-3 with " << extrapolated_count(gap, 64, 2, 1e-3)
              << ", 1e-5 with " << extrapolated_count(gap, 64, 2, 1e-5) << "\n";
  }
}

/// An element takes no moment above EI / l: sin(2 phi) <= 1. With n < 2 pi there is no equilibrium.
TEST(V12, RefusesAMomentThatTheElementsCannotTake) {
  EXPECT_THROW(computed(6, false), Refusal);
  EXPECT_NO_THROW(computed(8, false));
}

}  // namespace
}  // namespace stillframe::verification

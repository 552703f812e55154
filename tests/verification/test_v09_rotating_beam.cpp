#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <numbers>

#include "tests/verification/closed_forms.hpp"
#include "tests/verification/convergence.hpp"
#include "tests/verification/scene_text.hpp"

// V9: a cantilever that rotates about its root.
namespace stillframe::verification {
namespace {

/// The scene at gamma turns a second: frequencies in Hz are the relative ones, lag and then flap.
std::string text_at(double gamma) {
  return with(without_signals(blade_without_twist()), "31.41592653589793",
              number(2 * std::numbers::pi * gamma));
}

Error flap_error(const std::string& text, const RotatingBeam& reference) {
  return [=](int n) { return frequencies_hz(divided(text, n))(1) / reference.flap - 1; };
}
Error lag_error(const std::string& text, const RotatingBeam& reference) {
  return [=](int n) { return frequencies_hz(divided(text, n))(0) / reference.lag - 1; };
}

TEST(V9, RitzGivesThePublishedNumbers) {
  const double published[][2] = {{1, 3.68165}, {2, 4.13732}, {5, 6.44954}};
  for (const auto& [gamma, flap] : published) {
    EXPECT_NEAR(rotating_beam(gamma).flap, flap, 5e-6);  // half a unit of the last digit
  }
  // Rounding of the two matrices, whose condition grows to 1e6 with the degree.
  EXPECT_NEAR(rotating_beam(0).flap, std::pow(beam_root(1, -1), 2), 1e-8);
}

TEST(V9, FlapAndLag) {
  for (const double gamma : {1.0, 2.0, 5.0}) {
    const RotatingBeam beam = rotating_beam(gamma);
    const std::string text = text_at(gamma);
    const Error second = flap_error(text, beam), first = flap_error(first_order(text), beam);
    for (const int n : {8, 16}) {
      // What cubics between the nodes leave out of the bending energy and of the work of the
      // centrifugal forces on the shortening (h^4 / 720 each), and what chords leave out of the
      // work of the tension (h^2 / 12 T w''^2), over twice the square of the frequency. The next
      // terms are smaller by the order of h^2, with coefficients that grow as the mode does.
      const double h = 1.0 / n, square = beam.flap * beam.flap;
      const double cubic = h * h * h * h / 1440 * (beam.fourth + beam.shortening) / square,
                   chord = -h * h / 24 * beam.tension / square;
      const double next = (gamma * gamma + 4) * h * h;
      std::cout << "gamma " << gamma << ", " << n << " elements: flap error second_order "
                << second(n) << " (theory " << cubic << "), first order " << first(n) << " (theory "
                << chord << ")\n";
      EXPECT_NEAR(first(n), chord, std::abs(chord) * next);
      EXPECT_NEAR(second(n), cubic, cubic * next + 1e-8);
      // lag^2 = flap^2 - gamma^2 holds for the model itself: the same matrices but for -Omega^2 M.
      // Rounding: 1e-16 of the square of the highest frequency, 1e8 of these.
      const Eigen::VectorXd f = frequencies_hz(divided(text, n));
      EXPECT_NEAR(f(0) * f(0), f(1) * f(1) - gamma * gamma, 1e-7 * square);
    }
    EXPECT_NEAR(observed_order(first, 8), 2, 0.1);
    EXPECT_NEAR(observed_order(second, 4), 4, 0.25);
    const std::string name = "V9 gamma " + std::to_string(static_cast<int>(gamma));
    print_counts(name + " flap, second_order", second);
    print_counts(name + " lag, second_order", lag_error(text, beam));
    print_counts(name + " flap, first order", first, 1, 24);
    if (gamma == 1) {  // the extrapolated count, where it is small enough to run
      EXPECT_LE(std::abs(first(extrapolated_count(first, 16, 2, 1e-5))), 1.02e-5);
    }
    std::cout << name << " flap, first order, extrapolated: 1e-3 with "
              << extrapolated_count(first, 16, 2, 1e-3) << ", 1e-5 with "
              << extrapolated_count(first, 16, 2, 1e-5) << "\n";
  }
}

/// The scene as it stands twists, and its section has an inertia of 1e-6 about the axis, which
/// takes 1e-6 off its frequencies. An elastic elongation raises them by a part of EA / (mu (Omega
/// L)^2).
TEST(V9, TheSceneItself) {
  const RotatingBeam beam = rotating_beam(5);
  const std::string scene = without_signals(scene_text("rotating_cantilever"));
  const double without = flap_error(text_at(5), beam)(8), twisting = flap_error(scene, beam)(8);
  EXPECT_NEAR(twisting, without, 2e-6);
  EXPECT_NEAR(frequencies_hz(scene)(1), 6.44954, 1e-4);
  EXPECT_NEAR(frequencies_hz(scene)(0), std::sqrt(6.44954 * 6.44954 - 25), 2e-4);
  const auto stretching = [&](double EA) {
    return flap_error(with(text_at(5), "rigid: [1, 2]", "rigid: [2], EA: " + number(EA)), beam)(8) -
           without;
  };
  std::cout << "V9: EA / EI = 1e6 shifts the flap frequency by " << stretching(4e7) << "\n";
  EXPECT_LE(std::abs(stretching(4e7)), std::pow(10 * std::numbers::pi, 2) / 4e7);
  // Proportional to 1 / EA; rounding of 1e-9 in the frequencies of a stiffer beam.
  EXPECT_NEAR(stretching(4e6) / stretching(4e7), 10, 0.1);
}

/// A planar bar that turns stretches by mu Omega^2 L^3 / (3 EA). Its mass moves along cubics with
/// end tangents of unit length, which share out a load that is linear in x by 1 - 3 s^2 + 2 s^3
/// instead of 1 - s: every part stretches by mu Omega^2 h^3 / (60 EA) more, 1 / (20 n^2) of the
/// whole.
TEST(V9, CentrifugalStretchOfAPlanarBar) {
  const std::string text = R"(title: Turning bar
planar: true
nodes: {ground: {position: [0, 0]}, hub: {position: [0, 0]}, tip: {position: [2, 0]}}
masses: []
elements:
  shaft: {type: hinge, nodes: [ground, hub]}
  bar: {type: beam, nodes: [hub, tip], EA: 3e8, EI: 100, mass_per_length: 0.5, divide: 1}
supports: [{nodes: [ground], fix: [x, y, rotation]}]
prescribed: [{element: shaft, rate: 3}]
dofs: [{deformations: bar}]
outputs: [{name: stretch, position: tip, along: x}]
)";
  const double stretch = 0.5 * 9 * 8 / (3 * 3e8);
  for (const int n : {1, 2, 4, 8}) {
    // Next: the stretched bar is longer, 1e-8 of it; rounding of the stretch, 4e-8 m, in 2 m: 1e-8.
    EXPECT_NEAR(linear_model(divided(text, n)).y_0(0) / stretch, 1 + 1 / (20.0 * n * n), 5e-8) << n;
  }
}

}  // namespace
}  // namespace stillframe::verification

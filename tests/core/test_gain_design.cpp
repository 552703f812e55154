#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iostream>
#include <vector>

#include "core/control/design/control_loop.hpp"
#include "core/control/design/gain_design.hpp"
#include "core/errors/input_error.hpp"
#include "core/mechanics/frequency_response.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/numerics/two_pi.hpp"
#include "core/numerics/worst.hpp"
#include "tests/core/differences.hpp"
#include "tests/core/scenes.hpp"

namespace stillframe::test {
namespace {

using Complex = std::complex<double>;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

Scene without_leak() {
  Scene scene = frame_scene();
  scene.controller->leak_hz = 0;
  return scene;
}

/// The vertical legs of the frame `factor` times as stiff as the tangential ones.
Scene with_stiff_verticals(double factor, GainOrder order) {
  Scene scene = without_leak();
  for (SceneElement& element : scene.elements) {
    if (element.name.back() == 'v') element.stiffness *= factor;
  }
  scene.controller->order = order;
  return scene;
}

ControlLoop loop_of(const Scene& scene) { return make_control_loop(scene, make_model(scene)); }

Complex target(double omega_d, double zeta, Complex s) {
  return omega_d * omega_d / (s * s + 2 * zeta * omega_d * s + omega_d * omega_d);
}

/// Poles without those of the pure integrators, which are zero.
std::vector<Complex> frame_poles(const ControlLoop& loop, double omega_d) {
  const VectorXcd all = closed_loop_poles(loop.design.legs, loop.gains, omega_d);
  std::vector<Complex> poles(all.begin(), all.end());
  std::sort(poles.begin(), poles.end(),
            [](Complex a, Complex b) { return std::abs(a) < std::abs(b); });
  poles.erase(poles.begin(), poles.begin() + all.size() / 3);
  return poles;
}

/// V3.
TEST(Gains, AllSingularValuesOfTheClosedLoopFallOnTheTarget) {
  for (const Scene& scene : {without_leak(), by_lens_coordinates(without_leak()),
                             with_stiff_verticals(20, GainOrder::exact)}) {
    const ControlLoop loop = loop_of(scene);
    double worst = 0;
    for (const double f : logarithmic_frequencies(0.1, 1000, 400)) {
      const Complex s(0, two_pi * f);
      const double expected = std::abs(target(two_pi * 5, 0.7, s));
      const VectorXd values = singular_values(loop.closed(s));
      worst = worst_of(worst, worst_of((values.array() / expected - 1).matrix()));
    }
    std::cout << "worst relative error of the six singular values of T, 0.1 to 1000 Hz: " << worst
              << "\n";
    EXPECT_LE(worst, 1e-9);  // the bound
  }
}

TEST(Gains, TheClosedLoopIsDecoupledNotOnlyOfTheRightSize) {
  const ControlLoop loop = loop_of(without_leak());
  for (const double f : {0.5, 5.0, 31.0, 200.0}) {
    const Complex s(0, two_pi * f);
    const MatrixXcd expected = target(two_pi * 5, 0.7, s) * MatrixXcd::Identity(6, 6);
    EXPECT_LE((loop.closed(s) - expected).norm(), 1e-9 * expected.norm()) << f;
  }
}

TEST(Gains, TwelvePolesStandOnTheTarget) {
  const double omega_d = two_pi * 5;
  const Complex pole = omega_d * Complex(-0.7, std::sqrt(1 - 0.49));
  const auto poles = frame_poles(loop_of(without_leak()), omega_d);
  ASSERT_EQ(poles.size(), 12u);
  double worst = 0;
  for (const Complex p : poles)
    worst = worst_of(worst, std::abs(Complex(p.real(), std::abs(p.imag())) - pole));
  std::cout << "worst relative error of the twelve poles: " << worst / omega_d << "\n";
  EXPECT_LE(worst, 1e-9 * omega_d);
  EXPECT_EQ(std::count_if(poles.begin(), poles.end(), [](Complex p) { return p.imag() > 0; }), 6);
}

TEST(Gains, ALeakGivesTheLoopItsStaticStiffnessBackAndKeepsItStable) {
  const Scene scene = frame_scene();  // leak 0.05 Hz
  const ControlLoop loop = loop_of(scene);
  const VectorXcd poles = closed_loop_poles(loop.design.legs, loop.gains, two_pi * 5);
  EXPECT_LT(poles.real().maxCoeff<Eigen::PropagateNaN>(), 0);
  // Mode by mode, with x = omega^2 / omega_d^2 an eigenvalue of X (THEORY section 4, C(s) and fact
  // 1): (s^2 + omega^2)(s + omega_l) + s^2 ((x - 1) s + 2 zeta omega_d x) = 0 for q'' = -omega^2 (1
  // + ...) q.
  const double omega_d = two_pi * 5, zeta = 0.7, leak = two_pi * 0.05;
  const MatrixXd X = loop.gains.K_P + MatrixXd::Identity(6, 6);
  for (const Complex x : X.eigenvalues()) {
    const double a = x.real(), omega2 = a * omega_d * omega_d;
    // G_22 = s^2 / (s^2 + omega^2) and 1 + G_22 (K_P s + K_I) / (s + leak) = 0.
    Eigen::Matrix3d companion = Eigen::Matrix3d::Zero();
    companion(1, 0) = companion(2, 1) = 1;
    companion.col(2) << -omega2 * leak / a, -omega2 / a, -(leak + 2 * zeta * omega_d * a) / a;
    for (const Complex p : companion.eigenvalues()) {
      EXPECT_LE((poles.array() - p).abs().minCoeff(), 1e-9 * omega_d) << p;
    }
  }
  // A constant force is held: T - I is the compliance of the loop at rest, zero frequency needs s
  // small only.
  const Complex s(0, two_pi * 1e-6);
  EXPECT_LE((loop.closed(s) - MatrixXcd::Identity(6, 6)).norm(), 1e-3);
}

TEST(Gains, TheOrderOfTheDeckSpreadsThePolesOfUnequalLegs) {
  const double omega_d = two_pi * 5;
  const auto deck = frame_poles(loop_of(with_stiff_verticals(2, GainOrder::deck)), omega_d);
  double lowest = 1e9, highest = 0;
  for (const Complex p : deck) {
    lowest = std::min(lowest, std::abs(p) / omega_d);
    highest = worst_of(highest, std::abs(p) / omega_d);
  }
  EXPECT_NEAR(lowest, 0.88, 0.005);  // THEORY section 4 gives two digits
  EXPECT_NEAR(highest, 1.13, 0.005);
  for (const Complex p : frame_poles(loop_of(with_stiff_verticals(2, GainOrder::exact)), omega_d)) {
    EXPECT_NEAR(std::abs(p) / omega_d, 1.0, 1e-9);
  }
}

TEST(Gains, TheOrderOfTheDeckIsUnstableForVeryUnequalLegs) {
  const double omega_d = two_pi * 5;
  const auto largest_real_part = [&](GainOrder order) {
    const ControlLoop loop = loop_of(with_stiff_verticals(20, order));
    const VectorXcd poles = closed_loop_poles(loop.design.legs, loop.gains, omega_d);
    return poles.real().maxCoeff<Eigen::PropagateNaN>();
  };
  EXPECT_NEAR(largest_real_part(GainOrder::deck), 8.4, 0.05);   // 1/s, THEORY section 4
  EXPECT_NEAR(largest_real_part(GainOrder::exact), 0.0, 1e-9);  // the integrators themselves
  for (const Complex p :
       frame_poles(loop_of(with_stiff_verticals(20, GainOrder::exact)), omega_d)) {
    EXPECT_NEAR(std::abs(p) / omega_d, 1.0, 1e-9);
  }
}

TEST(Gains, BothOrdersAreOneForEqualLegs) {
  Scene deck = without_leak();
  deck.controller->order = GainOrder::deck;
  EXPECT_LE(relative_error(loop_of(deck).gains.K_P, loop_of(without_leak()).gains.K_P), 1e-13);
}

/// Five legs on six dofs: the design knows the five slowest modes of the frame, and these only. The
/// sixth, 49 Hz, is a yaw, which takes a tangential leg; the vertical one would be missed by
/// others.
TEST(Gains, FewerLegsThanDofsControlTheSlowestModes) {
  Scene fewer = frame_scene();
  fewer.controller->reduction = Reduction::modes;
  auto& legs = fewer.controller->legs;
  ASSERT_EQ(legs.back().back(), 'v');
  legs.pop_back();
  try {
    loop_of(fewer);
    FAIL() << "no Refusal";
  } catch (const Refusal& refusal) {
    const std::string text = refusal.what();
    EXPECT_NE(text.find("a motion of e(leg_3v) strains none of them; take other legs, or reduce by "
                        "static_shapes"),
              std::string::npos)
        << text;
  }
  legs = frame_scene().controller->legs;
  legs.erase(legs.end() - 2);
  ASSERT_EQ(legs.size(), 5u);
  const ControlLoop loop = loop_of(fewer);
  ASSERT_EQ(loop.gains.K_P.rows(), 5);
  const VectorXd hz = virtual_frequencies(loop.design.legs) / two_pi;
  const double expected[] = {13.9055, 13.9055, 20.0055, 31.3203, 31.3203};  // THEORY section 3
  for (Index i = 0; i < 5; ++i) EXPECT_NEAR(hz(i), expected[i], 5e-5);      // its last digit
}

TEST(Gains, RefusesLegsThatDoNotFitTheDofs) {
  // Legs that all stand upright hold no sideways motion.
  const MatrixXd singular = VectorXd::Ones(3) * VectorXd::Ones(3).transpose();
  EXPECT_THROW(leg_matrices(MatrixXd::Identity(3, 3), MatrixXd::Identity(3, 3), singular), Refusal);
  EXPECT_THROW(
      design_gains({MatrixXd::Zero(2, 2), MatrixXd::Identity(2, 2)}, 1, 0.7, GainOrder::exact, 0),
      Refusal);
}

TEST(ControlLoop, NeedsControllerInputsAndOutputsThatAreAccelerations) {
  const auto text_of = [](const Scene& scene) -> std::string {
    try {
      loop_of(scene);
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  Scene scene = frame_scene();
  scene.controller.reset();
  EXPECT_NE(text_of(scene).find("the key 'controller' is missing"), std::string::npos);
  scene = frame_scene();
  scene.inputs.clear();
  EXPECT_NE(text_of(scene).find("the key 'inputs' is missing"), std::string::npos);
  // Each by the word that stands in the scene: rad/s^2 are no m/s^2 either.
  for (const auto& [quantity, word] : {std::pair{Quantity::position, "position"},
                                       {Quantity::angular_acceleration, "angular_acceleration"},
                                       {Quantity::torque, "torque"}}) {
    scene = frame_scene();
    scene.outputs.front().quantity = quantity;
    const std::string text = text_of(scene);
    EXPECT_NE(text.find("output 'frame_1t': found '" + std::string(word) +
                        "', a control loop needs 'acceleration' (of a node along a direction)"),
              std::string::npos)
        << text;
  }
}

TEST(ControlLoop, OpenLoopIsThePlantWithoutForces) {
  const Scene scene = frame_scene();
  const ControlLoop loop = loop_of(scene);
  const LinearModel plain = linearise(make_model(scene), scene.inputs, scene.outputs);
  const Complex s(0, two_pi * 7);
  EXPECT_LE((loop.open(s) - transfer_function(plain, s)).norm(), 1e-14 * loop.open(s).norm());
  // The floor moving as one carries the frame along at low frequency.
  const MatrixXcd slow = loop.open({0, two_pi * 1e-3});
  EXPECT_LE((slow - MatrixXcd::Identity(6, 6)).norm(), 1e-7);  // (f / 14 Hz)^2
}

}  // namespace
}  // namespace stillframe::test

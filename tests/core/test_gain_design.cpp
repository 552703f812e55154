#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <iostream>
#include <numbers>
#include <vector>

#include "core/control_loop.hpp"
#include "core/frequency_response.hpp"
#include "core/gain_design.hpp"
#include "core/yaml/input_error.hpp"
#include "tests/core/differences.hpp"
#include "tests/core/scenes.hpp"

namespace stillframe::test {
namespace {

using Complex = std::complex<double>;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

constexpr double two_pi = 2 * std::numbers::pi;

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
  const VectorXcd all = closed_loop_poles(loop.legs, loop.gains, omega_d);
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
      worst = std::max(worst, (values.array() / expected - 1).abs().maxCoeff());
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
    worst = std::max(worst, std::abs(Complex(p.real(), std::abs(p.imag())) - pole));
  std::cout << "worst relative error of the twelve poles: " << worst / omega_d << "\n";
  EXPECT_LE(worst, 1e-9 * omega_d);
  EXPECT_EQ(std::count_if(poles.begin(), poles.end(), [](Complex p) { return p.imag() > 0; }), 6);
}

TEST(Gains, ALeakGivesTheLoopItsStaticStiffnessBackAndKeepsItStable) {
  const Scene scene = frame_scene();  // leak 0.05 Hz
  const ControlLoop loop = loop_of(scene);
  const VectorXcd poles = closed_loop_poles(loop.legs, loop.gains, two_pi * 5);
  EXPECT_LT(poles.real().maxCoeff(), 0);
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
    highest = std::max(highest, std::abs(p) / omega_d);
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
    return closed_loop_poles(loop.legs, loop.gains, omega_d).real().maxCoeff();
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

/// Symmetric, positive definite, with eigenvalues spread evenly on a logarithmic axis over the
/// condition number.
MatrixXd random_spd(Index n, double condition, std::mt19937& engine) {
  MatrixXd A(n, n);
  for (Index j = 0; j < n; ++j) A.col(j) = random_vector(n, engine);
  const MatrixXd Q = Eigen::HouseholderQR<MatrixXd>(A).householderQ();
  const VectorXd values = VectorXd::LinSpaced(n, 0, std::log(condition)).array().exp();
  const MatrixXd S = Q * values.asDiagonal() * Q.transpose();
  return 0.5 * (S + S.transpose());
}

TEST(Gains, ExactOrderDecouplesAnyPairOfMatrices) {
  std::mt19937 engine(12);
  const double omega_d = 30, zeta = 0.7;
  for (const double condition : {1e2, 1e4, 1e6, 1e8}) {
    double worst_loop = 0, worst_residual = 0;
    for (const Index n : {1, 2, 3, 6, 9}) {
      // Ill-conditioned masses on even legs for odd n, even masses on ill-conditioned legs for even
      // n.
      const double of_M = n % 2 == 1 ? condition : 10.0, of_K = n % 2 == 1 ? 10.0 : condition;
      const LegMatrices legs{random_spd(n, of_M, engine), 1e6 * random_spd(n, of_K, engine)};
      const ForceFeedback gains = design_gains(legs, omega_d, zeta, GainOrder::exact, 0);
      const MatrixXd X = gains.K_P + MatrixXd::Identity(n, n);
      // A Cholesky solve leaves a residual of a few eps, whatever the condition; but a small X is
      // lost in K_P = X - I to the rounding of 1.
      const double digits = 1e-15 * (10 + 1 / X.norm());
      const double residual = (omega_d * omega_d * X * legs.M - legs.K).norm() /
                              (omega_d * omega_d * X.norm() * legs.M.norm());
      EXPECT_LE(residual, digits);
      EXPECT_LE(relative_error(gains.K_I, MatrixXd(2 * zeta * omega_d * X)), digits);
      worst_residual = std::max(worst_residual, residual);
      // sigma = G_22 sigma_a + ... with G_22 = s^2 (s^2 + K M^-1)^-1, whose loop must act as the
      // target.
      const Complex s(0, 0.9 * omega_d);
      const MatrixXcd K_M = (omega_d * omega_d * X).cast<Complex>();
      const MatrixXcd I = MatrixXcd::Identity(n, n);
      const MatrixXcd G_22 = (s * s * I + K_M).partialPivLu().solve(s * s * I);
      const MatrixXcd loop = (I - G_22 * gains(s)).partialPivLu().solve(G_22) * X;
      const Complex expected = s * s / (s * s + 2 * zeta * omega_d * s + omega_d * omega_d);
      worst_loop = std::max(worst_loop, (loop - expected * I).norm() / std::abs(expected));
    }
    std::cout << "condition " << condition << ": residual " << worst_residual << ", decoupling "
              << worst_loop << "\n";
    // The loop inverts X, whose condition is that of M times that of K.
    EXPECT_LE(worst_loop, 1e-15 * 10 * condition) << condition;
  }
}

TEST(Gains, PolesOfRandomPairsStandOnTheTarget) {
  std::mt19937 engine(13);
  const double omega_d = 30;
  const Complex pole = omega_d * Complex(-0.7, std::sqrt(1 - 0.49));
  for (const double condition : {1e1, 1e2, 1e3}) {
    double worst = 0;
    for (int k = 0; k < 5; ++k) {
      const LegMatrices legs{random_spd(6, condition, engine),
                             1e6 * random_spd(6, condition, engine)};
      ControlLoop loop;
      loop.legs = legs;
      loop.gains = design_gains(legs, omega_d, 0.7, GainOrder::exact, 0);
      for (const Complex p : frame_poles(loop, omega_d)) {
        worst = std::max(worst, std::abs(Complex(p.real(), std::abs(p.imag())) - pole) / omega_d);
      }
    }
    std::cout << "condition " << condition << ": poles " << worst << "\n";
    // The matrix of the poles holds K M^-1 / omega_d beside omega_d: a rounding of 1e-16 times
    // their ratio (1e3 times the conditions of M and of K) and once more for the eigenvectors.
    EXPECT_LE(worst, 1e-13 * 1e3 * condition * condition) << condition;
  }
}

TEST(Gains, RefusesLegsThatDoNotFitTheDofs) {
  Scene fewer = frame_scene();
  fewer.controller->legs.pop_back();
  EXPECT_THROW(loop_of(fewer), Refusal);
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
  scene = frame_scene();
  scene.outputs.front().quantity = Quantity::position;
  EXPECT_NE(text_of(scene).find(
                "output 'frame_1t': found a m signal, a control loop needs accelerations"),
            std::string::npos);
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

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/mechanics/frequency_response.hpp"
#include "core/mechanics/modes.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/mechanics/state_space.hpp"
#include "core/numerics/worst.hpp"
#include "tests/core/differences.hpp"
#include "tests/core/scenes.hpp"

namespace stillframe::test {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

LinearModel linear(const Scene& scene) {
  return linearise(make_model(scene), scene.inputs, scene.outputs);
}

/// Singular values of G at 40 frequencies, 0.1 to 1000 Hz, a column each.
MatrixXd singular_values_of(const Scene& scene) {
  const LinearModel m = linear(scene);
  const VectorXd f = logarithmic_frequencies(0.1, 1000, 40);
  MatrixXd values(std::min(m.Y_p.rows(), m.B.cols()), f.size());
  for (Index i = 0; i < f.size(); ++i) {
    values.col(i) = singular_values(transfer_function(m, {0, 2 * std::numbers::pi * f(i)}));
  }
  return values;
}

/// V2: THEORY section 3; the deck says 13.9, 13.9, 20.0, 31.3, 31.3, 49.0 Hz.
TEST(MetrologyFrame, NaturalFrequencies) {
  const Modes result = modes(linear(frame_scene()));
  const double expected[] = {13.9055, 13.9055, 20.0055, 31.3203, 31.3203, 49.0032};
  ASSERT_EQ(result.natural_frequencies_hz.size(), 6);
  // Half a unit of the last digit of the reference.
  for (Index i = 0; i < 6; ++i)
    EXPECT_NEAR(result.natural_frequencies_hz(i), expected[i], 5e-5) << i;
}

TEST(MetrologyFrame, SixLegsHoldItStaticallyDeterminately) {
  const Scene scene = frame_scene();
  const LinearModel m = linear(scene);
  EXPECT_LE(relative_error(m.K, MatrixXd(3.95e6 * MatrixXd::Identity(6, 6))), 1e-15);
  EXPECT_EQ(m.G.norm(), 0.0);
  EXPECT_LE(relative_error(m.M_r, m.M),
            1e-12);  // THEORY section 3; the legs' directions have 15 digits
  EXPECT_EQ(m.K_r.norm() + m.D_r.norm(), 0.0);
}

/// The two double modes and the single ones from the 6 x 6 rigid-body problem, written by hand.
TEST(MetrologyFrame, NaturalFrequenciesInClosedForm) {
  const double m = 750, I = 57, I_z = 45, R = 0.6, h = 0.1, k = 3.95e6,
               two_pi = 2 * std::numbers::pi;
  const VectorXd f = modes(linear(frame_scene())).natural_frequencies_hz;
  const double vertical = std::sqrt(3 * k / m) / two_pi,
               yaw = std::sqrt(3 * k * R * R / I_z) / two_pi;
  EXPECT_NEAR(f(2), vertical, 1e-10 * vertical);
  EXPECT_NEAR(f(5), yaw, 1e-10 * yaw);
  // Sway u and tilt phi: the three tangential legs give 3 k / 2 at a depth h, the vertical ones 3 k
  // R^2 / 2.
  const double a = 1.5 * k / m, b = 1.5 * k * (h * h + R * R) / I,
               c2 = std::pow(1.5 * k * h, 2) / (m * I);
  const double mean = 0.5 * (a + b), spread = std::sqrt(0.25 * (a - b) * (a - b) + c2);
  for (const Index i : {0, 1}) EXPECT_NEAR(f(i), std::sqrt(mean - spread) / two_pi, 1e-10 * f(i));
  for (const Index i : {3, 4}) EXPECT_NEAR(f(i), std::sqrt(mean + spread) / two_pi, 1e-10 * f(i));
}

TEST(Modes, ShapesAreMassNormalisedAndSolveTheEigenproblem) {
  for (const Scene& scene : {preloaded_frame(), mechanism()}) {
    const LinearModel m = linear(scene);
    const Modes result = modes(m);
    const MatrixXd& V = result.shapes;
    const VectorXd squares =
        (2 * std::numbers::pi * result.natural_frequencies_hz).array().square();
    EXPECT_LE((V.transpose() * m.M * V - MatrixXd::Identity(V.cols(), V.cols())).norm(), 1e-12);
    EXPECT_LE((V.transpose() * (m.K + m.G) * V - MatrixXd(squares.asDiagonal())).norm(),
              1e-12 * squares.norm());
  }
}

TEST(Modes, DampingRatiosOfTheCart) {
  const Modes result =
      modes(linear(cart_scene()));  // m = 2, d = 4, k = 800: zeta = d / (2 sqrt(k m))
  EXPECT_NEAR(result.natural_frequencies_hz(0), 20 / (2 * std::numbers::pi), 1e-14);
  EXPECT_NEAR(result.damping_ratios(0), 0.05, 1e-15);
  EXPECT_NEAR(result.eigenvalues(0).real(), -1.0, 1e-13);
  EXPECT_NEAR(result.eigenvalues(0).imag(), std::sqrt(399.0), 1e-13);
  EXPECT_NEAR(result.eigenvalues(1).imag(), -std::sqrt(399.0), 1e-13);
}

TEST(Modes, EigenvaluesOfTheUndampedFrameArePairsOnTheImaginaryAxis) {
  const Modes result = modes(linear(frame_scene()));
  ASSERT_EQ(result.eigenvalues.size(), 12);
  for (Index i = 0; i < 6; ++i) {
    const double omega = 2 * std::numbers::pi * result.natural_frequencies_hz(i);
    EXPECT_NEAR(result.eigenvalues(2 * i).imag(), omega, 1e-10 * omega);
    EXPECT_NEAR(result.eigenvalues(2 * i + 1).imag(), -omega, 1e-10 * omega);
    EXPECT_NEAR(result.damping_ratios(i), 0.0, 1e-12);
  }
}

class Invariance : public testing::TestWithParam<bool> {
 protected:
  static Scene scene() {
    if (!GetParam()) return frame_scene();
    Scene scene = preloaded_frame();
    // Accelerations in and out, so that the singular values have one unit.
    scene.outputs.push_back(node_signal("lens", "lens", Quantity::acceleration, {1, 2, 3}));
    return scene;
  }
  static void expect_same(const Scene& a, const Scene& b) {
    // The rotated numbers are rounded to 1e-16; a resonance of a lightly damped mode amplifies that
    // by some 1e3.
    const double tolerance = 1e-10;
    EXPECT_LE(relative_error(modes(linear(b)).natural_frequencies_hz,
                             modes(linear(a)).natural_frequencies_hz),
              tolerance);
    const MatrixXd one = singular_values_of(a), other = singular_values_of(b);
    EXPECT_LE(worst_of((other - one).cwiseQuotient(one)), tolerance);
  }
};

TEST_P(Invariance, UnderRotationAndTranslationOfTheScene) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    expect_same(scene(), moved(scene(), random_rotation(seed), {3, -2, 1}));
  }
}

TEST_P(Invariance, UnderRenumberingOfNodesAndElements) {
  for (unsigned seed = 1; seed <= 3; ++seed) expect_same(scene(), renumbered(scene(), seed));
}

TEST_P(Invariance, UnderAChangeOfUnits) { expect_same(scene(), in_millimetres(scene())); }

INSTANTIATE_TEST_SUITE_P(Frames, Invariance, testing::Values(false, true),
                         [](const auto& param) { return param.param ? "preloaded" : "plain"; });

TEST(FrequencyResponse, AgreesWithTheStateSpace) {
  // C (s I - A)^-1 B + D of the accelerations in, written here from the deck's state space with q^r
  // in the state.
  const Scene scene = frame_scene();
  std::vector<SceneSignal> inputs = scene.inputs, outputs = scene.outputs;
  for (const SceneElement& element : scene.elements) {
    if (element.rigid()) continue;
    inputs.push_back(element_signal("a" + element.name, element.name, Quantity::stress));
    outputs.push_back(element_signal("s" + element.name, element.name, Quantity::stress));
  }
  for (const Scene& by : {scene, by_lens_coordinates(scene)}) {
    const LinearModel m = linearise(make_model(by), inputs, outputs);
    const LoopPlant plant = loop_plant(m, 6, 6);
    // Elongations leave the floor out of the state; lens coordinates need its velocity and
    // position.
    EXPECT_EQ(plant.n_exogenous, by.dofs.front().element.empty() ? 12 : 0);
    for (const double f : {0.3, 5.0, 14.5, 47.0, 300.0}) {
      const std::complex<double> s(0, 2 * std::numbers::pi * f);
      Eigen::MatrixXcd resolvent = -plant.A.cast<std::complex<double>>();
      resolvent.diagonal().array() += s;
      MatrixXd B(plant.A.rows(), 12), C(12, plant.A.rows()), D = MatrixXd::Zero(12, 12);
      B << plant.B_w, plant.B_u;
      C << plant.C_y, plant.C_sigma;
      D.topLeftCorner(6, 6) = plant.D_yw;
      D.topRightCorner(6, 6) = plant.D_yu;
      D.bottomRightCorner(6, 6).setIdentity();
      const Eigen::MatrixXcd found =
          C * resolvent.partialPivLu().solve(B.cast<std::complex<double>>()) + D;
      const Eigen::MatrixXcd expected = transfer_function(m, s);
      // Columns have different units, so each is judged by itself; s I - A has a condition of some
      // 1e5.
      for (Index j = 0; j < 12; ++j) {
        EXPECT_LE((found.col(j) - expected.col(j)).norm(), 1e-9 * expected.col(j).norm())
            << f << " " << j;
      }
    }
  }
}

TEST(FrequencyResponse, LogarithmicFrequencies) {
  const VectorXd f = logarithmic_frequencies(0.1, 1000, 5);
  for (Index i = 0; i < 5; ++i)
    EXPECT_NEAR(f(i), std::pow(10.0, static_cast<double>(i) - 1), 1e-12 * f(i));
}

TEST(FrequencyResponse, SingularValuesOfAKnownMatrix) {
  Eigen::MatrixXcd A = Eigen::MatrixXcd::Zero(2, 2);
  A(0, 1) = {0, 3e-9};
  A(1, 0) = {-4, 0};
  const VectorXd values = singular_values(A);
  EXPECT_DOUBLE_EQ(values(0), 4);
  EXPECT_DOUBLE_EQ(values(1), 3e-9);
}

}  // namespace
}  // namespace stillframe::test

#include <gtest/gtest.h>

#include <iostream>
#include <numbers>

#include "core/control/design/control_loop.hpp"
#include "core/mechanics/dynamics.hpp"
#include "core/mechanics/frequency_response.hpp"
#include "core/mechanics/modes.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/numerics/worst.hpp"
#include "tests/core/differences.hpp"
#include "tests/core/newton_euler.hpp"
#include "tests/core/scenes.hpp"

// The choice of q^d is a choice of coordinates: nothing physical may depend on it.
namespace stillframe::test {
namespace {

using Eigen::MatrixXcd;
using Eigen::VectorXd;

LinearModel linear(const Scene& scene) {
  return linearise(make_model(scene), scene.inputs, scene.outputs);
}

/// Largest |A - B| over |B| (Frobenius) of two transfer functions, 0.1 to 1000 Hz.
double worst_difference(const LinearModel& a, const LinearModel& b) {
  double worst = 0;
  for (const double f : logarithmic_frequencies(0.1, 1000, 200)) {
    const std::complex<double> s(0, 2 * std::numbers::pi * f);
    const MatrixXcd G_a = transfer_function(a, s), G_b = transfer_function(b, s);
    worst = worst_of(worst, (G_a - G_b).norm() / G_b.norm());
  }
  return worst;
}

/// M, K of the two agree to a few 1e-15, and a pole of a few 1e-3 damping amplifies that by less
/// than 1e4.
constexpr double tolerance = 1e-10;

void expect_same_frequencies(const Scene& a, const Scene& b) {
  const VectorXd f_a = modes(linear(a)).natural_frequencies_hz,
                 f_b = modes(linear(b)).natural_frequencies_hz;
  EXPECT_LE(relative_error(f_a, f_b), tolerance);
}

TEST(PartitionInvariance, FrameByElongationsAndByLensCoordinates) {
  const Scene a = frame_scene(), b = by_lens_coordinates(a);
  expect_same_frequencies(a, b);
  const double worst = worst_difference(linear(b), linear(a));
  std::cout << "worst relative difference of G " << worst << "\n";
  EXPECT_LE(worst, tolerance);
}

TEST(PartitionInvariance, PreloadedDampedFrameWithInputsAndOutputsOfEveryKind) {
  Scene a = preloaded_frame();
  use_all_signals_of_frame(a);
  const Scene b = by_lens_coordinates(a);
  expect_same_frequencies(a, b);
  const double worst = worst_difference(linear(b), linear(a));
  std::cout << "worst relative difference of G " << worst << "\n";
  EXPECT_LE(worst, tolerance);
}

TEST(PartitionInvariance, CartBySpringAndByPosition) {
  for (const Quantity quantity : {Quantity::position, Quantity::velocity, Quantity::acceleration}) {
    Scene a = cart_scene(), b = cart_by_position();
    a.inputs.front().quantity = b.inputs.front().quantity = quantity;
    EXPECT_LE(worst_difference(linear(b), linear(a)), 1e-12);  // numbers of order one, one dof
  }
}

TEST(PartitionInvariance, BindsOnTheTermsThatTheDeckLeavesOut) {
  const LinearModel reference = linear(cart_scene());
  LinearModel without_K_r = linear(cart_by_position());
  without_K_r.K_r.setZero();
  EXPECT_GT(worst_difference(without_K_r, reference), 0.1);
  LinearModel without_D_r = linear(cart_by_position());
  without_D_r.D_r.setZero();
  EXPECT_GT(worst_difference(without_D_r, reference), 0.01);
  Scene frame = preloaded_frame();
  use_all_signals_of_frame(frame);
  const LinearModel by_elongations = linear(frame);
  LinearModel without_G_r = linear(by_lens_coordinates(frame));
  without_G_r.G_r.setZero();
  EXPECT_GT(worst_difference(without_G_r, by_elongations), 1e-5);
}

TEST(PartitionInvariance, GainsAndClosedLoop) {
  const Scene a = frame_scene(), b = by_lens_coordinates(a);
  const ControlLoop loop_a = make_control_loop(a, make_model(a)),
                    loop_b = make_control_loop(b, make_model(b));
  EXPECT_LE(relative_error(loop_b.design.legs.M, loop_a.design.legs.M), 1e-12);
  EXPECT_LE(relative_error(loop_b.gains.K_P, loop_a.gains.K_P), 1e-12);
  EXPECT_LE(relative_error(loop_b.gains.K_I, loop_a.gains.K_I), 1e-12);
  double worst = 0;
  for (const double f : logarithmic_frequencies(0.1, 1000, 50)) {
    const std::complex<double> s(0, 2 * std::numbers::pi * f);
    worst = worst_of(worst, (loop_a.closed(s) - loop_b.closed(s)).norm() / loop_a.closed(s).norm());
  }
  // Below the leak the small T comes out of open-loop numbers some 1e3 larger.
  EXPECT_LE(worst, 1e-9);
}

TEST(PartitionInvariance, NonlinearAccelerationsInOneConfiguration) {
  for (const Scene& a : {frame_scene(), preloaded_frame()}) {
    const Scene b = by_lens_coordinates(a);
    const Model by_elongation = make_model(a), by_lens = make_model(b);
    Data data_a(by_elongation), data_b(by_lens);
    std::mt19937 engine(8);
    for (int k = 0; k < 10; ++k) {
      MotionState state_b = random_motion(by_lens, 5e-3, 0.3, engine);
      VectorXd q_ddot(6);
      ASSERT_EQ(accelerations(by_lens, data_b, state_b, VectorXd::Zero(by_lens.n_e), q_ddot),
                DynamicsStatus::ok);
      MotionState state_a(by_elongation);
      for (Index i = 0; i < 6; ++i) {
        const Index row = by_lens.deformation_row(a.dofs[static_cast<size_t>(i)].element);
        state_a.q_d(i) = data_b.e(row);
        state_a.q_d_dot(i) = data_b.e_dot(row);
      }
      // Both models number the prescribed coordinates in the order of the nodes.
      state_a.q_r = state_b.q_r;
      state_a.q_r_dot = state_b.q_r_dot;
      state_a.q_r_ddot = state_b.q_r_ddot;
      ASSERT_EQ(
          accelerations(by_elongation, data_a, state_a, VectorXd::Zero(by_elongation.n_e), q_ddot),
          DynamicsStatus::ok);
      const RigidAcceleration one = rigid_acceleration(a, by_elongation, data_a),
                              other = rigid_acceleration(b, by_lens, data_b);
      // Elongations are handed over with an absolute rounding of 1e-18 m on 5e-3 m; a few hundred
      // operations.
      EXPECT_LE((one.linear - other.linear).norm(), 1e-11 * other.linear.norm());
      EXPECT_LE((one.angular - other.angular).norm(), 1e-11 * other.angular.norm());
    }
  }
}

}  // namespace
}  // namespace stillframe::test

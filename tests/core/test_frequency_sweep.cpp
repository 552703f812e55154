#include <gtest/gtest.h>

#include <random>

#include "core/numerics/singular_values.hpp"
#include "core/systems/frequency_sweep.hpp"
#include "tests/support/allocation_count.hpp"
#include "tests/support/augment.hpp"
#include "tests/support/frame_state_space.hpp"
#include "tests/support/quadruple.hpp"

namespace stillframe {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Kind = InputColumns::Kind;
using test::augmented;
using test::FrameOutputs;

MatrixXcd transfer(const StateSpace& system, Complex s) {
  FrequencySweep sweep(system);
  MatrixXcd G(sweep.n_outputs(), sweep.n_inputs());
  sweep.evaluate(s, G);
  return G;
}

MatrixXcd exact(const StateSpace& system, Complex s) {
  return test::rounded(test::quadruple_transfer(system, s));
}

StateSpace random_system(Index n, Index p, const std::vector<Kind>& kinds, unsigned seed) {
  std::mt19937 engine(seed);
  std::normal_distribution<double> normal;
  const auto matrix = [&](Index rows, Index columns) -> MatrixXd {
    return MatrixXd::NullaryExpr(rows, columns, [&](Index, Index) { return normal(engine); });
  };
  StateSpace out;
  Index columns = 0;
  for (const Kind kind : kinds) {
    out.columns.push_back({kind, columns});
    columns += out.columns.back().width();
  }
  out.A = matrix(n, n) - 2 * std::sqrt(static_cast<double>(n)) * MatrixXd::Identity(n, n);
  out.B = matrix(n, columns);
  out.C = matrix(p, n);
  out.D = matrix(p, columns);
  return out;
}

/// Mass, damper and spring on a moving cart: deck, section 11.1.
StateSpace cart(double m, double d, double k, Kind kind) {
  StateSpace out;
  out.A = (MatrixXd(2, 2) << 0, 1, -k / m, -d / m).finished();
  out.B = (MatrixXd(2, 3) << 0, 0, 0, -1, 0, 0).finished();
  out.C = (MatrixXd(1, 2) << 1, 0).finished();
  out.D = (MatrixXd(1, 3) << 0, 0, 1).finished();
  out.columns = {{kind, 0}};
  out.inputs = {{"cart", "m"}};
  return out;
}

TEST(frequency_sweep, three_cases_of_the_cart_in_closed_form) {
  const double m = 2, d = 0.3, k = 500;
  for (const Complex s : {Complex(0, 1), Complex(0, 15.7), Complex(0, 400), Complex(-3, 20)}) {
    const Complex G_1 = (d * s / m + k / m) / (s * s + d * s / m + k / m);
    // 1 - s^2 / (s^2 + ...) cancels by up to |s|^2 / |ds/m + k/m| = 500 here.
    const double tolerance = 1e-12;
    EXPECT_LT(std::abs(transfer(cart(m, d, k, Kind::position), s)(0, 0) / G_1 - 1.0), tolerance);
    EXPECT_LT(std::abs(transfer(cart(m, d, k, Kind::velocity), s)(0, 0) * s / G_1 - 1.0),
              tolerance);
    EXPECT_LT(std::abs(transfer(cart(m, d, k, Kind::acceleration), s)(0, 0) * s * s / G_1 - 1.0),
              tolerance);
  }
}

TEST(frequency_sweep, random_systems_of_mixed_kinds_against_113_bits) {
  const std::vector<Kind> kinds = {Kind::acceleration, Kind::direct, Kind::position,
                                   Kind::velocity,     Kind::direct, Kind::acceleration};
  for (const Index n : {1, 2, 5, 12, 25}) {
    const StateSpace system = random_system(n, 7, kinds, static_cast<unsigned>(n));
    for (const double omega : {1e-3, 0.7, 30.0}) {
      const Complex s(0.1 * omega, omega);
      const MatrixXcd G = transfer(system, s), reference = exact(system, s);
      for (Index j = 0; j < G.cols(); ++j) {
        // Reduction and solution: some n roundings of each column, poles are 0.1 |A| away or more.
        EXPECT_LT((G.col(j) - reference.col(j)).norm(), 1e-13 * reference.col(j).norm())
            << n << " " << omega << " " << j;
      }
    }
  }
}

TEST(frequency_sweep, both_ways_to_accelerations_agree) {
  // Note 2 of section 10: integrals as states against division by s and s^2.
  StateSpace system = random_system(
      6, 4, {Kind::acceleration, Kind::direct, Kind::velocity, Kind::acceleration}, 3);
  system.B.col(4).setZero();  // the derivative of the velocity input: no proper system has it
  system.D.col(4).setZero();
  const StateSpace proper = augmented(system);
  EXPECT_EQ(proper.A.rows(), 6 + 2 + 1 + 2);
  EXPECT_EQ(proper.B.cols(), 4);
  for (const double omega : {0.1, 1.0, 10.0}) {
    const Complex s(0, omega);
    const MatrixXcd G = transfer(system, s);
    EXPECT_LT((transfer(proper, s) - G).norm(), 1e-12 * G.norm()) << omega;
    EXPECT_LT((transfer(proper, s) - exact(system, s)).norm(), 1e-12 * G.norm()) << omega;
  }
}

TEST(frequency_sweep, integrals_that_nobody_uses_are_no_states) {
  const StateSpace frame = frame_state_space(FrameOutputs::accelerations_and_stresses);
  EXPECT_EQ(augmented(frame).A.rows(), 12);
  // Without them, G is finite at s = 0: the frame stands still under constant forces, and follows
  // a constant acceleration.
  const MatrixXcd G = transfer(frame, 0.0);
  const MatrixXd I = MatrixXd::Identity(6, 6);
  EXPECT_LT((G.topLeftCorner(6, 6) - I).norm(), 1e-13);
  // k M^-1 times its inverse: a few roundings of the condition of M, below 100.
  EXPECT_LT(G.topRightCorner(6, 6).norm(), 1e-14 * frame.D.norm());
}

TEST(frequency_sweep, augmented_refuses_inputs_that_need_derivatives) {
  EXPECT_THROW(augmented(cart(1, 1, 1, Kind::position)), std::invalid_argument);
  EXPECT_THROW(augmented(cart(1, 1, 1, Kind::velocity)), std::invalid_argument);
  EXPECT_EQ(augmented(cart(1, 1, 1, Kind::acceleration)).A.rows(), 4);
}

TEST(frequency_sweep, keeps_its_digits_next_to_undamped_poles) {
  const StateSpace frame = frame_state_space(FrameOutputs::accelerations_and_elongations);
  FrequencySweep sweep(frame);
  MatrixXcd G(12, 12);
  for (const Complex& pole : sweep.poles()) {
    for (const double distance : {-1e-12, 1e-12, 1e-9, 1e-6, 1e-4}) {
      const Complex s(0, pole.imag() * (1 + distance));
      const MatrixXcd reference = exact(frame, s);
      sweep.evaluate(s, G);
      // Refined until only the rounding of the solution is left; elimination on s I - A has 3e-4
      // at 1e-12.
      EXPECT_LT((G - reference).norm(), 1e-14 * reference.norm()) << pole << " " << distance;
    }
  }
}

TEST(frequency_sweep, defective_and_repeated_poles) {
  // Two undamped oscillators of the very same frequency, the first driving the second: next to the
  // pole G grows with the inverse square of the distance.
  StateSpace system;
  system.A = MatrixXd::Zero(4, 4);
  system.A.topLeftCorner(2, 2) << 0, 3, -3, 0;
  system.A.bottomRightCorner(2, 2) << 0, 3, -3, 0;
  system.A(3, 0) = 1.5;
  system.B = MatrixXd::Identity(4, 4);
  system.C = MatrixXd::Identity(4, 4);
  system.D = MatrixXd::Zero(4, 4);
  for (Index j = 0; j < 4; ++j) system.columns.push_back({Kind::direct, j});
  for (const double distance : {1e-2, 1e-3, 1e-4, 1e-6}) {
    const Complex s(0, 3 * (1 + distance));
    const MatrixXcd reference = exact(system, s);
    // Rounding of the refined solution; at 1e-2, where none is done, rounding over the square of
    // the distance.
    const double tolerance = distance == 1e-2 ? 1e-11 : 1e-14;
    EXPECT_LT((transfer(system, s) - reference).norm(), tolerance * reference.norm()) << distance;
  }
}

TEST(frequency_sweep, where_a_diagonal_entry_of_the_reduced_matrix_meets_s) {
  StateSpace system = random_system(2, 2, {Kind::direct, Kind::direct}, 5);
  system.A << -1, 3, -3, -1;
  // Poles -1 +- 3j are 3 away; (s I - A)^-1 is a rotation over 3.
  const MatrixXd rotation = (MatrixXd(2, 2) << 0, 1, -1, 0).finished();
  const MatrixXd G = system.C * rotation / 3 * system.B + system.D;
  EXPECT_LT((transfer(system, -1.0) - G).norm(), 1e-14 * G.norm());  // a few roundings
}

TEST(frequency_sweep, units_of_the_states_do_not_matter) {
  StateSpace frame = frame_state_space(FrameOutputs::accelerations_and_elongations);
  const Complex s(0, 100);
  const MatrixXcd G = transfer(frame, s);
  Eigen::VectorXd unit(12);
  for (Index i = 0; i < 12; ++i) unit(i) = std::ldexp(1.0, static_cast<int>(5 * i) - 30);
  frame.A = unit.asDiagonal() * frame.A * unit.cwiseInverse().asDiagonal();
  frame.B = unit.asDiagonal() * frame.B;
  frame.C = frame.C * unit.cwiseInverse().asDiagonal();
  // Balanced by powers of two: as good as without, some n roundings over the distance to the pole.
  EXPECT_LT((transfer(frame, s) - G).norm(), 1e-13 * G.norm());
}

TEST(frequency_sweep, frame_isolates_and_newton_holds) {
  // M a = -sigma at every frequency, so half the singular values vanish.
  const StateSpace frame = frame_state_space(FrameOutputs::accelerations_and_stresses);
  const MatrixXd M = test::frame_mass_matrix();
  Eigen::VectorXd omega(9);
  omega << 0.5, 3, 10, 50, 100, 150, 250, 1000, 6000;
  const MatrixXd values = singular_values_over(frame, omega);
  ASSERT_EQ(values.rows(), 12);
  for (Index i = 0; i < omega.size(); ++i) {
    const MatrixXcd G = transfer(frame, {0, omega(i)});
    EXPECT_LT((M * G.topRows(6) + G.bottomRows(6)).norm(), 1e-12 * (M * G.topRows(6)).norm());
    EXPECT_LT(values(6, i), 1e-14 * values(0, i));
    EXPECT_LT((values.col(i) - singular_values(G)).norm(), 1e-14 * values(0, i));
  }
}

TEST(frequency_sweep, no_states_or_no_inputs) {
  StateSpace gain;
  gain.A = MatrixXd(0, 0);
  gain.B = MatrixXd(0, 1);
  gain.C = MatrixXd(2, 0);
  gain.D = (MatrixXd(2, 1) << 3, 4).finished();
  gain.columns = {{Kind::direct, 0}};
  EXPECT_EQ(transfer(gain, {0, 1}), gain.D.cast<Complex>());
  EXPECT_EQ(singular_values_over(gain, Eigen::VectorXd::Ones(1))(0), 5.0);
}

TEST(frequency_sweep, hot_path_allocates_nothing) {
  FrequencySweep sweep(frame_state_space(FrameOutputs::accelerations_and_stresses));
  MatrixXcd G(12, 12);
  const Complex near_pole(0, std::abs(sweep.poles()(0).imag()) * (1 + 1e-9));
  const auto before = test::allocation_count();
  sweep.evaluate({0, 10}, G);
  sweep.evaluate(near_pole, G);
  EXPECT_EQ(test::allocation_count(), before);
}

TEST(frequency_sweep, refuses_shapes_that_do_not_match) {
  const StateSpace good = random_system(3, 2, {Kind::direct, Kind::position}, 1);
  EXPECT_NO_THROW(FrequencySweep{good});
  StateSpace bad = good;
  bad.B = MatrixXd::Zero(2, 4);
  EXPECT_THROW(FrequencySweep{bad}, std::invalid_argument);
  bad = good;
  bad.columns.push_back({Kind::velocity, 3});
  EXPECT_THROW(FrequencySweep{bad}, std::invalid_argument);
  bad = good;
  bad.A(0, 0) = std::numeric_limits<double>::infinity();
  EXPECT_THROW(FrequencySweep{bad}, std::invalid_argument);
  bad = good;
  bad.outputs = {{"only one", "m"}};
  EXPECT_THROW(FrequencySweep{bad}, std::invalid_argument);
}

}  // namespace
}  // namespace stillframe

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <vector>

#include "core/control/design/control_loop.hpp"
#include "core/control/design/gain_design.hpp"
#include "core/errors/input_error.hpp"
#include "core/numerics/two_pi.hpp"
#include "tests/core/random_pairs.hpp"
#include "tests/core/scenes.hpp"
#include "tests/hard_cases/reached.hpp"

namespace stillframe::test {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

LegMatrices frame_legs() {
  const Scene scene = frame_scene();
  return make_control_loop(scene, make_model(scene)).design.legs;
}

/// The error, printed beside the product of the conditions of M and K.
double told(const char* what, double error, const LegMatrices& legs) {
  reached(what, error, condition_number(legs.M) * condition_number(legs.K));
  return error;
}

/// Error of the poles of gains rounded to doubles.
double pole_error(const LegMatrices& legs, double omega_d, double zeta) {
  const ForceFeedback gains = design_gains(legs, omega_d, zeta, GainOrder::exact, 0);
  const VectorXcd poles = closed_loop_poles(legs, gains, omega_d);
  return distance_from_target(poles.tail(2 * legs.M.rows()), omega_d, zeta);
}

double designed_pole_error(const LegMatrices& legs, double omega_d, double zeta) {
  const GainDesign design = extended_gains(legs, {{omega_d, zeta}}, GainOrder::exact);
  const VectorXcd poles = closed_loop_poles(legs, design, omega_d);
  return distance_from_target(poles.tail(2 * legs.M.rows()), omega_d, zeta);
}

// The poles are repeated but not defective, so that they move by eps times a condition and not by
// its sixth root, 2e-3.
TEST(RepeatedPoles, SixOfEachMoveNoFurtherThanOneWould) {
  const double omega_d = two_pi * 5, zeta = 0.7;
  // Six modes of one frequency, on legs that are coupled all the same: M and K proportional.
  std::mt19937 engine(61);
  const MatrixXd M = 100 * random_spd(6, 1e2, engine);
  const LegMatrices alike{M, 4e4 * M};
  const LegMatrices generic{M, 1e7 * random_spd(6, 1e2, engine)};
  // X = 40 I: eps, n-fold. The frame: condition of M 10 or so. Generic: both conditions, 1e4. All
  // with sqrt(6) (1 + 2 zeta) / (2 sqrt(1 - zeta^2)) = 4 of bound_of_rounding in
  // core/test_gain_accuracy.
  EXPECT_LE(told("six modes of one frequency: poles", pole_error(alike, omega_d, zeta), alike),
            4 * 1.1e-14);
  const LegMatrices frame = frame_legs();
  EXPECT_LE(told("metrology frame: poles", pole_error(frame, omega_d, zeta), frame), 4 * 1.1e-15);
  EXPECT_LE(
      told("six generic modes of one target: poles", pole_error(generic, omega_d, zeta), generic),
      4 * 1.1e-12);
}

// Critical damping is where the poles are defective: both roots of each mode meet and part with the
// square root of what moves them.
TEST(RepeatedPoles, OfCriticalDampingMoveWithTheSquareRoot) {
  std::mt19937 engine(62);
  for (const double condition : {1e1, 1e2, 1e4, 1e6, 1e8}) {
    const LegMatrices legs{random_spd(6, condition, engine),
                           1e6 * random_spd(6, condition, engine)};
    // (s + omega_d)^2 = omega_d^2 (1 - lambda), |1 - lambda| < 2^-53 sqrt(6) 3 cond(M) cond(K), or
    // 2^-102 with as much again for the sums.
    const double square = condition * condition * 8;
    if (condition < 1e6) {
      EXPECT_LE(pole_error(legs, 30, 1), std::sqrt(square * 0x1p-53)) << condition;
    }
    EXPECT_LE(designed_pole_error(legs, 30, 1), std::sqrt(8 * square * 0x1p-102)) << condition;
  }
  // So a double root of the design itself stays within 1e-9 up to conditions of some 1e5 each.
  const LegMatrices legs{random_spd(6, 1e5, engine), 1e6 * random_spd(6, 1e5, engine)};
  EXPECT_LE(told("critically damped: poles as designed", designed_pole_error(legs, 30, 1), legs),
            1e-9);
}

/// A frame of three legs with next to no mass along one direction.
LegMatrices light(double part, const MatrixXd& Q) {
  std::mt19937 engine(63);
  const MatrixXd M = Q * VectorXd{{1.0, 2.0, part}}.asDiagonal() * Q.transpose();
  return {0.5 * (M + M.transpose()), 1e4 * random_spd(3, 10, engine)};
}

TEST(NearlySingularMass, OfOneLegAlone) {
  // Its column of X is large and holds all its digits; nothing is lost by rounding.
  for (const double part : {1e-6, 1e-12, 1e-15}) {
    const LegMatrices legs = light(part, MatrixXd::Identity(3, 3));
    const ForceFeedback gains = design_gains(legs, 30, 0.7, GainOrder::exact, 0);
    EXPECT_NEAR(gains.K_P(2, 2) * part * 900 / legs.K(2, 2), 1, 1e-6);  // K_33 / (m omega_d^2)
    // cond(K) = 10 of the matrices scaled to unit masses, otherwise as above.
    EXPECT_LE(told("one light leg: poles", pole_error(legs, 30, 0.7), legs), 4 * 1.1e-15 * 10);
  }
}

TEST(NearlySingularMass, AcrossAllLegs) {
  std::mt19937 engine(64);
  const MatrixXd Q = random_orthogonal(3, engine);
  for (const double part : {1e-6, 1e-12}) {
    const LegMatrices legs = light(part, Q);
    // Gains about K / (part omega_d^2), and nearly of rank one: the digits of the heavy directions
    // are lost as they are rounded, and the poles with them; the design has them.
    const double rounded = told("one light direction: poles", pole_error(legs, 30, 0.7), legs);
    const double designed = designed_pole_error(legs, 30, 0.7);
    EXPECT_GE(extended_gains(legs, {{30, 0.7}}, GainOrder::exact).gains().K_P.norm(), 1 / part);
    EXPECT_LE(rounded, 4 * 1.1e-16 * 10 * 2 / part);
    EXPECT_GE(rounded, 1e-3 * 1.1e-16 / part);
    EXPECT_LE(designed, 1e-9);
  }
}

TEST(NearlySingularMass, SingularToRoundingIsRefused) {
  std::mt19937 engine(65);
  const MatrixXd Q = random_orthogonal(3, engine);
  std::vector<LegMatrices> all{light(0, MatrixXd::Identity(3, 3)), light(-1e-3, Q)};
  // Of rank two, but for rounding, which makes about half of them positive definite.
  for (int k = 0; k < 20; ++k) all.push_back(light(0, random_orthogonal(3, engine)));
  for (const LegMatrices& legs : all) {
    EXPECT_THROW(design_gains(legs, 30, 0.7, GainOrder::exact, 0), Refusal);
    EXPECT_THROW(virtual_frequencies(legs), Refusal);
  }
  // Tiny, but a number of its own.
  EXPECT_NO_THROW(
      design_gains(light(1e-100, MatrixXd::Identity(3, 3)), 30, 0.7, GainOrder::exact, 0));
  LegMatrices loose = light(1, Q);
  loose.K = VectorXd::Ones(3) * VectorXd::Ones(3).transpose();
  EXPECT_THROW(design_gains(loose, 30, 0.7, GainOrder::exact, 0), Refusal);
}

/// Six decades of targets around modes of 13.9 to 49 Hz.
TEST(FarTargets, BelowAndAboveAllModes) {
  const LegMatrices legs = frame_legs();
  for (const double f : {1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0, 1e3}) {
    const double omega_d = two_pi * f;
    // 1 is subtracted from X and added again: where the slowest mode is far below the target, eps
    // of 1 is eps (f / 13.9 Hz)^2 of X; otherwise eps times the condition of M.
    const double bound = 4 * 1.1e-16 * std::max(10.0, std::pow(f / 13.9, 2));
    EXPECT_LE(told("target of 1e-3 to 1e3 Hz: poles", pole_error(legs, omega_d, 0.7), legs), bound)
        << f;
    EXPECT_LE(bound, 1e-9);  // the bound
    const ForceFeedback gains = design_gains(legs, omega_d, 0.7, GainOrder::exact, 0);
    const MatrixXd X = gains.K_P + MatrixXd::Identity(6, 6);
    const VectorXcd x = X.eigenvalues();
    // Eigenvalues omega^2 / omega_d^2 of X, slowest 13.9055 Hz, fastest 49.0032 Hz.
    EXPECT_NEAR(x.real().minCoeff() * std::pow(f / 13.9055, 2), 1, 1e-5) << f;
    EXPECT_NEAR(x.real().maxCoeff() * std::pow(f / 49.0032, 2), 1, 1e-5) << f;
    // Above the modes the legs are made stiffer: K_P is negative, and I + K_P is not.
    const VectorXd k = gains.K_P.eigenvalues().real();
    EXPECT_EQ(k.maxCoeff() < 0, f > 49);
    EXPECT_EQ(k.minCoeff() > 0, f < 13.9);
    EXPECT_GT(x.real().minCoeff(), 0);
  }
}

/// x s^3 + (omega_l + 2 zeta omega_d x) s^2 + omega^2 (s + omega_l) = 0 of a mode with
/// x = omega^2 / omega_d^2 has the slow root s = -omega_l (1 + 2 zeta omega_l / omega_d + ...): one
/// for every mode, whatever its frequency.
TEST(VanishingLeak, SlowPolesFollowTheLeakDownToZero) {
  const LegMatrices legs = frame_legs();
  const double omega_d = two_pi * 5, zeta = 0.7;
  const auto poles_with = [&](double leak) {
    return closed_loop_poles(legs, design_gains(legs, omega_d, zeta, GainOrder::exact, leak),
                             omega_d);
  };
  const VectorXcd without = poles_with(0);
  EXPECT_EQ(without.head(6), VectorXcd::Zero(6));
  for (const double f : {1e-1, 1e-2, 1e-3, 1e-6, 1e-9, 1e-12}) {
    const double leak = two_pi * f, small = leak / omega_d;
    const VectorXcd poles = poles_with(leak);
    for (const Complex pole : poles.head(6)) {
      // Next term: (8 zeta^2 - 1 + omega_d^2 / omega^2) small^2, at most 3.1; the gains are
      // rounded.
      EXPECT_LE(std::abs(pole / leak + 1.0 + 2 * zeta * small), 4 * small * small + 1e-15) << f;
    }
    // The other twelve pass into those of no leak: by the derivative of the same equation they move
    // by |s^2 + omega^2| / (x |s| |2 s + 2 zeta omega_d|) < (1 + 1/x) / 1.4 < 0.8 times the leak.
    for (const Complex pole : poles.tail(12)) {
      EXPECT_LE((without.tail(12).array() - pole).abs().minCoeff(), leak + 1e-14 * omega_d) << f;
    }
  }
}

}  // namespace
}  // namespace stillframe::test

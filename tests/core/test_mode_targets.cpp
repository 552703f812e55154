#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <numbers>
#include <string>

#include "core/control/continuous_loop.hpp"
#include "core/control/design/control_loop.hpp"
#include "core/control/design/gain_design.hpp"
#include "core/errors/input_error.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "core/mechanics/state_space.hpp"
#include "core/numerics/worst.hpp"
#include "tests/core/random_pairs.hpp"
#include "tests/core/scenes.hpp"

// A target for every virtual mode.
namespace stillframe::test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

const std::vector<ModeTarget> four{{10, 0.5}, {20, 0.7}, {3, 0.9}, {40, 0.3}};

LegMatrices four_legs(unsigned seed) {
  std::mt19937 engine(seed);
  return {random_spd(4, 30, engine), 1e4 * random_spd(4, 30, engine)};
}

TEST(ModeTargets, EveryModeGetsItsOwnPair) {
  for (const unsigned seed : {41u, 42u, 43u}) {
    const LegMatrices legs = four_legs(seed);
    const ForceFeedback gains = extended_gains(legs, four, GainOrder::exact).gains();
    const VectorXcd poles = closed_loop_poles(legs, gains, 20);
    for (const auto& [omega_d, zeta] : four) {
      for (const auto root : target_roots(omega_d, zeta)) {
        // eps times both conditions, 1e3, and sums of four.
        EXPECT_LE((poles.array() - root).abs().minCoeff<Eigen::PropagateNaN>(), 1e-12 * omega_d);
      }
    }
  }
}

/// X M phi_i = K phi_i / omega_di^2 and K_I M phi_i = 2 zeta_i / omega_di K phi_i, with the shapes
/// of another solver; the deck's order has the same from the left.
TEST(ModeTargets, TheSlowestModeComesFirst) {
  const LegMatrices legs = four_legs(44);
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> modes(legs.K, legs.M);
  const VectorXd frequencies = virtual_frequencies(legs);
  const MatrixXd I = MatrixXd::Identity(4, 4);
  for (const GainOrder order : {GainOrder::exact, GainOrder::deck}) {
    const ForceFeedback gains = extended_gains(legs, four, order).gains();
    const bool exact = order == GainOrder::exact;
    const MatrixXd X = exact ? MatrixXd(I + gains.K_P) : MatrixXd(I + gains.K_P.transpose());
    const MatrixXd K_I = exact ? gains.K_I : MatrixXd(gains.K_I.transpose());
    for (Index i = 0; i < 4; ++i) {
      const auto& [omega_d, zeta] = four[static_cast<size_t>(i)];
      const VectorXd phi = modes.eigenvectors().col(i), K_phi = legs.K * phi;
      const VectorXd X_M_phi = X * legs.M * phi, K_I_M_phi = K_I * legs.M * phi;
      // As above.
      EXPECT_LE((X_M_phi * omega_d * omega_d - K_phi).norm(), 1e-12 * K_phi.norm()) << i;
      EXPECT_LE((K_I_M_phi * omega_d / (2 * zeta) - K_phi).norm(), 1e-12 * K_phi.norm()) << i;
      EXPECT_NEAR(frequencies(i) / std::sqrt(modes.eigenvalues()(i)), 1, 1e-13);
    }
  }
}

TEST(ModeTargets, OneTargetGivenToEachModeIsOneTargetForAll) {
  const LegMatrices legs = four_legs(45);
  for (const GainOrder order : {GainOrder::exact, GainOrder::deck}) {
    const ForceFeedback each =
        extended_gains(legs, std::vector<ModeTarget>(4, {20, 0.7}), order).gains();
    const ForceFeedback all = extended_gains(legs, {{20, 0.7}}, order).gains();
    // Both are rounded once, from errors of 2^-102: one unit in the last place at most.
    EXPECT_LE(worst_of((each.K_P - all.K_P).cwiseQuotient(all.K_P)), 2.3e-16);
    EXPECT_LE(worst_of((each.K_I - all.K_I).cwiseQuotient(all.K_I)), 2.3e-16);
  }
}

LegMatrices frame_legs() {
  const Scene scene = frame_scene();
  return make_control_loop(scene, make_model(scene)).design.legs;
}

std::vector<ModeTarget> frame_targets(double of_second, double zeta_of_second = 0.7) {
  // Modes 1 and 2 of the frame are of one frequency, and so are 4 and 5.
  return {{30, 0.7}, {of_second, zeta_of_second}, {25, 0.7}, {40, 0.6}, {40, 0.6}, {60, 0.5}};
}

TEST(ModeTargets, ModesOfOneFrequencyNeedOneTarget) {
  const LegMatrices legs = frame_legs();
  for (const auto& targets : {frame_targets(31), frame_targets(30, 0.71)}) {
    try {
      extended_gains(legs, targets, GainOrder::exact);
      FAIL() << "no Refusal";
    } catch (const Refusal& refusal) {
      const std::string text = refusal.what();
      EXPECT_NE(text.find("virtual modes 1 and 2 are of one frequency, 13.9055 Hz"),
                std::string::npos)
          << text;
      EXPECT_NE(text.find("give them the same target"), std::string::npos) << text;
    }
  }
  const ForceFeedback gains = extended_gains(legs, frame_targets(30), GainOrder::exact).gains();
  const VectorXcd poles = closed_loop_poles(legs, gains, 30);
  for (const auto& [omega_d, zeta] : frame_targets(30)) {
    const auto root = target_roots(omega_d, zeta)[0];
    EXPECT_LE((poles.array() - root).abs().minCoeff<Eigen::PropagateNaN>(), 1e-12 * omega_d);
  }
  EXPECT_EQ(((poles.array() - target_roots(40, 0.6)[0]).abs() < 1e-9).count(), 2);
}

TEST(ModeTargets, CloseModesThatAreNotOneAreTold) {
  const MatrixXd M = MatrixXd::Identity(2, 2);
  const auto with_gap = [&](double relative) {
    const MatrixXd K = VectorXd{{100.0, 100 * (1 + 2 * relative)}}.asDiagonal();
    return extended_gains({M, K}, {{1, 0.7}, {2, 0.7}}, GainOrder::exact).gains().K_P;
  };
  EXPECT_THROW(with_gap(0.9e-6), Refusal);
  EXPECT_NEAR(with_gap(1.1e-6)(1, 1), 100 * (1 + 2.2e-6) / 4 - 1, 1e-13);
}

TEST(ModeTargets, WrongNumbersOfTargetsAreErrors) {
  const LegMatrices legs = four_legs(46);
  for (const auto& targets : {std::vector<ModeTarget>{}, std::vector<ModeTarget>(3, {20, 0.7}),
                              std::vector<ModeTarget>{{0, 0.7}}, std::vector<ModeTarget>{{20, -1}},
                              std::vector<ModeTarget>{{NAN, 0.7}}}) {
    EXPECT_THROW(extended_gains(legs, targets, GainOrder::exact), std::invalid_argument);
  }
}

/// A mass in a plane on three legs, so that there are two modes.
Scene mass_on_three_legs(const std::string& targets) {
  return parse_scene(R"(title: Mass on three legs
planar: true
nodes:
  mass: {position: [0, 0]}
  below: {position: [0, -0.3]}
  aside: {position: [-0.4, 0]}
  askew: {position: [0.3, -0.2]}
masses: [{node: mass, mass: 40}]
elements:
  post: {type: truss, nodes: [below, mass], stiffness: 6e5}
  strut: {type: truss, nodes: [aside, mass], stiffness: 2e5}
  brace: {type: truss, nodes: [askew, mass], stiffness: 3e5}
prescribed: [{nodes: [below, aside, askew], move: [x, y]}]
dofs: [{node: mass, along: x}, {node: mass, along: y}]
inputs: [{name: w, acceleration: below, along: y}]
outputs: [{name: y, acceleration: mass, along: y}]
controller: {legs: [post, strut, brace], damping_ratio: 0.7, sample_rate_hz: 1000, delay_samples: 1,
  leak_hz: 0, target_hz: )" +
                         targets + "}\n",
                     "three_legs.yaml");
}

std::string error_of(const std::string& targets) {
  try {
    const Scene scene = mass_on_three_legs(targets);
    make_control_loop(scene, make_model(scene));
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

// There are as many as dofs then, which reading a scene does not tell.
TEST(ModeTargets, MoreLegsThanDofsHaveATargetForEachMode) {
  const Scene scene = mass_on_three_legs("[4, 6]");
  const ControlLoop loop = make_control_loop(scene, make_model(scene));
  const VectorXcd poles = closed_loop_poles(loop_plant(loop.plant, loop.n_w, loop.n_y), loop.gains);
  for (const double hz : {4.0, 6.0}) {
    const auto root = target_roots(2 * std::numbers::pi * hz, 0.7)[0];
    // eps times the 45 of X, whose inverse the law's integrators have, and sums of seven states.
    EXPECT_LE((poles.array() - root).abs().minCoeff<Eigen::PropagateNaN>(), 1e-12 * std::abs(root));
  }
  EXPECT_EQ(error_of("[4, 6]"), "");
  EXPECT_NE(error_of("[4, 6, 8]")
                .find("target_hz: found 3 numbers, allowed are one, or one for "
                      "each of the 2 virtual modes"),
            std::string::npos)
      << error_of("[4, 6, 8]");
  EXPECT_NE(error_of("[4, 6, 8, 9]").find("at most 3"), std::string::npos)
      << error_of("[4, 6, 8, 9]");
}

}  // namespace
}  // namespace stillframe::test

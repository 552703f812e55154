#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "core/control/continuous_loop.hpp"
#include "core/control/design/compliance.hpp"
#include "core/control/design/control_loop.hpp"
#include "core/mechanics/frequency_response.hpp"
#include "core/mechanics/state_space.hpp"
#include "core/numerics/two_pi.hpp"
#include "tests/core/scenes.hpp"

namespace stillframe::test {
namespace {

using Complex = std::complex<double>;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;

struct Corners {
  double leak, high_pass, roll_off;  // rad/s
  double lead = 0;                   // s
};

ForceFeedback feedback(const Corners& corners) {
  ForceFeedback out;
  out.K_P = (MatrixXd(2, 2) << 8, 1.5, -0.5, 12).finished();
  out.K_I = (MatrixXd(2, 2) << 300, 40, -30, 500).finished();
  out.leak = corners.leak;
  out.high_pass = corners.high_pass;
  out.roll_off = corners.roll_off;
  out.lead = corners.lead;
  return out;
}

MatrixXcd response(const LinearSystem& system, Complex s) {
  MatrixXcd resolvent = -system.A.cast<Complex>();
  resolvent.diagonal().array() += s;
  return system.C * resolvent.partialPivLu().solve(system.B.cast<Complex>()) + system.D;
}

class Feedback : public testing::TestWithParam<Corners> {};

TEST_P(Feedback, StrainFormAndStressFormAreOneLaw) {
  const ForceFeedback law = feedback(GetParam());
  const LinearSystem strain = strain_feedback(law);
  const MatrixXcd I = MatrixXcd::Identity(2, 2);
  for (const double hz : {1e-3, 0.05, 1.0, 30.0, 1000.0}) {
    const Complex s(0, two_pi * hz);
    // u = F (sigma - u) gives C = (I + F)^-1 F; I + F is as small as X^-1 and the corners make it,
    // 1e-4 here, which is what is lost of 16 digits.
    const MatrixXcd F = response(strain, s);
    EXPECT_LT(((I + F) * law(s) - F).norm(), 1e-10 * F.norm()) << hz;
    if (law.roll_off == 0) {
      const MatrixXcd C = response(stress_feedback(law), s);
      EXPECT_LT((C - law(s)).norm(), 1e-12 * C.norm()) << hz;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Corners, Feedback,
                         testing::Values(Corners{0, 0, 0}, Corners{0.3, 0, 0}, Corners{0, 0.3, 0},
                                         Corners{0.3, 2, 0}, Corners{0.3, 0, 600},
                                         Corners{0.3, 2, 600}, Corners{0.3, 2, 600, 1e-3}));

TEST(ForceFeedback, AHighPassAloneIsALeak) {
  const Complex s(0, 3);
  EXPECT_LT((feedback({0, 0.3, 0})(s) - feedback({0.3, 0, 0})(s)).norm(), 1e-12);
  EXPECT_EQ(strain_feedback(feedback({0, 0.3, 0})).A, strain_feedback(feedback({0.3, 0, 0})).A);
}

TEST(ForceFeedback, LeakAndHighPassLetGoAtStandstill) {
  // C(0) = 0 with both: the frame keeps its passive stiffness. With a leak alone C(0) = -K_I /
  // omega_l.
  EXPECT_LT(feedback({0.3, 2, 0})(Complex(0, 1e-12)).norm(), 1e-8);
  const MatrixXcd held = feedback({0.3, 0, 0})(Complex(0, 0));
  EXPECT_LT((held + feedback({0.3, 0, 0}).K_I / 0.3).norm(), 1e-9);
}

class FrameLoop : public testing::TestWithParam<Corners> {
 protected:
  FrameLoop() : scene_(frame_scene()), model_(make_model(scene_)) {
    loop_ = make_control_loop(scene_, model_);
    loop_.gains.leak = GetParam().leak;
    loop_.gains.high_pass = GetParam().high_pass;
    loop_.gains.roll_off = GetParam().roll_off;
    loop_.gains.lead = GetParam().lead;
  }
  Scene scene_;
  Model model_;
  ControlLoop loop_;
};

TEST_P(FrameLoop, StateSpaceGivesTheTransferOfTheFormula) {
  const LinearSystem system =
      continuous_loop(loop_plant(loop_.plant, loop_.n_w, loop_.n_y), loop_.gains);
  for (const double hz : {0.5, 5.0, 31.0, 200.0}) {
    const Complex s(0, two_pi * hz);
    const MatrixXcd found = response(system, s), T = loop_.closed(s);
    EXPECT_LT((found.leftCols(6) - T).norm(), 1e-9 * T.norm()) << hz;
    // Sensor noise: y = G_12 C (I - G_22 C)^-1 v.
    const MatrixXcd G = transfer_function(loop_.plant, s), C = loop_.gains(s);
    const MatrixXcd noise = G.topRightCorner(6, 6) * C *
                            (MatrixXcd::Identity(6, 6) - G.bottomRightCorner(6, 6) * C).inverse();
    // C has the size of K_P, some 100, and I - G_22 C cancels as much.
    EXPECT_LT((found.rightCols(6) - noise).norm(), 1e-8 * noise.norm()) << hz;
  }
}

TEST_P(FrameLoop, PolesAreThoseOfTheLegMatrices) {
  const auto found = closed_loop_poles(loop_plant(loop_.plant, loop_.n_w, loop_.n_y), loop_.gains);
  const auto expected = closed_loop_poles(loop_.design.legs, loop_.gains, two_pi * 5);
  ASSERT_EQ(found.size(), expected.size());
  for (const Complex pole : expected) {
    // Repeated poles of a matrix of norm 1e3 rad/s.
    EXPECT_LT((found.array() - pole).abs().minCoeff(), 1e-8 * two_pi * 5) << pole;
  }
  for (const Complex pole : found) {
    EXPECT_LT((expected.array() - pole).abs().minCoeff(), 1e-8 * two_pi * 5) << pole;
  }
}

TEST_P(FrameLoop, ComplianceIsThatOfTheLegsAtStandstill) {
  const LoopPlant plant = compliance_plant(scene_, model_);
  // At the mounts along the legs displacements are elongations: without control 1 / k, crosswise
  // nothing but what is rounded off.
  const double k = 3.95e6;
  const Sampling sampling{.sample_time = 1e-3,
                          .delay_samples = 1,
                          .instruments = {},
                          .leg_gains = {},
                          .leg_delays = {}};
  const SampledPlant sampled = sample_and_hold(plant, sampling);
  const MatrixXcd open = transfer(open_loop(sampled), 1e-9);
  EXPECT_LT((open - MatrixXcd::Identity(6, 6) / k).norm(), 1e-9 / k);
  // A force F is balanced by sigma, and K e = sigma - u = (I - C) sigma with u = C sigma: x = K^-1
  // (I - C) F.
  const Complex s(0, 1e-6);
  const MatrixXcd expected = (MatrixXcd::Identity(6, 6) - loop_.gains(s)) / k;
  const SampledLoop closed =
      close_loop(sampled, sample_law(loop_.gains, {.realisation = Realisation::implicit_feedthrough,
                                                   .sample_time = 1e-3,
                                                   .lead_samples = 1.5,
                                                   .sensor_filter_hz = 0}));
  EXPECT_LT((transfer(closed, s.imag()) - expected).norm(), 1e-6 * expected.norm());
}

INSTANTIATE_TEST_SUITE_P(Corners, FrameLoop,
                         testing::Values(Corners{0.3, 0, 0}, Corners{0.3, 2, 0},
                                         Corners{0.3, 2, 1200}, Corners{0.3, 2, 1200, 4e-4}));

TEST(DecouplingOf, IsWhatTheMatrixShows) {
  MatrixXcd T = MatrixXcd::Identity(3, 3) * Complex(0, 0.1);
  EXPECT_NEAR(decoupling(T).spread_db, 0, 1e-12);
  EXPECT_EQ(decoupling(T).crosstalk_db, -std::numeric_limits<double>::infinity());
  T(2, 0) = 0.01;  // a tenth of its own
  EXPECT_NEAR(decoupling(T).crosstalk_db, -20, 1e-12);
  T(1, 1) *= 10;
  EXPECT_GT(decoupling(T).spread_db, 20);
  EXPECT_THROW(decoupling(MatrixXcd::Zero(2, 3)), std::invalid_argument);
}

}  // namespace
}  // namespace stillframe::test

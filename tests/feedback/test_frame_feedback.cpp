#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <random>

#include "core/control/close_loop.hpp"
#include "core/control/design/frame_feedback.hpp"
#include "core/control/disk_margin.hpp"
#include "core/errors/input_error.hpp"
#include "core/numerics/singular_values.hpp"
#include "core/numerics/two_pi.hpp"

namespace stillframe {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// Legs on a frame of masses from 20 to 200 kg that has modes from 15 to 75 Hz, coupled at random.
DesignModel random_model(std::mt19937& engine, Index r) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  MatrixXd V = MatrixXd::NullaryExpr(r, r, [&] { return uniform(engine); });
  V += 2 * MatrixXd::Identity(r, r);
  Eigen::VectorXd squares(r);
  for (double& square : squares) {
    square = std::pow(two_pi * 15 * std::pow(5, (1 + uniform(engine)) / 2), 2);
  }
  const MatrixXd M = 100 * V * V.transpose();  // V = L Q
  const MatrixXd K = 100 * V * squares.asDiagonal() * V.transpose();
  return {.legs = {.M = (M + M.transpose()) / 2, .K = (K + K.transpose()) / 2},
          .Q = MatrixXd::Identity(r, r)};
}

/// M e'' + K e = -u - M w, sigma = K e + u, outputs e'' + w: the frame above a floor that moves
/// each leg's foot by itself.
LoopPlant plant_of(const DesignModel& model) {
  const Index r = model.legs.M.rows();
  const MatrixXd I = MatrixXd::Identity(r, r), O = MatrixXd::Zero(r, r);
  const MatrixXd M_inverse = model.legs.M.inverse(), squares = M_inverse * model.legs.K;
  LoopPlant plant;
  plant.A = MatrixXd(2 * r, 2 * r);
  plant.A << O, I, -squares, O;
  plant.B_w = MatrixXd(2 * r, r);
  plant.B_w << O, -I;
  plant.B_u = MatrixXd(2 * r, r);
  plant.B_u << O, -M_inverse;
  plant.C_y = MatrixXd(r, 2 * r);
  plant.C_y << -squares, O;
  plant.D_yw = O;
  plant.D_yu = -M_inverse;
  plant.C_sigma = MatrixXd(r, 2 * r);
  plant.C_sigma << model.legs.K, O;
  return plant;
}

Sampling sampling_of(double rate_hz, double delay) {
  Sampling sampling;
  sampling.sample_time = 1 / rate_hz;
  sampling.delay_samples = delay;
  return sampling;
}

/// In the coordinates of the modes T of the frame is that of the modes, whatever the shapes are:
/// T_frame = Phi diag(T_i) Phi^-1.
TEST(FrameFeedback, IsThatOfItsModesOnRandomFrames) {
  std::mt19937 engine(1);
  int n_found = 0;
  for (int i = 0; i < 6; ++i) {
    const DesignModel model = random_model(engine, 2 + i % 3);
    const Index r = model.legs.M.rows();
    const Sampling sampling = sampling_of(1000, i % 2 ? 1 : 1.3);
    const std::vector<ModeTarget> targets{{two_pi * 4, 0.7}};
    const ModeGoal goal{.to_hz = 40, .disk = 0.4};
    const auto method = i % 4 < 2 ? FeedbackMethod::h2 : FeedbackMethod::minimax;
    const FrameFeedback found = frame_feedback(model, targets, sampling, 0, goal, method);
    if (!found.law) continue;  // H2 finds none of that margin for one mode in some
    ++n_found;
    const DiscreteLaw law{.A = found.law->A,
                          .B = found.law->B,
                          .C = found.law->C,
                          .D = found.law->D,
                          .subtract_applied = true,
                          .applied_memory = 0};
    const LoopPlant plant = plant_of(model);
    const SampledLoop loop = close_loop(sample_and_hold(plant, sampling), law);
    ASSERT_LT(spectral_radius(loop), largest_stable_radius) << i;
    const auto modes = virtual_modes(model.legs, targets);
    const MatrixXd Phi = modes.Phi.cast<double>();
    double widest = 2;
    for (const double hz : {0.7, 4.0, 11.0, 40.0, 123.0, 431.0}) {
      const Eigen::MatrixXcd T = Phi.inverse() * transfer(loop, two_pi * hz) * Phi;
      for (Index k = 0; k < r; ++k) {
        const SampledMode mode(two_pi * found.hz(k), sampling, 0);
        const LinearSystem& F = found.modes[static_cast<std::size_t>(k)]->F;
        const auto T_k = transfer(close_loop(mode.sampled(), mode.law_of(F)), two_pi * hz)(0, 0);
        // Rounding of shapes and of the exponentials, times the resonance that control takes away.
        EXPECT_LT(std::abs(T(k, k) - T_k), 1e-7 * (1 + std::abs(T_k))) << i << ", " << hz;
        for (Index l = 0; l < r; ++l) {
          if (l != k) EXPECT_LT(std::abs(T(k, l)), 1e-7) << i << ", " << hz;
        }
      }
    }
    for (const auto& mode : found.modes) widest = std::min(widest, mode->disk);
    EXPECT_GE(widest, goal.disk) << i;
  }
  EXPECT_GE(n_found, 4);
}

TEST(FrameFeedback, ModesOfOneFrequencyShareALaw) {
  DesignModel model{.legs = {.M = 50 * MatrixXd::Identity(2, 2),
                             .K = 50 * std::pow(two_pi * 40, 2) * MatrixXd::Identity(2, 2)},
                    .Q = MatrixXd::Identity(2, 2)};
  const auto found = frame_feedback(model, {{two_pi * 5, 0.7}}, sampling_of(1000, 1), 0,
                                    {.to_hz = 50}, FeedbackMethod::h2);
  ASSERT_TRUE(found.law);
  EXPECT_EQ(found.modes[0]->F.A, found.modes[1]->F.A);
  // Of two targets the shapes would not be known.
  EXPECT_THROW(frame_feedback(model, {{two_pi * 5, 0.7}, {two_pi * 4, 0.7}}, sampling_of(1000, 1),
                              0, {.to_hz = 50}, FeedbackMethod::h2),
               Refusal);
}

TEST(FrameFeedback, HasNoLawWhereAModeHasNone) {
  std::mt19937 engine(2);
  const DesignModel model = random_model(engine, 2);
  const auto found = frame_feedback(model, {{two_pi * 5, 0.7}}, sampling_of(1000, 1), 0,
                                    {.to_hz = 50, .disk = 1.9}, FeedbackMethod::h2);
  EXPECT_FALSE(found.law);
  EXPECT_EQ(found.modes.size(), 2u);
}

}  // namespace
}  // namespace stillframe

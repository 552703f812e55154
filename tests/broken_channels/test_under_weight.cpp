#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "core/mechanics/state_space.hpp"
#include "core/numerics/worst.hpp"
#include "judge/loop_design.hpp"
#include "tests/broken_channels/episodes.hpp"
#include "tests/controller/made_up_floor.hpp"
#include "tests/controller/rig.hpp"

// A frame whose weight leans when its supports move apart: what the floor does to its legs is not
// its acceleration alone.
namespace stillframe::controller {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

const judge::LoopDesign& design() {
  static const judge::LoopDesign value = judge::make_loop_design(
      std::filesystem::path(STILLFRAME_SOURCE_DIR) / "config/scenes/frame_under_gravity.yaml", {});
  return value;
}

/// What the legs read (m x n, N) after one sample of acceleration of channel j, left alone.
MatrixXd kicked(const LoopPlant& plant, Index j, Index n) {
  const SampledPlant sampled = sample_and_hold(plant, design().gains.sampling());
  MatrixXd sigma(plant.C_sigma.rows(), n);
  VectorXd x = sampled.Gamma_w.col(j);
  for (Index k = 0; k < n; ++k) {
    sigma.col(k) = sampled.C_sigma * x;
    x = (sampled.Phi * x).eval();
  }
  return sigma;
}

// The gains file has the state of another frame of reference, and the same frame.
TEST(UnderWeight, TheLegsReadWhatTheyDoInTheDesign) {
  const judge::LoopDesign& d = design();
  const LoopPlant whole = loop_plant(d.loop.plant, d.loop.n_w, d.loop.n_y);
  const LoopPlant known = d.gains.loop_plant();
  ASSERT_GT(whole.n_exogenous, 0);
  for (Index j = 0; j < d.loop.n_w; ++j) {
    const MatrixXd expected = kicked(whole, j, 5000), found = kicked(known, j, 5000);
    // Rounding of two exponentials of stiff plants.
    EXPECT_LT((found - expected).norm(), 1e-9 * expected.norm()) << j;
  }
}

/// A floor that begins at rest, as that of every run, and has grown a hundredfold within seconds.
Rig::Floor fading_in(double rate_hz, std::uint64_t seed) {
  return [rate_hz, floor = MadeUpFloor(rate_hz, seed)](std::int64_t k, VectorXd& w) mutable {
    floor(usual_floor * smooth_step(std::min(1.0, static_cast<double>(k) / (4 * rate_hz))), w);
  };
}

TEST(UnderWeight, AFloorThatFadesInIsNoFault) {
  const Gains gains = shipped_gains("force_feedback_8hz", "frame_under_gravity");
  Gains blind = gains;
  blind.plant.B_w.resize(gains.plant.A.rows(), 0);
  blind.plant.A_w.resize(0, 0);
  blind.plant.C_w.resize(0, 0);
  const auto n = static_cast<int>(8 * gains.sample_rate_hz);
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Rig rig({}, true, gains), unknown({}, true, blind, gains);
    for (Rig* each : {&rig, &unknown}) {
      each->floor = fading_in(gains.sample_rate_hz, seed);
      each->steps(n);
    }
    EXPECT_EQ(rig.state(), State::active) << seed << " " << to_text(rig.fault());
    EXPECT_EQ(rig.supervisor().n_faults(), 0) << seed;
    EXPECT_EQ(rig.supervisor().n_saturated(), 0) << seed;
    // As it was where only the floor's acceleration was known.
    EXPECT_EQ(unknown.fault(), Fault::restless) << seed;
  }
}

TEST(UnderWeight, WhatBreaksDrivesTheFrameNoHarderThanIsPromised) {
  const Gains gains = shipped_gains("force_feedback_8hz", "frame_under_gravity");
  for (const Broken& broken :
       {Broken{Part::sensor, Damage::reversed}, Broken{Part::sensor, Damage::swapped},
        Broken{Part::sensor, Damage::open}, Broken{Part::sensor, Damage::shorted},
        Broken{Part::sensor, Damage::stuck}, Broken{Part::read_back, Damage::reversed},
        Broken{Part::read_back, Damage::open}, Broken{Part::actuator, Damage::reversed}}) {
    const Episode episode = run_episode(gains, {}, {broken}, 1);
    EXPECT_LT(worst_of(episode.peak, episode.acceleration), 1.1) << broken.name();
  }
}

// Their growth stays within the pace: 1.22 before what acts was compared with what was commanded.
TEST(UnderWeight, AnActuatorThatDoesATenthMoreIsNamed) {
  const Gains gains = shipped_gains("force_feedback_8hz", "frame_under_gravity");
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Episode episode = run_episode(gains, {}, {{Part::actuator, Damage::scaled, 1.1}}, seed);
    EXPECT_EQ(episode.fault, Fault::disobeyed) << seed;
    EXPECT_TRUE(episode.named) << seed;
    EXPECT_LT(worst_of(episode.peak, episode.acceleration), 1.1) << seed;
  }
}

}  // namespace
}  // namespace stillframe::controller

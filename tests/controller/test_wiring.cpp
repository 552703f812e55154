#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <stdexcept>

#include "controller/rig/rig_file.hpp"
#include "controller/rig/simulated_plant.hpp"
#include "controller/rig/wiring.hpp"
#include "tests/controller/toy_plant.hpp"
#include "tests/support/hidden_rig.hpp"
#include "tests/support/scratch_folder.hpp"

namespace stillframe::controller {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// A rig of four legs on a floor of 0.003 m/s^2.
class FourLegs : public HiddenRig {
 public:
  FourLegs(const Gains& gains, const Hidden& hidden, unsigned seed)
      : HiddenRig(SimulatedPlant(gains, 0.003), hidden, seed) {}
};

Hidden four(double ppm, double noise) {
  Hidden hidden(4);
  hidden.ppm = ppm;
  hidden.noise = noise;
  return hidden;
}

Gains designed() {
  Gains gains = toy::damped_gains();
  gains.force_limit_n = 200;
  return gains;
}

Wiring probed(HiddenRig& rig, const Gains& gains, const Channels& channels, double force_n = 4) {
  ScaledIo scaled(rig, channels);
  const ProbeSettings settings = probe_settings(gains, channels, force_n);
  return wiring_of(probe_rig(scaled, 4, settings, rig.time(), {}, {}), settings, gains, channels);
}

bool says(const Wiring& wiring, std::size_t leg, const std::string& text) {
  return std::ranges::any_of(wiring.legs[leg].wrong, [&](const std::string& what) {
    return what.find(text) != std::string::npos;
  });
}

/// The plant that the rig really has: stiffness and mass up to a fifth from the model's.
Gains off_by_a_fifth(Gains gains, std::mt19937_64& random) {
  std::uniform_real_distribution<double> part(0.8, 1.2);
  const auto m = gains.n_legs();
  const double stiffness = part(random), mass = part(random);
  gains.plant.A.bottomLeftCorner(m, m) *= stiffness * mass;
  gains.plant.B *= mass;
  gains.plant.C.leftCols(m) *= stiffness;
  return gains;
}

TEST(Wiring, ASoundRigIsSound) {
  const Gains gains = designed();
  FourLegs rig(gains, four(50, 0.01), 1);
  const Wiring wiring = probed(rig, gains, default_rig(gains).channels);
  for (const LegFinding& leg : wiring.legs) {
    EXPECT_TRUE(leg.wrong.empty())
        << leg.leg << ": " << (leg.wrong.empty() ? "" : leg.wrong.front());
    EXPECT_NEAR(leg.sigma_mean, 3, 0.05);
    EXPECT_NEAR(leg.delay_samples, 0, 0.02);
  }
  EXPECT_TRUE(wiring.sound);
  EXPECT_FALSE(rig.enabled);
  EXPECT_EQ(rig.acts().norm(), 0);
  EXPECT_LT(rig.peak, 3 * 4);
}

/// A force far below the noise tells nothing, and that is what is said: no cable, no delay.
TEST(Wiring, NoiseHidesASmallForce) {
  const Gains gains = designed();
  for (const double force_n : {1e-6, 1e-4, 1e-3}) {
    FourLegs rig(gains, four(50, 0.05), 1);
    const Wiring wiring = probed(rig, gains, default_rig(gains).channels, force_n);
    EXPECT_FALSE(wiring.sound || wiring.connected || wiring.mended);
    for (std::size_t leg = 0; leg < 4; ++leg) {
      // Which leg is another question, of which as little is known.
      if (wiring.legs[leg].wrong.empty() || says(wiring, leg, "no amplifier")) continue;
      EXPECT_TRUE(says(wiring, leg, "noise hides")) << force_n;
      EXPECT_EQ(wiring.legs[leg].wrong.size(), 1) << force_n;
    }
  }
}

/// Of random rigs with a model that is off by a fifth, a crystal, noise and 16 bits: one cable pair
/// swapped, one sign, one gain, all of it named; and a second probe with the mended rig file finds
/// nothing wrong, with gains right to 1 %.
TEST(Wiring, WhatIsWrongIsNamedAndMended) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> drift(-100, 100), off(0.04, 0.3);
  for (int trial = 0; trial < 50; ++trial) {
    SCOPED_TRACE(trial);
    const Gains gains = designed();
    Hidden hidden = four(drift(random), 0.02);
    hidden.step = 0.01;
    hidden.lost = 1e-4;
    std::vector<std::size_t> legs{0, 1, 2, 3};
    std::ranges::shuffle(legs, random);
    // Which is swapped, which turned, and which has another gain.
    const auto swapped = random() % 3, turned = random() % 3, scaled = random() % 3;
    std::vector<Index>* cables[] = {&hidden.sigma, &hidden.applied, &hidden.force};
    VectorXd* gain[] = {&hidden.gain_sigma, &hidden.gain_applied, &hidden.gain_force};
    std::swap((*cables[swapped])[legs[0]], (*cables[swapped])[legs[1]]);
    (*gain[turned])(static_cast<Index>(legs[2])) = -1;
    const double size = 1 + (random() % 2 ? 1 : -1) * off(random);
    (*gain[scaled])(static_cast<Index>(legs[3])) = size;
    const char* names[] = {"force sensor", "read-back", "amplifier"};

    const Gains real = off_by_a_fifth(gains, random);
    FourLegs rig(real, hidden, static_cast<unsigned>(trial));
    const Wiring found = probed(rig, gains, default_rig(gains).channels);
    EXPECT_FALSE(found.sound);
    ASSERT_TRUE(found.mended);
    for (const std::size_t leg : {legs[0], legs[1]}) {
      EXPECT_TRUE(says(found, leg, std::string(names[swapped]) + ": on the cable of"));
      EXPECT_EQ(found.legs[leg].wrong.size(), 1u);
    }
    EXPECT_TRUE(says(found, legs[2], std::string(names[turned]) + ": wired the other way round"));
    EXPECT_EQ(found.legs[legs[2]].wrong.size(), 1u);
    EXPECT_TRUE(says(found, legs[3], std::string(names[scaled]) + ": reads"));
    EXPECT_EQ(found.legs[legs[3]].wrong.size(), 1u);
    const double read[] = {found.legs[legs[3]].sigma.gain, found.legs[legs[3]].applied.gain,
                           found.legs[legs[3]].force.gain};
    EXPECT_NEAR(read[scaled] / size, 1, 0.01);
    EXPECT_LT(rig.peak, 3 * 4 * 1.3);

    FourLegs again(real, hidden, 1000u + static_cast<unsigned>(trial));
    EXPECT_TRUE(probed(again, gains, found.channels).sound);
  }
}

TEST(Wiring, ADeadCableIsNamed) {
  const Gains gains = designed();
  Hidden hidden = four(0, 0.02);
  hidden.gain_sigma(1) = 0;
  hidden.gain_applied(2) = 0;
  hidden.gain_force(3) = 0;
  FourLegs rig(gains, hidden, 1);
  const Wiring wiring = probed(rig, gains, default_rig(gains).channels);
  EXPECT_FALSE(wiring.mended);
  EXPECT_TRUE(wiring.legs[0].wrong.empty());
  EXPECT_TRUE(says(wiring, 1, "force sensor: does not answer"));
  EXPECT_TRUE(says(wiring, 2, "read-back: does not answer"));
  EXPECT_TRUE(says(wiring, 3, "neither force sensor nor read-back answers"));
}

TEST(Wiring, ADelayOfASampleIsSeen) {
  const Gains gains = designed();
  Gains slow = gains;
  slow.delay_samples = 2;
  FourLegs rig(slow, four(0, 0.01), 1);
  const Wiring wiring = probed(rig, gains, default_rig(gains).channels);
  for (const LegFinding& leg : wiring.legs) EXPECT_NEAR(leg.delay_samples, 1, 0.02) << leg.leg;
  EXPECT_FALSE(wiring.sound);
  EXPECT_FALSE(wiring.mended);
}

TEST(Wiring, LetsGoOfARigThatIsDrivenTooFar) {
  const Gains gains = designed();
  Hidden hidden(4);
  hidden.gain_force(2) = 30;
  FourLegs rig(gains, hidden, 1);
  const Channels channels = default_rig(gains).channels;
  EXPECT_THROW(probed(rig, gains, channels), std::runtime_error);
  EXPECT_EQ(rig.acts().norm(), 0);
  EXPECT_FALSE(rig.enabled);
  Hidden lossy(4);
  lossy.lost = 0.2;
  FourLegs gaps(gains, lossy, 1);
  EXPECT_THROW(probed(gaps, gains, channels), std::runtime_error);
  EXPECT_EQ(gaps.acts().norm(), 0);
}

TEST(Wiring, AMendedRigFileReadsBack) {
  const Gains gains = designed();
  RigFile rig = default_rig(gains);
  rig.title = "a \"rig\"";
  rig.driver = "device";
  rig.options = {{"from", "a b"}, {"to", "c"}};
  rig.frame = {"top"};
  rig.channels.frame = {{.number = 5, .gain = -0.25, .tare = 1e-3}};
  std::swap(rig.channels.sigma[0].number, rig.channels.sigma[3].number);
  const test::ScratchFolder folder;
  const RigFile back = read_rig(folder.write("rig.yaml", to_yaml(rig, gains)), gains);
  EXPECT_EQ(back.title, rig.title);
  EXPECT_EQ(back.driver, rig.driver);
  EXPECT_EQ(back.options, rig.options);
  EXPECT_EQ(back.frame, rig.frame);
  EXPECT_EQ(to_yaml(back, gains), to_yaml(rig, gains));
}

}  // namespace
}  // namespace stillframe::controller

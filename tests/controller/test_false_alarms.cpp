#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "core/numerics/worst.hpp"
#include "tests/broken_channels/episodes.hpp"
#include "tests/controller/made_up_floor.hpp"
#include "tests/controller/rig.hpp"

// Hours of floors as they are, with sensors and frames as they are: a fault is a false alarm, and a
// command that hurries or a measurement that is not answered is one that was not needed.
namespace stillframe::controller {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// A floor that was recorded at 200 Hz, in m/s^2: one direction after the other, for ever.
class RecordedFloor {
 public:
  RecordedFloor(const std::string& name, double rate_hz) : ratio_(recorded_hz / rate_hz) {
    const auto file =
        std::filesystem::path(STILLFRAME_SOURCE_DIR) / "config/floors" / (name + ".csv");
    std::ifstream in(file);
    std::vector<std::vector<double>> axes(3);
    for (std::string line; std::getline(in, line);) {
      std::istringstream cells(line);
      double value = 0;
      char comma = 0;
      for (auto& axis : axes) {
        if (!(cells >> value)) break;
        axis.push_back(value);
        cells >> comma;
      }
    }
    for (const auto& axis : axes) values_.insert(values_.end(), axis.begin(), axis.end());
  }
  bool is_read() const { return values_.size() > 200'000; }
  void operator()(std::int64_t k, VectorXd& w) const {
    const double at =
        std::fmod(static_cast<double>(k) * ratio_, static_cast<double>(values_.size()) - 1);
    const auto i = static_cast<std::size_t>(at);
    const double part = at - static_cast<double>(i);
    w.setConstant((1 - part) * values_[i] + part * values_[i + 1]);
  }

 private:
  static constexpr double recorded_hz = 200;
  double ratio_;
  std::vector<double> values_;
};

struct Sound {
  const char* name;
  double noise = 1e-3, step = 0, calibration = 0.02, loud = 1, quiet = 1, rate_hz = 1000;
  const char* recording = nullptr;
  double stiffness = 0;      ///< by so much the frame's legs are softer or stiffer than the model's
  double lost = 0;           ///< part of the measurements
  bool floor_late = false;   ///< by a sample
  int burst = 0;             ///< measurements lost in a row once a second
  double tilt = 0;           ///< m/s^2, what the sensors of the floor read at rest
  double kick = 0;           ///< N, by which the frame swings when the loop takes hold
  bool by_position = false;  ///< the floor acts by its position, as under weight
  double actuators = 0;      ///< by this part they do less than is commanded, and say so
  /// By this part they do more or less, and their read-backs say that they do what is commanded.
  double unsaid = 0;
  /// Of the metrology frame as it is shipped, with these gains.
  const char* shipped = nullptr;
  double floor_noise = 0;        ///< m/s^2/sqrt(Hz), of each of its sensors
  double floor_calibration = 0;  ///< part by which they read more or less
};

/// Whose legs are each a part stiffer or softer; all softer where they share the masses, which rows
/// of another size would not be those of a frame.
Gains frame_of(Gains gains, double stiffness, bool share_masses, std::mt19937_64& random) {
  const Index m = gains.n_legs();
  for (Index i = 0; i < m; ++i) {
    const bool stiffer = random() % 2 == 0 && !share_masses;
    const double factor = stiffer ? 1 + stiffness : 1 - stiffness;
    gains.plant.A.row(m + i).head(m) *= factor;
    gains.plant.C.row(i) *= factor;
  }
  return gains;
}

class NoFalseAlarm : public testing::TestWithParam<Sound> {};

TEST_P(NoFalseAlarm, ForAsLongAsOneLikes) {
  const Sound& sound = GetParam();
  // scripts/false_alarms asks for a day in all.
  const char* asked = std::getenv("STILLFRAME_SIMULATED_HOURS");
  const double hours = asked != nullptr ? std::stod(asked) : 0.02;
  Gains gains =
      sound.shipped != nullptr ? shipped_gains(sound.shipped) : toy::damped_gains(5, sound.rate_hz);
  if (sound.by_position) gains = toy::by_position(gains);
  const Index m = gains.n_legs();
  const auto n = static_cast<std::int64_t>(hours * 3600 * sound.rate_hz);
  std::mt19937_64 random(17);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  VectorXd scale = VectorXd::Ones(m);
  for (double& value : scale) value += random() % 2 == 0 ? sound.calibration : -sound.calibration;
  VectorXd floor_scale = VectorXd::Ones(gains.plant.B_w.cols());
  for (double& value : floor_scale) {
    value += random() % 2 == 0 ? sound.floor_calibration : -sound.floor_calibration;
  }
  Rig rig({}, true, gains, frame_of(gains, sound.stiffness, sound.shipped != nullptr, random));
  MadeUpFloor made_up(sound.rate_hz, 18);
  const RecordedFloor recorded(sound.recording != nullptr ? sound.recording : "mikb_floor_200hz",
                               sound.rate_hz);
  ASSERT_TRUE(recorded.is_read());
  const auto kicked = std::llround(0.3 * sound.rate_hz);
  rig.floor = [&](std::int64_t k, VectorXd& w) {
    if (sound.recording != nullptr) {
      recorded(k, w);
    } else {
      // Three loud seconds in every twenty.
      const auto phase = k % std::llround(20 * sound.rate_hz);
      const double size =
          static_cast<double>(phase) > 17 * sound.rate_hz ? sound.loud : sound.quiet;
      made_up(size, w);
    }
    if (k == kicked) w.array() += sound.kick * sound.rate_hz;
  };
  // More than is commanded, and said so, is what makes this loop unstable: the stiffest mode has a
  // hundred times the stiffness that is left of it, so that 2 % of it are more than all of that.
  VectorXd acts = VectorXd::Constant(m, 1 - sound.actuators), says = VectorXd::Ones(m);
  for (Index i = 0; i < m && sound.unsaid > 0; ++i) {
    acts(i) = random() % 2 == 0 ? 1 + sound.unsaid : 1 - sound.unsaid;
    says(i) = 1 / acts(i);
  }
  rig.actuators = [&](VectorXd& force) { force.array() *= acts.array(); };
  std::int64_t n_lost = 0;
  const auto first_burst = std::llround(4 * sound.rate_hz);
  VectorXd floor_before = VectorXd::Zero(gains.plant.B_w.cols());
  const auto wire = [&](Measurement& m) {
    m.applied.array() *= says.array();
    for (Index i = 0; i < m.sigma.size(); ++i) {
      m.sigma(i) = scale(i) * m.sigma(i) + sound.noise * normal(random);
      if (sound.step > 0) m.sigma(i) = sound.step * std::round(m.sigma(i) / sound.step);
    }
    if (sound.floor_late) m.floor.swap(floor_before);
    for (Index j = 0; j < m.floor.size(); ++j) {
      const double noise = sound.floor_noise * std::sqrt(sound.rate_hz / 2) * normal(random);
      m.floor(j) = floor_scale(j) * m.floor(j) + sound.tilt + noise;
    }
    const bool in_burst =
        m.seq % std::llround(sound.rate_hz) < sound.burst && rig.k() > first_burst;
    const bool lost = in_burst || (sound.lost > 0 && uniform(random) < sound.lost);
    n_lost += lost ? 1 : 0;
    return !lost;
  };
  ASSERT_TRUE(rig.reaches(State::active, static_cast<int>(4 * sound.rate_hz), wire))
      << to_text(rig.fault());
  std::int64_t n_disbelieved = 0;
  for (std::int64_t k = 0; k < n; ++k) {
    rig.step(wire);
    n_disbelieved += rig.supervisor().broken_floor() >= 0 ? 1 : 0;
  }
  // Within a burst that is longer than forces are held they fade.
  if (sound.burst <= 10) {
    EXPECT_EQ(rig.state(), State::active);
  }
  EXPECT_EQ(rig.supervisor().n_faults(), 0) << to_text(rig.fault());
  EXPECT_EQ(n_disbelieved, 0);
  // After a burst a command may catch up less than it would.
  EXPECT_LE(rig.supervisor().n_saturated(), sound.burst > 0 ? n / 1000 : 0);
  EXPECT_EQ(rig.loop().counters().n_missing, n_lost);
}

/// Newtons for tenths of a micrometre: the legs of the shipped frame meet their limit on a floor
/// that is loud. The sensors of the floor have noise.
Sound on_shipped(const char* gains, Sound sound, double quiet = 5e-3, double loud = 0.02) {
  sound.shipped = gains;
  sound.quiet = quiet;
  sound.loud = loud;
  sound.floor_noise = 1e-6;
  return sound;
}

INSTANTIATE_TEST_SUITE_P(
    Sounds, NoFalseAlarm,
    testing::Values(
        Sound{.name = "AsItIs"}, Sound{.name = "NoNoise", .noise = 0},
        Sound{.name = "LoudNoise", .noise = 0.02}, Sound{.name = "SixteenBits", .step = 0.015},
        Sound{.name = "TwelveBits", .step = 0.24},
        Sound{.name = "Earthquakes", .step = 0.015, .quiet = 0.1},
        Sound{.name = "Quiet", .loud = 0.01, .quiet = 0.01},
        Sound{.name = "FiveKilohertz", .step = 0.015, .rate_hz = 5000},
        Sound{.name = "RecordedFloor", .recording = "mikb_floor_200hz"},
        Sound{.name = "RecordedQuake", .step = 0.0015, .recording = "mikb_quake_200hz"},
        Sound{.name = "QuakeAtFiveKilohertz", .rate_hz = 5000, .recording = "mikb_quake_200hz"},
        Sound{.name = "LegsOff", .calibration = 0.05, .stiffness = 0.15},
        Sound{.name = "QuakeLegsOff", .recording = "mikb_quake_200hz", .stiffness = 0.15},
        Sound{.name = "OnePercentLost", .lost = 0.01},
        Sound{.name = "QuakeTenPercentLost", .recording = "mikb_quake_200hz", .lost = 0.1},
        Sound{.name = "FloorLate", .floor_late = true}, Sound{.name = "TiltedFloor", .tilt = 0.05},
        Sound{.name = "BurstsOf10", .burst = 10}, Sound{.name = "BurstsOf21", .burst = 21},
        Sound{.name = "QuakeBurstsOf10", .recording = "mikb_quake_200hz", .burst = 10},
        Sound{.name = "FloorByPosition", .by_position = true},
        Sound{.name = "FloorByPositionEarthquakes", .quiet = 0.1, .by_position = true},
        Sound{.name = "ActuatorsShort", .actuators = 0.02},
        Sound{.name = "ActuatorsOffUnsaid", .unsaid = 0.02},
        on_shipped("force_feedback_5hz", {.name = "Shipped"}),
        on_shipped("force_feedback_5hz", {.name = "ShippedActuatorsShort", .actuators = 0.02}),
        on_shipped("force_feedback_5hz",
                   {.name = "ShippedActuatorsTenPercentShort", .actuators = 0.1}),
        on_shipped("force_feedback_5hz", {.name = "ShippedActuatorsShortOnePercentLost",
                                          .lost = 0.01,
                                          .actuators = 0.02}),
        on_shipped("force_feedback_5hz", {.name = "ShippedActuatorsOffUnsaid", .unsaid = 0.02}),
        on_shipped("feed_forward_1khz", {.name = "FeedForward"}),
        on_shipped("feed_forward_1khz", {.name = "FeedForwardEarthquakes", .step = 0.015}, 2e-4),
        on_shipped("feed_forward_1khz", {.name = "FeedForwardQuiet"}, 1e-5, 1e-5),
        on_shipped("feed_forward_1khz",
                   {.name = "FeedForwardRecordedFloor", .recording = "mikb_floor_200hz"}),
        on_shipped("feed_forward_1khz", {.name = "FeedForwardLegsOff",
                                         .stiffness = 0.05,
                                         .tilt = 0.05,
                                         .floor_calibration = 0.05}),
        on_shipped("feed_forward_1khz", {.name = "FeedForwardActuatorsOffUnsaid", .unsaid = 0.02}),
        on_shipped("feed_forward_1khz",
                   {.name = "FeedForwardTenPercentLost", .lost = 0.1, .floor_late = true}),
        on_shipped("feed_forward_1khz", {.name = "FeedForwardBurstsOf21", .burst = 21}),
        Sound{.name = "Kicked", .loud = 0.03, .quiet = 0.01, .kick = 0.02}),
    [](const auto& sound) { return sound.param.name; });

}  // namespace
}  // namespace stillframe::controller

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <random>

#include "controller/rig/device_frames.hpp"
#include "controller/rig/rig_file.hpp"
#include "core/errors/input_error.hpp"
#include "tests/controller/toy_plant.hpp"
#include "tests/support/scratch_folder.hpp"

namespace stillframe::controller {
namespace {

std::string rig_error(const std::string& text) {
  const test::ScratchFolder folder;
  try {
    read_rig(folder.write("rig.yaml", text), toy::damped_gains());
  } catch (const InputError& error) {
    const std::string said = error.what();
    return said.substr(said.find("rig.yaml") + 8);
  }
  return "none";
}

TEST(RigFile, WithoutOneChannelsAreThoseOfTheGains) {
  const Gains gains = toy::damped_gains();
  const RigFile rig = default_rig(gains);
  ASSERT_EQ(rig.channels.sigma.size(), gains.legs.size());
  EXPECT_EQ(rig.channels.force.back().number, gains.n_legs() - 1);
  EXPECT_EQ(rig.channels.force.back().gain, 1);
  EXPECT_EQ(rig.setting(gains).n_frame, 0);
}

TEST(RigFile, SaysWhatIsWrong) {
  const std::vector<std::string> legs = toy::damped_gains().legs;
  ASSERT_EQ(legs.size(), 4u);
  const auto block = [&](const std::string& first) {
    std::string text = "sigma:\n  " + legs[0] + ": " + first + "\n";
    for (std::size_t i = 1; i < 4; ++i) text += "  " + legs[i] + ": {gain: -2}\n";
    return text;
  };
  EXPECT_EQ(rig_error(block("{gain: 0.5, tare: 3}")), "none");
  EXPECT_EQ(rig_error(block("{gain: 0}")),
            ":2:17: sigma." + legs[0] + ".gain: found 0, allowed is any other number");
  EXPECT_NE(rig_error(block("{channel: 2}")).find("is that of " + legs[0] + " too"),
            std::string::npos);
  EXPECT_NE(rig_error(block("{channel: 4}")).find("there are 4, from 0"), std::string::npos);
  EXPECT_NE(rig_error(block("{sign: -1}")).find("sign"), std::string::npos);
  EXPECT_NE(rig_error("sigma: {" + legs[0] + ": {}}\n").find(legs[1]), std::string::npos);
  EXPECT_EQ(rig_error("sigma: {nobody: {}}\n"),
            ":1:17: sigma.nobody: is no leg of the gains; allowed are " + legs[0] + ", " + legs[1] +
                ", " + legs[2] + ", " + legs[3]);
  EXPECT_EQ(rig_error("driver: simulation\n"),
            ":1:9: driver: found no map, allowed is one, as in {name: device, from: samples, to: "
            "commands}");
  EXPECT_EQ(rig_error("driver: {name: device, form: a, to: b}\n"),
            ":1:24: driver.form: unknown key (did you mean 'from'?); allowed: name, from, to");
  EXPECT_NE(rig_error("scene: nowhere.yaml\n").find("nowhere.yaml"), std::string::npos);
}

TEST(RigFile, SaysWhereADriverIsMissing) {
  const test::ScratchFolder folder;
  const auto error_of = [&](const std::string& text) {
    RigFile rig = read_rig(folder.write("rig.yaml", text), toy::damped_gains());
    EXPECT_THROW(choose_driver(rig, ""), InputError);
    try {
      choose_driver(rig, "");
    } catch (const InputError& error) {
      const std::string said = error.what();
      return said.substr(said.find("rig.yaml"));
    }
    return std::string();
  };
  EXPECT_TRUE(error_of("title: a\n").starts_with("rig.yaml: no driver: name one"));
  EXPECT_TRUE(error_of("driver: {from: a}\n").starts_with("rig.yaml:1:9: driver: no driver:"));
}

/// What goes out through a rig file and comes back through another one with the inverse of it is
/// what it was, on random cables, gains and signs.
TEST(RigFile, ScalesAndCablesBothWays) {
  struct Echo : Io {
    explicit Echo(Eigen::Index m) : m_(measurement_of(m, 0)) {}
    bool receive(Measurement& m) noexcept override {
      m.sigma = m.applied = m_.sigma;
      m.seq = 7;
      return true;
    }
    void send(const Command& command) noexcept override { m_.sigma = command.force; }
    Measurement m_;
  };
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 50; ++trial) {
    Channels channels;
    std::vector<Eigen::Index> cables{0, 1, 2, 3, 4, 5};
    std::ranges::shuffle(cables, random);
    for (const Eigen::Index cable : cables) {
      channels.force.push_back({.number = cable, .gain = normal(random), .tare = normal(random)});
    }
    channels.sigma = channels.applied = channels.force;
    Echo echo(6);
    ScaledIo io(echo, channels);
    Command command = command_of(6);
    for (double& force : command.force) force = normal(random);
    io.send(command);
    Measurement back = measurement_of(6, 0);
    ASSERT_TRUE(io.receive(back));
    EXPECT_EQ(back.seq, 7);
    EXPECT_LT((back.sigma - command.force).norm(), 1e-13 * (1 + command.force.norm()));
    EXPECT_EQ(back.sigma, back.applied);
  }
}

TEST(Driver, IsFoundByItsName) {
  const Gains gains = toy::damped_gains();
  const DriverSetting setting = default_rig(gains).setting(gains);
  EXPECT_THROW(load_driver("simulated", setting), InputError);
  EXPECT_THROW(load_driver("./nowhere.so", setting), InputError);
  EXPECT_THROW(load_driver("device", setting), InputError);  // no from, no to
  DriverSetting odd = setting;
  odd.options["floor_rms"] = "much";
  EXPECT_THROW(load_driver("simulation", odd), InputError);
  Measurement m = measurement_of(gains.n_legs(), 0);
  EXPECT_TRUE((*load_driver("simulation", setting)).receive(m));
}

/// A beat is no command: an amplifier that the loop leaves to itself has to hear nothing.
TEST(DeviceIo, SendsCommandsAndNothingElse) {
  const test::ScratchFolder folder;
  for (const char* name : {"from", "to"}) ASSERT_EQ(mkfifo((folder / name).c_str(), 0600), 0);
  const int to = open((folder / "to").c_str(), O_RDWR | O_NONBLOCK);
  const Gains gains = toy::damped_gains();
  DriverSetting setting = default_rig(gains).setting(gains);
  setting.options = {{"from", folder / "from"}, {"to", folder / "to"}};
  const LoadedIo io = load_driver("device", setting);
  FrameSearch search(mark_commands, 8);
  const auto heard = [&]() -> std::vector<std::uint32_t> {
    const auto room = search.room();
    const ssize_t n = read(to, room.data(), room.size());
    if (n > 0) search.filled(static_cast<std::size_t>(n));
    const auto frame = search.next();
    return {frame.begin(), frame.end()};
  };
  (*io).beat();
  EXPECT_TRUE(heard().empty());
  (*io).enable(true);
  (*io).beat();
  EXPECT_TRUE(heard().empty());
  Command command = command_of(4);
  command.force << 1, -2, 3.4, 0;
  (*io).send(command);
  std::vector<std::uint32_t> frame = heard();
  ASSERT_EQ(frame.size(), 8u);
  EXPECT_EQ(frame[2], 1u);
  EXPECT_EQ(frame[3], 1u);
  EXPECT_EQ(static_cast<std::int32_t>(frame[4]), -2);
  EXPECT_EQ(frame[5], 3u);
  (*io).beat();
  EXPECT_TRUE(heard().empty());
  (*io).enable(false);
  frame = heard();
  ASSERT_EQ(frame.size(), 8u);
  EXPECT_EQ(std::vector(frame.begin() + 2, frame.end() - 1), std::vector<std::uint32_t>(5, 0));
  EXPECT_TRUE(heard().empty());
  close(to);
}

/// Frames among noise, cut anywhere into pieces, some bytes damaged: what is found was sent, and
/// all that was not damaged is found.
TEST(DeviceFrames, AreFoundInAnyStream) {
  std::mt19937 random(4);
  for (int trial = 0; trial < 30; ++trial) {
    std::vector<std::uint8_t> stream;
    std::vector<std::uint32_t> sound;
    for (std::uint32_t number = 0; number < 200; ++number) {
      std::vector<std::uint32_t> frame{mark_samples, number, static_cast<std::uint32_t>(random()),
                                       static_cast<std::uint32_t>(random()), 0};
      frame.back() = sum_of(std::span(frame).first(4));
      const bool damaged = random() % 10 == 0;
      if (!damaged) sound.push_back(number);
      if (damaged) frame[random() % 5] ^= 1u << (random() % 32);
      if (random() % 7 == 0) stream.push_back(static_cast<std::uint8_t>(random()));
      const auto* bytes = reinterpret_cast<const std::uint8_t*>(frame.data());
      stream.insert(stream.end(), bytes, bytes + 20);
    }
    FrameSearch search(mark_samples, 5);
    std::vector<std::uint32_t> found;
    for (std::size_t at = 0; at < stream.size();) {
      const auto room = search.room();
      ASSERT_FALSE(room.empty());
      const std::size_t n =
          std::min({room.size(), stream.size() - at, std::size_t{1} + random() % 60});
      std::copy_n(stream.begin() + static_cast<std::ptrdiff_t>(at), n, room.begin());
      search.filled(n);
      at += n;
      for (auto frame = search.next(); !frame.empty(); frame = search.next())
        found.push_back(frame[1]);
    }
    EXPECT_EQ(found, sound);
  }
}

}  // namespace
}  // namespace stillframe::controller

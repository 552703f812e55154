#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <thread>

#include "controller/controller_link.hpp"
#include "msgs/channels.hpp"
#include "msgs/direct_line.hpp"
#include "msgs/identity.hpp"
#include "msgs/lcm_bus.hpp"
#include "plant_sim/plant_link.hpp"

// The line beside LCM on which plant and controller of a lock-step run hand each other messages.
namespace stillframe {
namespace {

using namespace stillframe_msgs;
using Came = DirectLine::Came;

TEST(DirectLine, CarriesWholeMessagesBothWaysAndTellsTheEnd) {
  EXPECT_FALSE(DirectLine::to(70));
  LineOffer offer(70);
  EXPECT_FALSE(offer.accepted());
  auto there = DirectLine::to(70);
  ASSERT_TRUE(there);
  auto here = offer.accepted();
  ASSERT_TRUE(here);
  EXPECT_EQ(here->take(0), Came::nothing);
  const std::string bytes("a\0b", 3);
  EXPECT_TRUE(there->send("FIRST", bytes.data(), bytes.size()));
  EXPECT_TRUE(there->send("EMPTY", nullptr, 0));
  ASSERT_EQ(here->take(1000), Came::message);
  EXPECT_EQ(here->channel(), "FIRST");
  EXPECT_EQ(here->bytes(), bytes);
  ASSERT_EQ(here->take(1000), Came::message);
  EXPECT_EQ(here->channel(), "EMPTY");
  EXPECT_EQ(here->bytes(), "");
  EXPECT_TRUE(here->send("BACK", bytes.data(), bytes.size()));
  here.reset();
  // What was said before the end is heard before it.
  ASSERT_EQ(there->take(1000), Came::message);
  EXPECT_EQ(there->channel(), "BACK");
  EXPECT_EQ(there->take(1000), Came::end);
  EXPECT_FALSE(there->send("LATE", bytes.data(), bytes.size()));
}

TEST(DirectLine, IsToOneAndEndsForWhoIsNotTaken) {
  std::optional<DirectLine> second;
  {
    LineOffer offer(71);
    auto first = DirectLine::to(71);
    second = DirectLine::to(71);
    ASSERT_TRUE(first && second);
    auto here = offer.accepted();
    ASSERT_TRUE(here);
    ASSERT_TRUE(first->send("ONE", "x", 1));
    ASSERT_EQ(here->take(1000), Came::message);
    EXPECT_EQ(here->channel(), "ONE");
  }
  EXPECT_EQ(second->take(1000), Came::end);
}

TEST(DirectLine, WhatIsNoMessageEndsIt) {
  for (const std::size_t size : {std::size_t{100}, std::size_t{70'000}}) {
    LineOffer offer(72);
    auto there = DirectLine::to(72);
    auto here = offer.accepted();
    ASSERT_TRUE(there && here);
    const std::string bytes(size, 'x');
    ASSERT_TRUE(there->send(size > 1000 ? "LARGE" : "FITS", bytes.data(), bytes.size()));
    EXPECT_EQ(here->take(1000), size > 1000 ? Came::end : Came::message);
  }
}

/// A plant and a controller that have agreed to run, in one thread.
class DirectRun : public testing::Test {
 protected:
  static run_info_t info() {
    run_info_t info{};
    info.format_version = 1;
    info.run_id = 5;
    info.plant_instance = new_instance();
    info.mode = "lock_step";
    info.sample_rate_hz = 1000;
    info.n_legs = 1;
    info.n_samples = 10;
    info.leg_names = {"leg"};
    return info;
  }
  void agree() {
    for (int attempt = 0; attempt < 200 && !plant.controller_ready(); ++attempt) {
      plant.publish_state(run_state_t::WAITING, 0, "");
      plant.publish_info();
      controller::Heard heard;
      do {
        heard = link->take(20);
        if (heard.run_info) {
          link->follow(link->run_info());
          link->publish_state(5, run_state_t::READY, "");
        }
      } while (heard.message);
      while (plant.listen(5)) {
      }
    }
    ASSERT_TRUE(plant.controller_ready());
    plant.go_direct();
  }
  /// Measurement k out, and its command back.
  ::testing::AssertionResult exchanges(std::int64_t k) {
    Reading reading;
    reading.sigma = reading.applied_force = Eigen::VectorXd::Constant(1, static_cast<double>(k));
    plant.publish_measurement(k, reading);
    for (int attempt = 0; attempt < 100; ++attempt) {
      const auto heard = link->take(20);
      if (!heard.measurement || link->measurement().seq != k) continue;
      link->command().run_id = 5;
      link->command().plant_instance = plant.info().plant_instance;
      link->command().seq = k;
      link->command().force = {static_cast<double>(2 * k)};
      link->publish_command();
      break;
    }
    for (int attempt = 0; attempt < 100 && plant.command_seq() < k; ++attempt) {
      plant.listen(20);
      plant.take_commands(k);
    }
    if (plant.command_seq() != k || plant.command_force()(0) != static_cast<double>(2 * k)) {
      return ::testing::AssertionFailure() << "command " << plant.command_seq() << " for " << k;
    }
    return ::testing::AssertionSuccess();
  }

  PlantLink plant{lcm_url(""), info()};
  std::optional<controller::ControllerLink> link{std::in_place, lcm_url("")};
};

TEST_F(DirectRun, GoesByTheLineAndIsHeardOverLcmToo) {
  const auto witness = open_lcm(lcm_url(""));
  std::vector<std::string> heard;
  struct Ear {
    std::vector<std::string>* heard;
    void hear(const lcm::ReceiveBuffer*, const std::string& channel) { heard->push_back(channel); }
  } ear{&heard};
  for (const char* channel : {channels::measurement, channels::command}) {
    witness->subscribe(channel, &Ear::hear, &ear);
  }
  agree();
  EXPECT_TRUE(plant.is_direct());
  for (std::int64_t k = 0; k < 4; ++k) EXPECT_TRUE(exchanges(k));
  EXPECT_TRUE(link->is_direct());
  while (handle_one(*witness, 100)) {
  }
  std::vector<std::string> expected;
  for (int k = 0; k < 4; ++k) {
    expected.insert(expected.end(), {channels::measurement, channels::command});
  }
  EXPECT_EQ(heard, expected) << "in their order, each once";
  EXPECT_EQ(plant.n_duplicate(), 0);
}

TEST_F(DirectRun, WithoutTheLineItGoesOnOverLcm) {
  agree();
  EXPECT_TRUE(exchanges(0));
  EXPECT_TRUE(exchanges(1));
  // The controller dies, and another one comes to the run that goes on.
  const run_info_t followed = link->run_info();
  link.reset();
  plant.listen(0);
  EXPECT_FALSE(plant.is_direct());
  link.emplace(lcm_url(""));
  link->follow(followed);
  plant.free_seat();
  EXPECT_TRUE(exchanges(2));
  EXPECT_FALSE(link->is_direct());
  EXPECT_TRUE(exchanges(3));
}

TEST_F(DirectRun, AnotherControllerTakesTheSeatOfOneThatIsSilentOnTheLine) {
  agree();
  EXPECT_TRUE(exchanges(0));
  // It stands still, with its end of the line open.
  auto other = std::make_unique<controller::ControllerLink>(lcm_url(""));
  other->follow(link->run_info());
  plant.free_seat();
  EXPECT_FALSE(plant.is_direct());
  other->command().run_id = 5;
  other->command().plant_instance = plant.info().plant_instance;
  other->command().seq = 1;
  other->command().force = {7};
  other->publish_command();
  for (int attempt = 0; attempt < 100 && plant.command_seq() < 1; ++attempt) {
    plant.listen(20);
    plant.take_commands(1);
  }
  EXPECT_EQ(plant.command_seq(), 1);
  // The one that slept finds its line ended, and hears LCM.
  for (int attempt = 0; attempt < 100 && link->is_direct(); ++attempt) link->take(20);
  EXPECT_FALSE(link->is_direct());
}

TEST_F(DirectRun, TheEndOfAPlantIsHeardBeforeItsLineEnds) {
  agree();
  EXPECT_TRUE(exchanges(0));
  plant.publish_state(run_state_t::ENDED, 0, "");
  ASSERT_TRUE(link->take(1000).run_state);
  EXPECT_EQ(link->plant_state().state, run_state_t::ENDED);
}

TEST_F(DirectRun, AControllerThatGivesUpSaysSoOnTheLine) {
  agree();
  EXPECT_TRUE(exchanges(0));
  link->publish_state(5, run_state_t::FAILED, "enough");
  EXPECT_TRUE(plant.listen(1000));
  EXPECT_EQ(plant.controller_failure(), "the controller refused: enough");
}

}  // namespace
}  // namespace stillframe

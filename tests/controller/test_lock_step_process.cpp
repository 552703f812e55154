#include <cstring>
#include <limits>

#include "controller/controller_link.hpp"
#include "msgs/channels.hpp"
#include "msgs/peer_clocks.hpp"
#include "tests/controller/controller_process.hpp"
#include "tests/support/allocation_count.hpp"

namespace stillframe::controller {
namespace {

TEST_F(ControllerProcess, LockStepAnswersToTheBitAndInOrder) {
  constexpr std::int64_t n_samples = 2000;
  Gains gains = toy::gains(5, 1000, 0);
  gains.force_limit_n = 0.005;  // reached in the first swings, then no more
  toy::FakePlant plant(toy::run_info(gains, 42, "lock_step", n_samples));
  ChildProcess controller(command_line(gains, {"--run-id", "42"}));
  ASSERT_EQ(plant.announce(), run_state_t::READY);
  plant.publish_state(run_state_t::RUNNING);
  Reference reference(gains, plant);
  int n_saturated = 0;
  for (std::int64_t k = 0; k < n_samples; ++k) {
    const measurement_t measurement = plant.measure(k);
    const auto command = plant.exchange(measurement);
    ASSERT_TRUE(command) << "no answer to " << k;
    ASSERT_EQ(plant.command_bytes.back(), reference(measurement)) << "sample " << k;
    n_saturated += command->saturated;
    plant.move(command->force);
  }
  EXPECT_GT(n_saturated, 0);
  EXPECT_LT(n_saturated, n_samples / 2);
  ASSERT_EQ(plant.commands.size(), static_cast<size_t>(n_samples));
  for (std::int64_t k = 0; k < n_samples; ++k) {
    ASSERT_EQ(plant.commands[static_cast<size_t>(k)].seq, k);
  }
  plant.publish_state(run_state_t::ENDED);
  EXPECT_EQ(controller.wait(), 0) << controller.err();
  EXPECT_TRUE(contains(controller.out(), "controller: 2000 periods, 0 late, 0 lost, worst wake-up"))
      << controller.out();
  while (!plant.timing && plant.take(1000)) {
  }
  ASSERT_TRUE(plant.timing);
  EXPECT_EQ(plant.timing->run_id, 42);
  EXPECT_EQ(plant.timing->n_periods, n_samples);
  EXPECT_EQ(plant.timing->n_duplicate, 0);
  EXPECT_EQ(plant.timing->worst_wake_up_ns, 0);
  EXPECT_GT(plant.timing->worst_compute_ns, 0);
  EXPECT_GT(plant.timing->wall_time_ns, 0);
}

TEST_F(ControllerProcess, AMeasurementHeardAgainIsAnsweredWithTheSameBytes) {
  const Gains gains = toy::gains(5);
  toy::FakePlant plant(toy::run_info(gains, 1, "lock_step", 3));
  ChildProcess controller(command_line(gains));
  ASSERT_EQ(plant.announce(), run_state_t::READY);
  plant.publish_state(run_state_t::RUNNING);
  Reference reference(gains, plant);
  for (std::int64_t k = 0; k < 3; ++k) {
    const measurement_t measurement = plant.measure(k);
    const auto expected = reference(measurement);
    for (int again = 0; again < 3; ++again) {
      plant.commands.clear();
      ASSERT_TRUE(plant.exchange(measurement));
      EXPECT_EQ(plant.command_bytes.back(), expected);
    }
  }
  plant.publish_state(run_state_t::ENDED);
  EXPECT_EQ(controller.wait(), 0) << controller.err();
  EXPECT_TRUE(contains(controller.out(), "controller: 3 periods, 0 late, 0 lost"));
  while (!plant.timing && plant.take(1000)) {
  }
  ASSERT_TRUE(plant.timing);
  EXPECT_EQ(plant.timing->n_duplicate, 6);
}

TEST_F(ControllerProcess, ForeignAndDamagedMessagesAreIgnored) {
  const Gains gains = toy::gains(5);
  toy::FakePlant plant(toy::run_info(gains, 1, "lock_step", 3));
  ChildProcess controller(command_line(gains, {"--run-id", "1"}));
  toy::FakePlant other(toy::run_info(toy::gains(2), 2, "lock_step", 3));
  // The other run is always announced first: the controller must still take the one it was started
  // for.
  for (int attempt = 0; attempt < 500 && !plant.is_answered(); ++attempt) {
    for (toy::FakePlant* each : {&other, &plant}) {
      each->publish_state(run_state_t::WAITING);
      each->lcm().publish(channels::run_info, &each->info());
    }
  }
  ASSERT_FALSE(plant.states.empty());
  ASSERT_EQ(plant.states.front().run_id, 1);
  plant.publish_state(run_state_t::RUNNING);
  Reference reference(gains, plant);
  ASSERT_TRUE(plant.exchange(plant.measure(0)));
  EXPECT_EQ(plant.command_bytes.back(), reference(plant.measure(0)));
  const size_t n_before = plant.commands.size();
  other.publish(other.measure(1));
  other.publish_state(run_state_t::ENDED);
  measurement_t short_one = plant.measure(1);
  short_one.n_legs = 3;
  plant.publish(short_one);
  std::vector<std::uint8_t> bytes(static_cast<size_t>(plant.measure(1).getEncodedSize()));
  plant.measure(1).encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  plant.publish_raw(channels::measurement, bytes.data(), 10);
  auto huge = bytes;  // claims 2^31 - 1 legs
  std::memcpy(huge.data() + 52, "\x7f\xff\xff\xff", 4);
  plant.publish_raw(channels::measurement, huge.data(), huge.size());
  auto negative = bytes;  // and -1 floor inputs
  std::memcpy(negative.data() + 48, "\xff\xff\xff\xff", 4);
  plant.publish_raw(channels::measurement, negative.data(), negative.size());
  plant.publish_raw(channels::run_state, bytes.data(), bytes.size());
  for (std::int64_t k = 1; k < 3; ++k) {
    ASSERT_TRUE(plant.exchange(plant.measure(k)));
    EXPECT_EQ(plant.command_bytes.back(), reference(plant.measure(k)));
  }
  EXPECT_EQ(plant.commands.size(), n_before + 2);
  plant.publish_state(run_state_t::ENDED);
  EXPECT_EQ(controller.wait(), 0) << controller.err();
}

TEST_F(ControllerProcess, NothingThatATerminalObeysIsPrinted) {
  const Gains gains = toy::gains(5);
  auto info = toy::run_info(gains, 1, "lock_step", 2);
  info.scene_name = "evil\033]0;title\007\x9b";
  toy::FakePlant plant(info);
  ChildProcess controller(command_line(gains));
  ASSERT_EQ(plant.announce(), run_state_t::READY);
  plant.publish_state(run_state_t::RUNNING);
  plant.publish_state(run_state_t::FAILED, 0, "a\033[2Jb");
  EXPECT_EQ(controller.wait(), 4);
  EXPECT_TRUE(contains(controller.err(), "evil\\x1b]0;title\\x07\\x9b")) << controller.err();
  EXPECT_TRUE(contains(controller.err(), "the plant failed: a\\x1b[2Jb")) << controller.err();
}

TEST_F(ControllerProcess, PassiveLoopCommandsZero) {
  const Gains gains = toy::gains(5);
  auto info = toy::run_info(gains, 1, "lock_step", 2);
  info.loop = "passive";
  toy::FakePlant plant(info);
  ChildProcess controller(command_line(gains));
  ASSERT_EQ(plant.announce(), run_state_t::READY);
  plant.publish_state(run_state_t::RUNNING);
  for (std::int64_t k = 0; k < 2; ++k) {
    const auto command = plant.exchange(plant.measure(k));
    ASSERT_TRUE(command);
    EXPECT_EQ(command->force, std::vector<double>(4, 0.0));
  }
  plant.publish_state(run_state_t::ENDED);
  EXPECT_EQ(controller.wait(), 0) << controller.err();
}

TEST_F(ControllerProcess, NonFiniteMeasurementFallsBackAndExits4) {
  const Gains gains = toy::gains(5);
  toy::FakePlant plant(toy::run_info(gains, 1, "lock_step", 1));
  ChildProcess controller(command_line(gains));
  ASSERT_EQ(plant.announce(), run_state_t::READY);
  plant.publish_state(run_state_t::RUNNING);
  measurement_t measurement = plant.measure(0);
  measurement.sigma[1] = std::numeric_limits<double>::quiet_NaN();
  const auto command = plant.exchange(measurement);
  ASSERT_TRUE(command);
  EXPECT_EQ(command->force, std::vector<double>(4, 0.0));
  plant.publish_state(run_state_t::ENDED);
  EXPECT_EQ(controller.wait(), 4);
  EXPECT_TRUE(contains(controller.err(), "1 commands fell back to zero force")) << controller.err();
}

// A recording of a plant says all that a plant says, at other times.
TEST_F(ControllerProcess, ARecordedPlantIsNotFollowed) {
  const Gains gains = toy::gains(5);
  toy::FakePlant plant(toy::run_info(gains, 1, "lock_step", 3)), recorded(plant.info());
  ChildProcess controller(command_line(gains, {"--run-id", "1"}));
  run_state_t old{};
  old.run_id = 1;
  old.plant_instance = plant.info().plant_instance;
  old.source = "plant";
  old.state = run_state_t::WAITING;
  old.sent_ns = monotonic_ns() - fresh_ns;
  // It hears this one as well, over and over, before the living one.
  toy::FakePlant living([&] {
    auto info = plant.info();
    info.plant_instance = 77;
    return info;
  }());
  for (int attempt = 0; attempt < 1000 && !living.is_answered(); ++attempt) {
    recorded.lcm().publish(channels::run_state, &old);
    recorded.lcm().publish(channels::run_info, &recorded.info());
    living.publish_state(run_state_t::WAITING);
    living.lcm().publish(channels::run_info, &living.info());
  }
  ASSERT_FALSE(living.states.empty());
  for (const run_state_t& state : living.states) EXPECT_EQ(state.plant_instance, 77);
  living.publish_state(run_state_t::RUNNING);
  Reference reference(gains, living);
  for (std::int64_t k = 0; k < 3; ++k) {
    measurement_t measurement = living.measure(k);
    measurement.plant_instance = plant.info().plant_instance;
    measurement.sigma[0] = 1e4;
    recorded.publish(measurement);  // and the recorded run goes on
    recorded.publish_state(run_state_t::ENDED);
    ASSERT_TRUE(living.exchange(living.measure(k)));
    EXPECT_EQ(living.command_bytes.back(), reference(living.measure(k)));
  }
  living.publish_state(run_state_t::ENDED);
  EXPECT_EQ(controller.wait(), 0) << controller.err();
}

TEST_F(ControllerProcess, AStartInTheFarFutureIsRefused) {
  const Gains gains = toy::gains(5, 1000, 1);
  toy::FakePlant plant(toy::run_info(gains, 9, "wall_clock", 100));
  ChildProcess controller(command_line(gains));
  ASSERT_EQ(plant.announce(), run_state_t::READY);
  plant.publish_state(run_state_t::RUNNING, monotonic_ns() + 3600 * ns_per_s);
  EXPECT_EQ(controller.wait(), 2);
  EXPECT_TRUE(contains(controller.err(), "start_monotonic_ns: found ")) << controller.err();
}

// Taking a measurement, answering and publishing allocates nothing of its own; what liblcm does
// inside its shared library is not counted.
TEST(ControllerLink, SteadyStateDoesNotAllocate) {
  const Gains gains = toy::gains(5);
  toy::FakePlant plant(toy::run_info(gains, 1, "lock_step", 100));
  ControllerLink link("");
  link.follow(plant.info());
  Answer answer(law_from_gains(gains), {}, true);
  std::int64_t allocated = 0;
  int heard = 0;
  for (std::int64_t k = 0; k < 20; ++k) {
    plant.publish(plant.measure(k));
    const auto before = test::allocation_count();
    for (int attempt = 0; attempt < 50; ++attempt) {
      if (!link.take(100).measurement) continue;
      answer.answer(link.measurement(), link.command());
      link.publish_command();
      ++heard;
      break;
    }
    allocated += test::allocation_count() - before;
  }
  EXPECT_EQ(heard, 20);
  EXPECT_EQ(allocated, 0);
}

}  // namespace
}  // namespace stillframe::controller

#include <gtest/gtest.h>

#include <limits>

#include "msgs/channels.hpp"
#include "msgs/clock.hpp"
#include "msgs/identity.hpp"
#include "msgs/lcm_bus.hpp"
#include "msgs/peer_clocks.hpp"
#include "plant_sim/plant_link.hpp"
#include "stillframe_msgs/clock_exchange_t.hpp"

// Whom a plant obeys. Over LCM, in a network of its own.
namespace stillframe {
namespace {

using namespace stillframe_msgs;

run_info_t info_of(std::int64_t run_id, std::int64_t plant_instance, const char* mode) {
  run_info_t info{};
  info.run_id = run_id;
  info.plant_instance = plant_instance;
  info.mode = mode;
  info.sample_rate_hz = 1000;
  info.n_legs = 2;
  return info;
}

class Obedience : public testing::Test {
 protected:
  static constexpr std::int64_t period_ns = 1'000'000;

  Obedience() {
    link.set_clock(start, period_ns);
    link.refuse_after(1'000'000);
  }

  command_t command(std::int64_t instance, std::int64_t seq) const {
    command_t message{};
    message.run_id = 5;
    message.plant_instance = 50;
    message.instance = instance;
    message.seq = seq;
    message.sent_ns = start + seq * period_ns;
    message.n_legs = 2;
    message.force = {static_cast<double>(seq), static_cast<double>(instance)};
    return message;
  }

  /// Sends it and waits until the plant has it; the sample whose command stands then.
  std::int64_t after(const command_t& message) {
    bus->publish(channels::command, &message);
    hear();
    return link.command_seq();
  }
  template <class Message>
  void say(const char* channel, const Message& message) {
    bus->publish(channel, &message);
    hear();
  }
  void hear() {
    EXPECT_TRUE(link.listen(10'000));
    link.take_commands(std::numeric_limits<std::int64_t>::max());
  }

  run_state_t state(const char* source, std::int32_t what, std::int64_t instance) const {
    run_state_t message{};
    message.run_id = 5;
    message.plant_instance = 50;
    message.instance = instance;
    message.sent_ns = monotonic_ns();
    message.source = source;
    message.state = what;
    message.text = "a reason";
    return message;
  }

  const std::int64_t start = monotonic_ns() - 1000 * period_ns;
  PlantLink link{lcm_url(""), info_of(5, 50, "wall_clock")};
  std::unique_ptr<lcm::LCM> bus = open_lcm(lcm_url(""));
};

TEST_F(Obedience, OneControllerAtATime) {
  EXPECT_EQ(after(command(7, 10)), 10);
  EXPECT_EQ(after(command(8, 11)), 10);  // another one beside it
  EXPECT_EQ(link.n_foreign(), 1);
  EXPECT_EQ(after(command(7, 12)), 12);
  link.free_seat();  // the first one is silent, and goes on before anybody else comes
  EXPECT_EQ(after(command(7, 13)), 13);
  EXPECT_EQ(after(command(8, 14)), 13);
  link.free_seat();
  EXPECT_EQ(after(command(8, 15)), 15);
  EXPECT_EQ(after(command(7, 16)), 15) << "the first one comes back too late";
  EXPECT_EQ(link.command_force()(1), 8);
  EXPECT_EQ(link.n_foreign(), 3);
  EXPECT_EQ(link.n_malformed(), 0);
}

TEST_F(Obedience, OnlyCommandsForThisPlantThatWereSentSinceTheirSample) {
  EXPECT_EQ(after(command(7, 10)), 10);
  command_t other = command(7, 11);
  other.plant_instance = 51;  // of the run of that number before
  EXPECT_EQ(after(other), 10);
  EXPECT_EQ(link.n_foreign(), 1);
  int n = 0;
  for (const std::int64_t sent :
       {start - 1, start + 9 * period_ns, monotonic_ns() + ns_per_s, std::int64_t{0},
        std::numeric_limits<std::int64_t>::min(), std::numeric_limits<std::int64_t>::max()}) {
    command_t stale = command(7, 11);
    stale.sent_ns = sent;
    EXPECT_EQ(after(stale), 10) << sent;
    EXPECT_EQ(link.n_malformed(), ++n);
  }
  EXPECT_EQ(after(command(7, 11)), 11);
}

TEST_F(Obedience, AClaimedSizeIsNotBelieved) {
  for (const std::int64_t run : {5, 6}) {
    command_t message = command(7, 10);
    message.run_id = run;
    std::string bytes(static_cast<std::size_t>(message.getEncodedSize()), '\0');
    message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
    bytes.replace(8 + 6 * 8, 4, {'\x20', '\0', '\0', '\0'});  // n_legs = 2^29
    bus->publish(channels::command, bytes.data(), static_cast<unsigned>(bytes.size()));
    hear();
    bus->publish(channels::command, bytes.data(), 11);
    hear();
  }
  EXPECT_EQ(link.command_seq(), -1);
  EXPECT_EQ(link.n_malformed(), 3);  // of another run it is no concern how it is made
}

TEST_F(Obedience, AControllerThatIsNotObeyedEndsNothing) {
  EXPECT_EQ(after(command(7, 10)), 10);
  say(channels::run_state, state("controller", run_state_t::FAILED, 8));
  EXPECT_EQ(link.controller_failure(), "");
  run_state_t elsewhere = state("controller", run_state_t::READY, 7);
  elsewhere.plant_instance = 51;
  say(channels::run_state, elsewhere);
  EXPECT_FALSE(link.controller_ready());
  say(channels::run_state, state("controller", run_state_t::READY, 7));
  EXPECT_TRUE(link.controller_ready());
  say(channels::run_state, state("controller", run_state_t::FAILED, 7));
  EXPECT_EQ(link.controller_failure(), "the controller refused: a reason");
}

// A controller that comes with the wrong gains, while the one that was there first listens and
// arms.
TEST_F(Obedience, ASecondControllerThatRefusesEndsNothing) {
  say(channels::run_state, state("controller", run_state_t::READY, 7));
  say(channels::run_state, state("controller", run_state_t::FAILED, 8));
  say(channels::run_state, state("controller", run_state_t::READY, 8));
  say(channels::run_state, state("controller", run_state_t::FAILED, 8));
  EXPECT_EQ(link.controller_failure(), "");
  say(channels::run_state, state("controller", run_state_t::FAILED, 7));
  EXPECT_EQ(link.controller_failure(), "the controller refused: a reason");
}

// The first of two that are ready may leave; the run ends with the second.
TEST_F(Obedience, AsLongAsAnotherIsReadyTheRunWaitsForIt) {
  say(channels::run_state, state("controller", run_state_t::READY, 7));
  say(channels::run_state, state("controller", run_state_t::READY, 8));
  say(channels::run_state, state("controller", run_state_t::FAILED, 7));
  EXPECT_EQ(link.controller_failure(), "");
  EXPECT_TRUE(link.controller_ready());
  say(channels::run_state, state("controller", run_state_t::FAILED, 8));
  EXPECT_EQ(link.controller_failure(), "the controller refused: a reason");
}

// Before any is ready there is none to go on for.
TEST_F(Obedience, TheOnlyControllerThatRefusesEndsTheRun) {
  say(channels::run_state, state("controller", run_state_t::FAILED, 8));
  EXPECT_EQ(link.controller_failure(), "the controller refused: a reason");
}

struct Question {
  clock_exchange_t message;
  void on_clock(const lcm::ReceiveBuffer*, const std::string&, const clock_exchange_t* heard) {
    message = *heard;
  }
};

/// A controller on another clock: until that is known nothing is wrong with its commands.
TEST(PlantElsewhere, ACommandOfAnUnknownClockIsNotMalformed) {
  const std::int64_t plant = (std::int64_t{1} << bits_below_clock) + 50;
  const std::int64_t controller = (std::int64_t{2} << bits_below_clock) + 7;
  constexpr std::int64_t ahead = 40'000 * ns_per_s, period_ns = 1'000'000;
  PlantLink link(lcm_url(""), info_of(5, plant, "wall_clock"));
  const std::int64_t start = monotonic_ns() - 1000 * period_ns;
  link.set_clock(start, period_ns);
  link.refuse_after(1'000'000);
  const auto bus = open_lcm(lcm_url(""));
  Question asked;
  require_hearing(*bus);
  bus->subscribe(channels::clock, &Question::on_clock, &asked);
  command_t command{};
  command.run_id = 5;
  command.plant_instance = plant;
  command.instance = controller;
  command.n_legs = 2;
  command.force = {1, 2};
  const auto send = [&](std::int64_t seq, std::int64_t sent_ns) {
    command.seq = seq;
    command.sent_ns = sent_ns;
    bus->publish(channels::command, &command);
    EXPECT_TRUE(link.listen(10'000));
    while (link.listen(50)) {  // it hears its own questions as well
    }
  };
  send(10, monotonic_ns() + ahead);
  EXPECT_EQ(link.n_clock_unknown(), 1);
  EXPECT_EQ(link.n_malformed(), 0);
  send(10, -1);  // no clock shows that
  EXPECT_EQ(link.n_malformed(), 1);
  ASSERT_TRUE(handle_one(*bus, 10'000));
  asked.message.heard_ns = asked.message.answered_ns = monotonic_ns() + ahead;
  bus->publish(channels::clock, &asked.message);
  send(10, monotonic_ns() + ahead);
  EXPECT_EQ(link.n_commands(), 1);
  send(11, start + ahead - period_ns);  // and what is wrong then is
  EXPECT_EQ(link.n_clock_unknown(), 1);
  EXPECT_EQ(link.n_malformed(), 2);
}

// Of two plants of one number exactly one goes, whatever they do and whichever began first.
TEST_F(Obedience, ExactlyOneOfTwoPlantsGoes) {
  for (const bool a_runs : {false, true}) {
    for (const bool b_runs : {false, true}) {
      for (const std::int64_t later : {-1, 1}) {
        PlantLink a(lcm_url(""), info_of(6, 60, "wall_clock"));
        PlantLink b(lcm_url(""), info_of(6, 61, "wall_clock"));
        const auto begin = [&](PlantLink& plant, bool runs, std::int64_t at) {
          if (runs) plant.set_clock(at, period_ns);
          const std::int32_t where =
              runs ? std::int32_t{run_state_t::RUNNING} : std::int32_t{run_state_t::WAITING};
          plant.publish_state(where, runs ? at : 0, "");
        };
        begin(a, a_runs, start);
        begin(b, b_runs, start + later);
        // Both hear both; what a plant that stays answers, the other one hears as well.
        for (int n = 0; n < 100 && a.rival().empty() && b.rival().empty(); ++n) {
          a.listen(100);
          b.listen(100);
        }
        while (a.listen(50) || b.listen(50)) {
        }
        EXPECT_NE(a.rival().empty(), b.rival().empty()) << a_runs << b_runs << later;
        if (a_runs || b_runs) {
          EXPECT_EQ(a.rival().empty(), a_runs && (!b_runs || later > 0)) << b_runs << later;
        }
      }
    }
  }
}

TEST_F(Obedience, ARecordedPlantIsNoRival) {
  run_state_t old = state("plant", run_state_t::RUNNING, 51);
  old.plant_instance = 51;
  old.sent_ns = monotonic_ns() - fresh_ns;
  say(channels::run_state, old);
  EXPECT_EQ(link.rival(), "");
  old.sent_ns = monotonic_ns();
  say(channels::run_state, old);
  EXPECT_NE(link.rival().find("another plant runs as run 5"), std::string::npos);
}

}  // namespace
}  // namespace stillframe

#include <bit>
#include <cmath>
#include <cstdio>

#include "controller/flight_file.hpp"
#include "tests/tools/replay_logs.hpp"
#include "tests/tools/verb.hpp"

namespace stillframe::test {
namespace {

using stillframe_msgs::command_t;
using stillframe_msgs::loop_checkpoint_t;
using stillframe_msgs::loop_records_t;
using stillframe_msgs::measurement_t;
using stillframe_msgs::run_info_t;

/// The same number with its last bit turned round.
double next_to(double value) {
  return std::bit_cast<double>(std::bit_cast<std::uint64_t>(value) ^ std::uint64_t{1});
}

std::string digits(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

class Replay : public Verb {
 protected:
  std::filesystem::path log_file(const Log& log) const {
    write_log(folder_ / "run.lcm", log);
    return folder_ / "run.lcm";
  }

  Said replay(const Log& log, std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"replay", log_file(log)});
    return run(more);
  }

  nlohmann::json result_of(const Log& log, int exit_code,
                           std::vector<std::string> more = {}) const {
    more.push_back("--json");
    const Said said = replay(log, more);
    EXPECT_EQ(said.exit_code, exit_code) << said.error;
    return nlohmann::json::parse(said.output);
  }

  void expect_same(const Log& log, std::int64_t n_commands) const {
    const auto result = result_of(log, 0);
    EXPECT_EQ(result.at("n_commands"), n_commands);
    EXPECT_EQ(result.at("n_different"), 0);
    EXPECT_TRUE(result.at("first_difference").is_null()) << result.dump(2);
  }
};

Log wall_clock_log(LoggedRig& rig) {
  Log log;
  add(log, channels::run_info, info_of(wall_clock_gains(), LoggedRig::run_id, "wall_clock"));
  const Log told = rig.log();
  log.insert(log.end(), told.begin(), told.end());
  return log;
}

TEST_F(Replay, LockStepGivesTheSameCommands) {
  const Log log = lock_step_log(400);
  expect_same(log, 400);
  const Said said = replay(log);
  EXPECT_NE(said.output.find("400 commands the same, to the bit"), std::string::npos)
      << said.output;
  expect_documented_keys("replay", result_of(log, 0));
}

TEST_F(Replay, LockStepLogsHoldSaturatedCommands) {
  int n_saturated = 0;
  for (const LoggedMessage& logged : lock_step_log(400)) {
    command_t command;
    if (logged.channel != channels::command) continue;
    command.decode(logged.bytes.data(), 0, static_cast<int>(logged.bytes.size()));
    n_saturated += command.saturated;
  }
  EXPECT_GT(n_saturated, 20);  // else the tests here would not see the limit
  EXPECT_LT(n_saturated, 380);
}

TEST_F(Replay, OneBitOfOneCommandIsNamed) {
  Log log = lock_step_log(400);
  double computed = 0;
  change<command_t>(log, channels::command, 123, [&computed](command_t& command) {
    computed = command.force[2];
    command.force[2] = next_to(computed);
  });
  const Said said = replay(log);
  EXPECT_EQ(said.exit_code, 4);
  EXPECT_NE(said.output.find("1 of 400 commands differ\nThe first that differs: SF_COMMAND, seq "
                             "123, leg_3: force recorded " +
                             digits(next_to(computed)) + ", computed " + digits(computed) + "\n"),
            std::string::npos)
      << said.output;
  const auto result = result_of(log, 4);
  EXPECT_EQ(result.at("n_different"), 1);
  EXPECT_EQ(result.at("first_difference").at("seq"), 123);
  EXPECT_EQ(result.at("first_difference").at("leg"), "leg_3");
  EXPECT_EQ(result.at("first_difference").at("recorded"), next_to(computed));
  EXPECT_EQ(result.at("first_difference").at("computed"), computed);
}

TEST_F(Replay, OneBitOfOneMeasurementIsSeenFromThereOn) {
  Log log = lock_step_log(400);
  change<measurement_t>(log, channels::measurement, 57,
                        [](measurement_t& m) { m.sigma[0] = next_to(m.sigma[0]) * (1 + 1e-9); });
  const auto first = result_of(log, 4).at("first_difference");
  EXPECT_GE(first.at("seq"), 57);
  EXPECT_LE(first.at("seq"), 60);  // saturated commands hide it
  EXPECT_EQ(first.at("leg"), "leg_1");
}

TEST_F(Replay, RepeatsCountOnce) {
  Log log = lock_step_log(50), repeated;
  for (const LoggedMessage& logged : log) {
    repeated.push_back(logged);
    repeated.push_back(logged);
  }
  expect_same(repeated, 50);
  EXPECT_EQ(result_of(repeated, 0).at("n_other"), 0);
}

TEST_F(Replay, APassiveRunIsZeroForce) { expect_same(lock_step_log(50, 7, "passive"), 50); }

TEST_F(Replay, OtherGainsGiveOtherCommands) {
  controller::Gains gains = limited_gains();
  gains.K_P(1, 1) *= 1 + 1e-12;
  const auto file = write("gains.yaml", to_yaml(gains));
  const auto first =
      result_of(lock_step_log(50), 4, {"--gains", file.string()}).at("first_difference");
  EXPECT_EQ(first.at("leg"), "leg_2");
  const auto three = write("three.yaml", to_yaml([] {
                             controller::Gains less = limited_gains();
                             less.legs.resize(3);
                             less.K_P = less.K_P.topLeftCorner(3, 3).eval();
                             less.K_I = less.K_I.topLeftCorner(3, 3).eval();
                             less.plant.B = less.plant.B.leftCols(3).eval();
                             less.plant.C = less.plant.C.topRows(3).eval();
                             return less;
                           }()));
  const Said said = replay(lock_step_log(50), {"--gains", three.string()});
  EXPECT_EQ(said.exit_code, 2);
  EXPECT_NE(said.error.find("the gains are for 3 legs, the log has 4"), std::string::npos)
      << said.error;
}

TEST_F(Replay, AMeasurementThatIsNotInALockStepLogIsSaid) {
  Log log = lock_step_log(50);
  log.erase(log.begin() + 1 + 2 * 20);
  const Said said = replay(log);
  EXPECT_EQ(said.exit_code, 2);
  EXPECT_NE(said.error.find("measurement 20 is not in the log"), std::string::npos) << said.error;
}

TEST_F(Replay, CommandsThatWereNotLoggedAreCounted) {
  Log log = lock_step_log(50);
  log.pop_back();
  const auto result = result_of(log, 0);
  EXPECT_EQ(result.at("n_commands"), 49);
  EXPECT_EQ(result.at("n_not_logged"), 1);
}

TEST_F(Replay, WallClockGivesTheSameCommandsThroughAllThatCanHappen) {
  LoggedRig rig;
  rig.story();
  const auto& counters = rig.rig().loop().counters();
  ASSERT_EQ(counters.n_records_dropped, 0);
  EXPECT_GE(counters.n_faults, 2);  // suspended and not_finite
  EXPECT_GT(counters.n_saturated, 0);
  EXPECT_GT(counters.n_late, 0);
  EXPECT_EQ(rig.rig().state(), controller::State::active);
  const Log log = wall_clock_log(rig);
  expect_same(log, rig.n_commands);
  const auto result = result_of(log, 0);
  EXPECT_EQ(result.at("n_periods"), rig.n_periods);
  for (const char* none : {"n_gaps", "n_not_computed", "n_not_logged", "n_other", "n_damaged"}) {
    EXPECT_EQ(result.at(none), 0) << none;
  }
}

TEST_F(Replay, OneBitOfAWallClockRunIsNamedWhereverItIs) {
  LoggedRig rig;
  rig.steps(2500);
  const Log log = wall_clock_log(rig);
  expect_same(log, rig.n_commands);

  Log spoilt = log;
  std::int64_t seq = 0;
  change<command_t>(spoilt, channels::command, 2000, [&seq](command_t& c) {
    seq = c.seq;
    c.force[1] = next_to(c.force[1]);
  });
  auto result = result_of(spoilt, 4);
  EXPECT_EQ(result.at("n_different"), 1);
  EXPECT_EQ(result.at("first_difference").at("channel"), "SF_COMMAND");
  EXPECT_EQ(result.at("first_difference").at("seq"), seq);
  EXPECT_EQ(result.at("first_difference").at("leg"), "leg_2");

  spoilt = log;
  change<loop_records_t>(spoilt, channels::loop, 60, [](loop_records_t& batch) {
    batch.records[5].force[3] = next_to(batch.records[5].force[3]);
  });
  result = result_of(spoilt, 4);
  EXPECT_EQ(result.at("n_different"), 1);
  EXPECT_EQ(result.at("first_difference").at("channel"), "SF_LOOP");
  EXPECT_EQ(result.at("first_difference").at("period"), 60 * 32 + 5);
  EXPECT_EQ(result.at("first_difference").at("leg"), "leg_4");

  spoilt = log;
  change<loop_checkpoint_t>(spoilt, channels::checkpoint, 20, [](loop_checkpoint_t& checkpoint) {
    checkpoint.memory.back() = next_to(checkpoint.memory.back());
  });
  result = result_of(spoilt, 4);
  EXPECT_EQ(result.at("first_difference").at("channel"), "SF_CHECKPOINT");
  EXPECT_EQ(result.at("first_difference").at("period"), 2000);
  EXPECT_EQ(result.at("first_difference").at("field"), "memory");
}

/// What is lost on the way to the logger costs the periods up to the next checkpoint, no more.
TEST_F(Replay, GoesOnAtTheNextCheckpointAfterAGap) {
  LoggedRig rig;
  rig.steps(2500);
  Log log = wall_clock_log(rig);
  int n = 0;
  std::erase_if(log, [&n](const LoggedMessage& logged) {
    return logged.channel == channels::loop && n++ == 60;  // periods 1920 to 1951
  });
  const auto result = result_of(log, 0);
  EXPECT_EQ(result.at("n_gaps"), 1);
  EXPECT_EQ(result.at("n_not_computed"), 2000 - 1952);
  EXPECT_EQ(result.at("n_periods"), 2500 - (2000 - 1920));
  EXPECT_EQ(result.at("n_other"), 2000 - 1920);
}

TEST_F(Replay, ALogThatBeginsInTheMiddleBeginsAtItsFirstCheckpoint) {
  LoggedRig rig;
  rig.steps(2500);
  Log log = wall_clock_log(rig);
  int n = 0;
  std::erase_if(log, [&n](const LoggedMessage& logged) {
    return logged.channel == channels::checkpoint && n++ < 12;
  });
  const auto result = result_of(log, 0);
  EXPECT_EQ(result.at("n_not_computed"), 1200);
  EXPECT_EQ(result.at("n_periods"), 1300);
}

TEST_F(Replay, ControllersThatFollowEachOtherAreToldApart) {
  LoggedRig one({}, 31), two({}, 32), again({}, 32);  // a restart, then a plant that begins anew
  one.steps(900);
  two.steps(700);
  again.steps(800);
  Log log = wall_clock_log(one);
  for (LoggedRig* rig : {&two, &again}) {
    const Log more = rig->log();
    log.insert(log.end(), more.begin(), more.end());
  }
  const auto result = result_of(log, 0);
  EXPECT_EQ(result.at("n_periods"), 2400);
  EXPECT_EQ(result.at("n_gaps"), 0);
}

TEST_F(Replay, AFlightRecordIsReplayed) {
  controller::Policy policy;
  policy.record_s = 2;
  LoggedRig rig(policy);
  rig.steps(2500);
  rig.steps(1700, controller::toy::nothing);
  for (int i = 0; i < 3000 && !rig.rig().loop().flight().is_frozen(); ++i) rig.steps(1);
  ASSERT_TRUE(rig.rig().loop().flight().is_frozen());
  const auto file = folder_ / "flight.lcm";
  controller::write_flight_file(file, info_of(wall_clock_gains(), LoggedRig::run_id, "wall_clock"),
                                rig.rig().loop().flight(), "");
  const auto result = json({"replay", file});
  // All but what is older than the first checkpoint in it, less than 0.1 s.
  EXPECT_LT(result.at("n_not_computed"), 100);
  EXPECT_EQ(result.at("n_periods").get<int>() + result.at("n_not_computed").get<int>(), 2000);
  EXPECT_EQ(result.at("n_different"), 0);
}

TEST_F(Replay, ThePolicyMustBeTheControllers) {
  controller::Policy policy;
  policy.fade_s = 0.5;
  LoggedRig rig(policy);
  rig.steps(1800);
  rig.steps(300, controller::toy::nothing);
  const Log log = wall_clock_log(rig);
  const Said said = replay(log);
  EXPECT_EQ(said.exit_code, 4);
  const auto file = write("policy.yaml", "measurements: {fade_s: 0.5}\n");
  EXPECT_EQ(result_of(log, 0, {"--policy", file.string()}).at("n_periods"), 2100);
  // A log that says which policy it was needs none.
  LoggedRig telling(policy);
  telling.policy_text = "measurements: {fade_s: 0.5}\n";
  telling.steps(1800);
  telling.steps(300, controller::toy::nothing);
  EXPECT_EQ(result_of(wall_clock_log(telling), 0).at("n_periods"), 2100);
}

TEST_F(Replay, LogsThatCannotBeReplayedAreExitCode2) {
  expect_refused({"replay", folder_ / "none.lcm"}, 2, "there is no such LCM log");
  expect_refused({"replay", write("text.lcm", "no log at all\n")}, 2, "no SF_RUN_INFO");
  Log two = lock_step_log(10, 7);
  const Log other = lock_step_log(10, 8);
  two.insert(two.end(), other.begin(), other.end());
  expect_refused({"replay", log_file(two)}, 2,
                 "several runs in one log, name one by --run-id: 7, 8");
  EXPECT_EQ(result_of(two, 0, {"--run-id", "8"}).at("run_id"), "8");
  expect_refused({"replay", log_file(two), "--run-id", "9"}, 2, "found none with 9");
  Log bare;
  add(bare, channels::run_info, info_of(limited_gains(), 7, "wall_clock"));
  expect_refused({"replay", log_file(bare)}, 2, "no SF_LOOP message");
  LoggedRig rig;
  rig.steps(50);
  Log wrong = wall_clock_log(rig);
  change<loop_checkpoint_t>(wrong, channels::checkpoint, 0, [](loop_checkpoint_t& checkpoint) {
    checkpoint.memory.pop_back();
    --checkpoint.n;
  });
  expect_refused({"replay", log_file(wrong)}, 2, "the checkpoint before period 0 has");
  wrong = lock_step_log(10);
  change<run_info_t>(wrong, channels::run_info, 0, [](run_info_t& info) {
    info.n_legs = 6;
    info.leg_names.resize(6);
  });
  expect_refused({"replay", log_file(wrong)}, 2,
                 "SF_MEASUREMENT: found 4 legs, SF_RUN_INFO says 6");
}

}  // namespace
}  // namespace stillframe::test

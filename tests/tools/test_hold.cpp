#include <algorithm>
#include <cmath>
#include <iterator>
#include <random>
#include <tuple>

#include "controller/law.hpp"
#include "core/errors/input_error.hpp"
#include "judge/hold_of.hpp"
#include "judge/run_analysis.hpp"
#include "stillframe_msgs/controller_status_t.hpp"
#include "stillframe_msgs/measurement_t.hpp"
#include "tests/report/sample_log.hpp"
#include "tests/support/scratch_folder.hpp"
#include "tests/tools/replay_logs.hpp"
#include "tests/tools/verb.hpp"

namespace stillframe::test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using report::Takeover;
using stillframe_msgs::loop_record_t;
using stillframe_msgs::loop_records_t;
using stillframe_msgs::measurement_t;
using stillframe_msgs::run_info_t;

/// A wall-clock loop on a frame of which all that pushes it is known: noise that stays, a blow
/// while the frame is passive still, and a mean, which the loop takes for an offset of its sensors.
class TakingHold : public testing::Test {
 protected:
  double force(std::int64_t k) const {
    if (k < 0) return 0;
    return mean_ + noise_[static_cast<std::size_t>(k)] + (k >= 100 && k < 110 ? blow_ : 0);
  }

  /// What is read in n samples from 0 on, a row each.
  MatrixXd run(int n) {
    std::mt19937_64 random(5);
    std::normal_distribution<double> normal;
    double last = 0;
    for (int k = 0; k < n; ++k) noise_.push_back(last += 0.06 * (1e-3 * normal(random) - last));
    auto& rig = rig_.rig();
    rig.floor = [this](std::int64_t k, VectorXd& w) { w.setConstant(force(k)); };
    MatrixXd y = MatrixXd::Zero(n, plant_.C_y.rows());
    for (Index k = 0; k < n; ++k) {
      if (k > 0) y.row(k) = rig.y.transpose();
      rig_.steps(1);
      if (from_ < 0 && rig.state() == controller::State::ramp_in) from_ = k;
      if (full_ < 0 && rig.state() == controller::State::active) full_ = k;
    }
    EXPECT_EQ(rig.state(), controller::State::active);
    EXPECT_EQ(rig.loop().counters().n_saturated, 0);  // the model knows no limits
    return y;
  }

  Takeover takeover(const Log& log) const {
    write_log(folder_ / "run.lcm", log);
    return hold(log).takeover;
  }
  judge::Hold hold(const Log& log) const {
    write_log(folder_ / "run.lcm", log);
    return *judge::hold_of(folder_ / "run.lcm", info_of(gains_, LoggedRig::run_id, "wall_clock"));
  }

  /// Goes on into the ramp: the sample that it began in.
  static std::int64_t takes_hold(LoggedRig& rig, const controller::toy::Rig::Wire& wire = {}) {
    for (int k = 0; k < 3000 && rig.rig().state() != controller::State::ramp_in; ++k) {
      rig.steps(1, wire);
    }
    EXPECT_EQ(rig.rig().state(), controller::State::ramp_in);
    return rig.rig().k() - 1;
  }

  /// In blocks, as a log is read: one of them holds the end of the ramp.
  MatrixXd modelled(const std::optional<Takeover>& when, Index n) const {
    const DiscreteLaw law = law_from_gains(gains_);
    report::ForceModel model{close_loop(plant_, law), [this](std::int64_t k) {
                               return VectorXd(VectorXd::Constant(1, force(k)));
                             }};
    if (when) model.late = {*when, gain_loop(plant_, law)};
    report::ForceResponse response(std::move(model));
    MatrixXd y(n, plant_.C_y.rows());
    for (Index k = 0; k < n; k += 700) {
      const Index block = std::min<Index>(700, n - k);
      y.middleRows(k, block) = response.at(k, block);
    }
    return y;
  }

  test::ScratchFolder folder_;
  controller::Gains gains_ = wall_clock_gains();
  SampledPlant plant_ = sample_and_hold(gains_.loop_plant(), gains_.sampling());
  LoggedRig rig_;
  std::vector<double> noise_;
  double mean_ = 0, blow_ = 0;
  std::int64_t from_ = -1, full_ = -1;  ///< of the rig
};

constexpr int n_samples = 4000;
// Balanced states and products in another order over thousands of samples: 6e-15 was seen.
constexpr double rounding = 1e-12;

TEST_F(TakingHold, IsFollowedFromTheRecordsOfTheController) {
  blow_ = 0.02;
  const MatrixXd y = run(n_samples);
  const Takeover when = takeover(rig_.log());
  EXPECT_EQ(when.from, from_);
  EXPECT_EQ(when.full, full_);
  EXPECT_EQ(when.full - when.from, 1000);  // ramp.in_s
  EXPECT_LT((modelled(when, n_samples) - y).norm(), rounding * y.norm());
  // As if it had been closed from the beginning: what it was before, and most of the motion.
  EXPECT_GT((modelled({}, n_samples) - y).norm(), 0.5 * y.norm());
}

TEST_F(TakingHold, AForceThatStoodBeforeIsAnOffsetToTheLoop) {
  mean_ = 0.01;
  const MatrixXd y = run(n_samples);
  const Takeover when = takeover(rig_.log());
  ASSERT_EQ(when.offset, VectorXd::Ones(4));
  EXPECT_LT((modelled(when, n_samples) - y).norm(), rounding * y.norm());
  Takeover other = when;
  other.offset.setZero();
  // Most of y is the mean itself.
  EXPECT_GT((modelled(other, n_samples) - y).norm(), 0.05 * y.norm());
}

TEST_F(TakingHold, ThatNeverHappenedIsAPassiveFrame) {
  blow_ = 0.02;
  run(n_samples);
  Takeover never;
  never.offset.setZero(4);
  const SampledLoop open = open_loop(plant_);
  MatrixXd forces(n_samples, 1);
  for (Index k = 0; k < n_samples; ++k) forces(k, 0) = force(k - 1);
  const MatrixXd y = report::LoopResponse(open).follow(forces);
  EXPECT_LT((modelled(never, n_samples) - y).norm(), rounding * y.norm());
}

TEST_F(TakingHold, ThatWasGivenUpIsNone) {
  auto& rig = rig_.rig();
  rig_.steps(900);
  ASSERT_EQ(rig.state(), controller::State::ramp_in);
  rig.loop().request(controller::Request::stop);
  rig_.steps(600);
  ASSERT_EQ(rig.state(), controller::State::idle);
  rig.loop().request(controller::Request::start);
  std::int64_t from = 0;
  for (int k = 0; k < 2000 && rig.state() != controller::State::active; ++k) {
    rig_.steps(1);
    if (rig.state() == controller::State::arming) from = rig.k();
  }
  const Takeover when = takeover(rig_.log());
  EXPECT_EQ(when.from, from);
  EXPECT_EQ(when.full, from + 1000);
}

TEST_F(TakingHold, ThatAFaultHasEndedIsNone) {
  rig_.steps(900);
  ASSERT_EQ(rig_.rig().state(), controller::State::ramp_in);
  rig_.steps(1300, [](controller::Measurement& m) {
    m.sigma(1) = std::nan("");
    return true;
  });
  ASSERT_EQ(rig_.rig().state(), controller::State::fault);
  const Takeover given_up = takeover(rig_.log());
  EXPECT_EQ(given_up.from, given_up.never);
  EXPECT_EQ(given_up.full, given_up.never);
  rig_.rig().loop().request(controller::Request::reset);
  rig_.steps(10);
  rig_.rig().loop().request(controller::Request::start);
  const std::int64_t from = takes_hold(rig_);
  EXPECT_EQ(takeover(rig_.log()).from, from);
}

// The controller's arming begins anew with them, and so do the means of its sensors.
TEST_F(TakingHold, ListensAnewAfterMoreLostMeasurementsThanAreHeld) {
  for (const bool awake : {true, false}) {
    LoggedRig rig;
    rig.steps(100);
    rig.steps(10, controller::toy::nothing, awake);
    rig.steps(100);
    rig.steps(11, controller::toy::nothing, awake);
    const std::int64_t first = rig.rig().k();
    const std::int64_t from = takes_hold(rig);
    const Takeover when = takeover(rig.log());
    EXPECT_EQ(when.from, from) << awake;
    EXPECT_EQ(when.heard_from, first) << awake;
    EXPECT_EQ(when.heard_to, first + 495) << awake;  // 16 batches of 31 in arming.duration_s
  }
}

/// A controller with a policy file, which its checkpoints tell.
struct RigOfPolicy : LoggedRig {
  explicit RigOfPolicy(const std::string& text)
      : LoggedRig(controller::parse_policy(text, "policy", wall_clock_gains().sample_rate_hz)) {
    policy_text = text;
  }
};

TEST_F(TakingHold, IsFollowedByThePolicyThatTheControllerHad) {
  RigOfPolicy rig("arming: {duration_s: 0.3}\nramp: {in_s: 0.2}\n");
  const std::int64_t from = takes_hold(rig);
  // The log ends before the ramp does.
  const Takeover when = takeover(rig.log());
  EXPECT_EQ(when.from, from);
  EXPECT_EQ(when.full, from + 200);
  EXPECT_EQ(when.heard_to - when.heard_from + 1, 288);  // 16 batches of 18
}

// By a policy that was not the controller's, whose checkpoints were lost, one leg would have kept
// it from arming. Which of the others had an offset is then not known either.
TEST_F(TakingHold, HasNoOffsetsIfOneOfThemIsAFault) {
  RigOfPolicy rig("arming: {offset_limit_n: 100}\n");
  takes_hold(rig, [](controller::Measurement& m) {
    m.sigma += VectorXd{{20, 20, 70, 20}};
    return true;
  });
  Log log = rig.log();
  EXPECT_EQ(takeover(log).offset, VectorXd::Ones(4));
  std::erase_if(
      log, [](const LoggedMessage& message) { return message.channel == channels::checkpoint; });
  EXPECT_EQ(takeover(log).offset, VectorXd::Zero(4));
}

TEST_F(TakingHold, OfAnotherPlantDoesNotCount) {
  rig_.steps(2000);
  ASSERT_EQ(rig_.rig().state(), controller::State::active);
  LoggedRig later;
  later.steps(50, controller::toy::nothing);
  const std::int64_t from = takes_hold(later);
  Log log;
  measurement_t measurement{};
  measurement.run_id = LoggedRig::run_id;
  run_info_t info = info_of(gains_, LoggedRig::run_id, "wall_clock");
  for (LoggedRig* rig : {&rig_, &later}) {
    measurement.plant_instance = ++info.plant_instance;
    add(log, channels::measurement, measurement);
    std::ranges::copy(rig->log(), std::back_inserter(log));
  }
  write_log(folder_ / "run.lcm", log);
  EXPECT_EQ(judge::hold_of(folder_ / "run.lcm", info)->takeover.from, from);
}

/// How it ended, if it did, in a log of measurements up to the sample before `end`.
class LettingGo : public TakingHold {
 protected:
  judge::Hold held_by(LoggedRig& rig, std::int64_t end) const {
    Log log = rig.log();
    measurement_t measurement{};
    measurement.run_id = LoggedRig::run_id;
    measurement.seq = end - 1;
    add(log, channels::measurement, measurement);
    return hold(log);
  }
  static void nan(LoggedRig& rig, int n) {
    rig.steps(n, [](controller::Measurement& m) {
      m.sigma(1) = std::nan("");
      return true;
    });
  }
};

TEST_F(LettingGo, IsTheFirstSampleThatTheLoopDoesNotHold) {
  const struct {
    const char* what;
    std::function<void(LoggedRig&)> happens;
    std::string why;
    bool fault;
  } cases[] = {
      {"nothing", [](LoggedRig& rig) { rig.steps(1000); }, "", false},
      {"a fade", [](LoggedRig& rig) { rig.steps(40, controller::toy::nothing); }, "", false},
      {"a stop", [](LoggedRig& rig) { rig.rig().loop().request(controller::Request::stop); },
       "it was stopped", false},
      {"a sleep", [](LoggedRig& rig) { rig.steps(30, {}, false); },
       "its controller had the fault suspended", true},
      {"silence", [](LoggedRig& rig) { rig.steps(1500, controller::toy::nothing); },
       "its controller had the fault silence", true},
      {"no numbers", [](LoggedRig& rig) { nan(rig, 1500); },
       "its controller had the fault not_finite", true}};
  for (const auto& [what, happens, why, fault] : cases) {
    LoggedRig rig;
    takes_hold(rig);
    rig.steps(1500);
    ASSERT_EQ(rig.rig().state(), controller::State::active);
    const std::int64_t at = rig.rig().k();
    happens(rig);
    rig.steps(600);  // the toy meets its limit later
    const judge::Hold found = held_by(rig, rig.rig().k());
    EXPECT_EQ(found.until, why.empty() ? Takeover::never : at) << what;
    EXPECT_EQ(found.why, why) << what;
    EXPECT_EQ(found.fault, fault) << what;
    // What comes behind the last measurement ends nothing.
    EXPECT_EQ(held_by(rig, at).until, Takeover::never) << what;
  }
}

TEST_F(LettingGo, OfAControllerThatWasKilledIsWhereItsRecordsEnd) {
  LoggedRig rig;
  takes_hold(rig);
  rig.steps(1500);
  const std::int64_t end = rig.rig().k();
  EXPECT_EQ(held_by(rig, end + 900).until, Takeover::never);
  const judge::Hold found = held_by(rig, end + 1200);
  EXPECT_EQ(found.until, end);
  EXPECT_NE(found.why.find("records"), std::string::npos);
}

TEST_F(LettingGo, IsSaidOfALoopThatNeverHeld) {
  const auto why = [&](int n, const std::function<void(LoggedRig&)>& happens) {
    LoggedRig rig;
    rig.steps(n);
    happens(rig);
    const judge::Hold found = held_by(rig, 3000);
    EXPECT_FALSE(found.ever);
    EXPECT_EQ(found.fault, found.why.find("fault") != std::string::npos);
    return found.why;
  };
  const auto nothing = [](LoggedRig&) {};
  EXPECT_EQ(why(300, nothing), "its controller never ended arming");
  // Killed in its ramp: nobody knows that it would have ended.
  EXPECT_NE(why(900, nothing).find("did not come to its end"), std::string::npos);
  const auto broken = [](LoggedRig& rig) { nan(rig, 1500); };
  EXPECT_EQ(why(900, broken), "its controller had the fault not_finite");
  const auto broken_and_reset = [](LoggedRig& rig) {
    nan(rig, 1500);
    rig.rig().loop().request(controller::Request::reset);
    rig.steps(10);
  };
  EXPECT_EQ(why(900, broken_and_reset), "its controller had the fault not_finite");
}

TEST_F(TakingHold, IsNotKnownWithoutRecords) {
  run(n_samples);
  Log log = rig_.log();
  std::erase_if(log,
                [](const LoggedMessage& message) { return message.channel == channels::loop; });
  EXPECT_THROW(takeover(log), InputError);
  const auto of = [&](const std::string& mode) {
    return judge::hold_of(folder_ / "run.lcm", info_of(gains_, LoggedRig::run_id, mode));
  };
  EXPECT_FALSE(of("lock_step"));
  EXPECT_FALSE(of("single_process"));
}

class ByTheClock : public Verb {
 protected:
  /// A scene of one leg; motions: its floor and what else pushes it.
  std::filesystem::path on_a_table(int damping, const std::string& motions) const {
    return write("scene.yaml", R"(title: A mass on a shaking table
nodes: {table: {position: [0, 0, 0]}, mass: {position: [0, 0, 0.1]}}
masses: [{node: mass, mass: 10}]
elements: {leg: {type: truss, nodes: [table, mass], stiffness: 4e5, damping: )" +
                                   std::to_string(damping) + R"(}}
supports: [{nodes: [table, mass], fix: [x, y]}]
prescribed: [{nodes: [table], move: [z]}]
dofs: [{element: leg}]
inputs: [{name: table, acceleration: table, along: z}]
outputs: [{name: mass, acceleration: mass, along: z}]
monitors: [{name: tab, acceleration: table, along: z}]
compare: {z: {floor: tab, frame: mass}}
controller: {legs: [leg], target_hz: 5, damping_ratio: 0.7, sample_rate_hz: 1000, delay_samples: 1,
  lead_samples: 1.5, leak_hz: 0.05}
)" + motions);
  }

  /// The log of a passive run as one of an active loop by the clock whose controller has said
  /// `records`.
  std::filesystem::path said_to_be_active(const std::filesystem::path& log,
                                          const std::vector<loop_record_t>& records) const {
    Log messages;
    lcm::LogFile from(log.string(), "r");
    std::int64_t run_id = 0;
    while (const lcm::LogEvent* event = from.readNextEvent()) {
      const auto* bytes = static_cast<const std::uint8_t*>(event->data);
      if (run_info_t info; event->channel == channels::run_info) {
        EXPECT_GE(info.decode(bytes, 0, event->datalen), 0);
        info.mode = "wall_clock";
        info.loop = "active";
        run_id = info.run_id;
        add(messages, channels::run_info, info);
      } else {
        messages.push_back({event->channel, {bytes, bytes + event->datalen}});
      }
    }
    loop_records_t batch{};
    batch.run_id = run_id;
    batch.n_records = static_cast<std::int32_t>(records.size());
    batch.records = records;
    if (!records.empty()) add(messages, channels::loop, batch);
    write_log(folder_ / "edited.lcm", messages);
    return folder_ / "edited.lcm";
  }
};

// A controller that only listened has left the frame passive, and what a blow does to such a one is
// taken off.
TEST_F(ByTheClock, WhatForcesDoBeforeTheLoopTakesHoldIsThePassiveFramesDoing) {
  const auto scene =
      on_a_table(20, R"(floor: {noise: {psd: [[1, 1e-16], [100, 1e-16]], duration_s: 12}}
disturbances: [{name: blow, node: mass, along: z, force: {impact: {peak: 1, width_s: 0.02,
  at_s: 0.3}}}]
)");
  const auto out = folder_ / "run";
  run({"run", scene, "--mode", "single_process", "--loop", "passive", "--out", out});
  loop_record_t listening{};
  listening.n_legs = 1;
  listening.sigma = listening.applied = listening.force = {0};
  const auto forces_of = [&](const std::vector<loop_record_t>& records) {
    return judge::analyse_run(said_to_be_active(out / "passive.lcm", records)).data;
  };
  const report::LogAnalysis passive = forces_of({listening});
  EXPECT_EQ(passive.forces_unknown, "");
  const auto power = [](const report::Psd& psd) { return psd.density.sum(); };
  ASSERT_TRUE(passive.axes.at(0).forces);
  // A simulation errs by 3e-4 of its motion at most, 30 times its tolerance.
  EXPECT_LT(power(passive.axes[0].forces->undisturbed),
            3e-4 * 3e-4 * power(passive.axes[0].forces->by_forces));
  const report::LogAnalysis unknown = forces_of({});
  EXPECT_FALSE(unknown.axes.at(0).forces);
  EXPECT_NE(unknown.forces_unknown.find("records are missing"), std::string::npos)
      << unknown.forces_unknown;
}

/// Column of the frame's accelerations in a log, a number a sample.
VectorXd motion_in(const std::filesystem::path& log, const std::string& name) {
  lcm::LogFile from(log.string(), "r");
  std::vector<double> x;
  std::size_t column = 0;
  while (const lcm::LogEvent* event = from.readNextEvent()) {
    const auto* bytes = static_cast<const std::uint8_t*>(event->data);
    if (run_info_t info; event->channel == channels::run_info) {
      EXPECT_GE(info.decode(bytes, 0, event->datalen), 0);
      column = static_cast<std::size_t>(std::ranges::find(info.frame_names, name) -
                                        info.frame_names.begin());
    } else if (measurement_t m; event->channel == channels::measurement) {
      EXPECT_GE(m.decode(bytes, 0, event->datalen), 0);
      x.push_back(m.frame_acceleration.at(column));
    }
  }
  return VectorXd::Map(x.data(), std::ssize(x));
}

// A blow on the floor shakes a frame that nobody holds yet. Whatever it did there, the verdict is
// of what came after.
TEST_F(ByTheClock, MotionIsJudgedFromWhereTheLoopHoldsTheFrame) {
  const auto scene = on_a_table(200, R"(floor:
  sum:
    - noise: {psd: [[1, 1e-8], [100, 1e-8]], duration_s: 24}
    - impact: {input: table, peak: 0.5, width_s: 0.02, at_s: 0.7}
)");
  const auto out = folder_ / "run";
  run({"run", scene, "--mode", "single_process", "--loop", "both", "--out", out});
  using State = stillframe_msgs::controller_status_t;
  // A passive log as that of an active loop whose controller was in these states from these
  // samples on.
  const auto judged = [&](const std::vector<std::pair<std::int64_t, std::int32_t>>& states) {
    std::vector<loop_record_t> records;
    for (std::int64_t seq = 0; seq < 24'000; ++seq) {
      loop_record_t record{};
      record.n_legs = 1;
      record.sigma = record.applied = record.force = {0};
      record.seq = record.period = seq;
      for (const auto& [from, state] : states) {
        if (seq >= from) record.state = state;
        if (record.state == State::FAULT) record.fault = 1;
      }
      records.push_back(record);
    }
    const auto log = said_to_be_active(out / "passive.lcm", records);
    return nlohmann::json::parse(
        run({"report", log, "--out", folder_ / "page.html", "--json"}).output);
  };
  const VectorXd all = motion_in(out / "passive.lcm", "mass");
  const auto rms = [](const VectorXd& x) {
    return std::sqrt(x.squaredNorm() / static_cast<double>(x.size()));
  };
  const VectorXd held = all.tail(all.size() - 3000);
  ASSERT_GT(rms(all), 3 * rms(held));
  const auto active = judged({{0, State::ARMING}, {3000, State::ACTIVE}});
  EXPECT_EQ(active["runs"][0]["judged_from_s"], 3);
  EXPECT_EQ(active["runs"][0]["n_judged"], held.size());
  const auto& level = active["axes"][0]["active"];
  // Sums in another order.
  EXPECT_NEAR(level["whole_rms_m_s2"].get<double>(), rms(held), 1e-12 * rms(held));
  EXPECT_EQ(level["peak_m_s2"], held.cwiseAbs().maxCoeff());
  EXPECT_TRUE(active["shocks"].empty());
  // Stopped, it has done its work until then.
  const auto stopped =
      judged({{0, State::ARMING}, {3000, State::ACTIVE}, {15'000, State::RAMP_OUT}});
  EXPECT_EQ(stopped["runs"][0]["judged_to_s"], 15);
  EXPECT_EQ(stopped["runs"][0]["let_go"], "it was stopped");
  const VectorXd until = all.segment(3000, 12'000);
  EXPECT_NEAR(stopped["axes"][0]["active"]["whole_rms_m_s2"].get<double>(), rms(until),
              1e-12 * rms(until));
  const auto outcome_of_hold = [](const nlohmann::json& verdict) {
    for (const auto& check : verdict["checks"]) {
      if (check["what"] == "hold of the loop on the frame") return check["outcome"].dump();
    }
    return std::string("none");
  };
  EXPECT_EQ(outcome_of_hold(active), "none");
  EXPECT_EQ(outcome_of_hold(stopped), "\"passed\"");
  const auto broken = judged({{0, State::ARMING},
                              {3000, State::ACTIVE},
                              {15'000, State::FAULT},
                              {15'100, State::ARMING},
                              {16'000, State::ACTIVE}});
  EXPECT_EQ(broken["runs"][0]["judged_to_s"], 15);
  EXPECT_EQ(outcome_of_hold(broken), "\"failed\"");
  EXPECT_EQ(broken["outcome"], "failed");
  // One that listened to its end tells nothing of a loop, and one that had a fault before fails.
  const std::tuple<std::int32_t, const char*, const char*> never[] = {
      {State::ARMING, "not judged", "never ended arming"}, {State::FAULT, "failed", "the fault"}};
  for (const auto& [state, outcome, why] : never) {
    const auto verdict = judged({{0, state}});
    EXPECT_EQ(verdict["outcome"], outcome);
    EXPECT_NE(verdict["runs"][0]["never_held"].dump().find(why), std::string::npos);
    EXPECT_TRUE(verdict["runs"][0]["judged_from_s"].is_null());
    EXPECT_EQ(verdict["runs"][0]["n_judged"], 0);
    // The frame that moved is no active one, and nothing is identified of it.
    EXPECT_TRUE(verdict["axes"].empty());
    for (const auto& response : verdict["responses"]) EXPECT_EQ(response["n_compared"], 0);
    EXPECT_EQ(verdict["noise"][0]["share"], nullptr);
  }
}

}  // namespace
}  // namespace stillframe::test

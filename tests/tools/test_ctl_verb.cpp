#include <gtest/gtest.h>

#include <atomic>
#include <set>
#include <stop_token>
#include <thread>

#include "controller/policy.hpp"
#include "msgs/channels.hpp"
#include "msgs/clock.hpp"
#include "msgs/identity.hpp"
#include "msgs/lcm_bus.hpp"
#include "msgs/peer_clocks.hpp"
#include "stillframe_msgs/clock_exchange_t.hpp"
#include "stillframe_msgs/control_request_t.hpp"
#include "stillframe_msgs/controller_status_t.hpp"
#include "tests/tools/verb.hpp"

namespace stillframe::test {
namespace {

using stillframe_msgs::control_request_t;
using stillframe_msgs::controller_status_t;

/// A status in which no two numbers are the same.
controller_status_t some_status(std::int64_t run_id) {
  controller_status_t status{};
  status.run_id = run_id;
  status.instance = 1001;
  status.started_ns = 1002;
  status.pid = 1003;
  status.state = controller_status_t::FADING;
  status.fault = static_cast<std::int32_t>(controller::Fault::out_of_range);
  status.latched = 1;
  status.text = "fading: measurements beyond the limit";
  std::int64_t next = 2001;
  for (std::int64_t* counter :
       {&status.n_periods, &status.n_late, &status.n_lost, &status.n_duplicate, &status.n_missing,
        &status.n_saturated, &status.n_faults, &status.n_rejoins, &status.n_bad_messages,
        &status.n_commands_dropped, &status.n_records_dropped, &status.n_page_faults,
        &status.worst_wake_up_ns, &status.worst_compute_ns}) {
    *counter = next++;
  }
  return status;
}

/// A controller that says something of itself twenty times a second, and answers requests after
/// it has heard them so often.
class FakeController {
 public:
  FakeController(controller_status_t status, std::string answer, int deaf_to = 0)
      : lcm_(open_lcm(lcm_url(""))), status_(std::move(status)), answer_(std::move(answer)) {
    deaf_to_ = deaf_to;
    lcm_->subscribe(channels::request, &FakeController::on_request, this);
    thread_ = std::jthread([this](const std::stop_token& stop) {
      for (std::int64_t next = monotonic_ns(); !stop.stop_requested();) {
        handle_one(*lcm_, 10);
        if (monotonic_ns() < next) continue;
        say();
        next = monotonic_ns() + ns_per_s / 20;
      }
    });
  }

  /// Stops it, and answers what it was asked.
  const std::vector<control_request_t>& heard() {
    thread_.request_stop();
    if (thread_.joinable()) thread_.join();
    return heard_;
  }

 private:
  void say() {
    status_.sent_ns = monotonic_ns();
    lcm_->publish(channels::status, &status_);
  }
  void on_request(const lcm::ReceiveBuffer*, const std::string&, const control_request_t* request) {
    heard_.push_back(*request);
    if (request->run_id != 0 && request->run_id != status_.run_id) return;
    if (static_cast<int>(heard_.size()) <= deaf_to_) return;
    status_.nonce = request->nonce;
    status_.answer = answer_;
    say();  // as it takes it; what comes of it is said later
    if (answer_.empty()) status_.state = controller_status_t::RAMP_OUT;
  }

  std::unique_ptr<lcm::LCM> lcm_;
  controller_status_t status_;
  std::string answer_;
  int deaf_to_ = 0;
  std::vector<control_request_t> heard_;
  std::jthread thread_;
};

/// Answers for all processes of other hosts, whose clocks are ahead.
struct Host {
  lcm::LCM* lcm;
  std::set<std::int64_t> asked;

  static std::int64_t reads() { return monotonic_ns() + 40'000 * ns_per_s; }
  void on_clock(const lcm::ReceiveBuffer*, const std::string&,
                const stillframe_msgs::clock_exchange_t* message) {
    if (message->answered_ns != 0) return;
    asked.insert(message->asked);
    stillframe_msgs::clock_exchange_t answer = *message;
    answer.heard_ns = answer.answered_ns = reads();
    lcm->publish(channels::clock, &answer);
  }
};

class Ctl : public Verb {};

TEST_F(Ctl, StatusOnlyListens) {
  FakeController controller(some_status(7), "");
  const auto status = json({"ctl", "status", "--timeout", "60"});
  EXPECT_TRUE(controller.heard().empty());
  EXPECT_EQ(status.at("run_id"), "7");
  EXPECT_EQ(status.at("instance"), "1001");
  EXPECT_EQ(status.at("started_ns"), 1002);
  EXPECT_EQ(status.at("pid"), 1003);
  EXPECT_EQ(status.at("state"), "fading");
  EXPECT_EQ(status.at("fault"), "out_of_range");
  EXPECT_EQ(status.at("latched"), true);
  EXPECT_EQ(status.at("text"), "fading: measurements beyond the limit");
  EXPECT_EQ(status.at("answer"), "");
  std::int64_t next = 2001;
  for (const char* key : {"n_periods", "n_late", "n_lost", "n_duplicate", "n_missing",
                          "n_saturated", "n_faults", "n_rejoins", "n_bad_messages",
                          "n_commands_dropped", "n_records_dropped", "n_page_faults"}) {
    EXPECT_EQ(status.at(key), next++) << key;
  }
  for (const char* key : {"worst_wake_up_us", "worst_compute_us"}) {
    EXPECT_EQ(status.at(key), static_cast<double>(next++) / 1e3) << key;
  }
  EXPECT_EQ(status.size(), 23u);
  expect_documented_keys("ctl", status);
}

TEST_F(Ctl, TheTableHasEveryNumber) {
  FakeController controller(some_status(7), "");
  const Said said = run({"ctl", "status", "--timeout", "60"});
  EXPECT_EQ(said.exit_code, 0) << said.error;
  for (const char* part :
       {"run 7", "1003", "fading", "out_of_range", "latched", "beyond the limit", "2001", "2002",
        "2003", "2004", "2005", "2006", "2007", "2008", "2009", "2010", "2011", "2012", "2.0 us"}) {
    EXPECT_NE(said.output.find(part), std::string::npos) << part << " in\n" << said.output;
  }
}

TEST_F(Ctl, EachRequestIsSentByItsNumberUntilItIsTaken) {
  const std::vector<std::pair<std::string, std::int32_t>> requests{
      {"start", control_request_t::START},
      {"stop", control_request_t::STOP},
      {"reset", control_request_t::RESET}};
  std::set<std::int64_t> nonces;
  for (const auto& [action, number] : requests) {
    controller_status_t before = some_status(7);
    before.nonce = 5;  // of another asker
    before.answer = "what another asker was told";
    FakeController controller(before, "", 2);
    const auto status = json({"ctl", action, "--timeout", "60"});
    EXPECT_EQ(status.at("answer"), "");
    EXPECT_EQ(status.at("state"), "ramp_out");  // the state after it
    const auto& heard = controller.heard();
    ASSERT_GE(heard.size(), 3u) << action;  // the third is the first that is not lost on it
    for (const auto& request : heard) {
      EXPECT_EQ(request.request, number);
      EXPECT_EQ(request.run_id, 0);
      EXPECT_EQ(request.nonce, heard.front().nonce);
      EXPECT_EQ(request.asked_ns, heard.front().asked_ns);
      EXPECT_GE(request.sent_ns, request.asked_ns);
    }
    EXPECT_NE(heard.front().nonce, 0);
    nonces.insert(heard.front().nonce);
  }
  EXPECT_EQ(nonces.size(), 3u);
}

TEST_F(Ctl, ARefusalIsExitCode3WithTheReason) {
  FakeController controller(some_status(7), "a fault is latched: out_of_range");
  const Said said = run({"ctl", "start", "--timeout", "60"});
  EXPECT_EQ(said.exit_code, 3);
  EXPECT_NE(said.error.find("refused: a fault is latched: out_of_range"), std::string::npos)
      << said.error;
  EXPECT_NE(said.output.find("fading"), std::string::npos) << said.output;
}

/// What a controller says may be anybody's; on a terminal a control character is a command.
TEST_F(Ctl, NothingThatATerminalObeysIsPrinted) {
  controller_status_t status = some_status(7);
  status.text =
      "fading\033[2J\xc2\x9b"
      "1m\x9b\rover";
  FakeController controller(status, "no\033]0;title\007");
  const Said said = run({"ctl", "start", "--timeout", "60"});
  EXPECT_NE(said.output.find("fading\\x1b[2J\\xc2\\x9b1m\\x9b\\x0dover"), std::string::npos)
      << said.output;
  EXPECT_NE(said.error.find("refused: no\\x1b]0;title\\x07"), std::string::npos) << said.error;
}

/// A recording of a controller says all that a controller says, at other times.
TEST_F(Ctl, ARecordedControllerIsNone) {
  const auto lcm = open_lcm(lcm_url(""));
  const auto ctl = start({"ctl", "status", "--timeout", "1"});
  controller_status_t status = some_status(7);
  status.sent_ns = monotonic_ns() - fresh_ns;
  while (!ctl->wait(0.02)) lcm->publish(channels::status, &status);
  EXPECT_EQ(ctl->exit_code(), 4);
}

/// An old refusal is in the status of a controller that is asked for nothing.
TEST_F(Ctl, StatusDoesNotMindAnOldRefusal) {
  controller_status_t status = some_status(7);
  status.nonce = 5;
  status.answer = "a fault is latched";
  FakeController controller(status, "");
  EXPECT_EQ(json({"ctl", "status", "--timeout", "60"}).at("answer"), "a fault is latched");
}

TEST_F(Ctl, RunIdChoosesAmongControllers) {
  FakeController other(some_status(7), ""), wanted(some_status(8), "");
  EXPECT_EQ(json({"ctl", "status", "--run-id", "8", "--timeout", "60"}).at("run_id"), "8");
  EXPECT_EQ(json({"ctl", "stop", "--run-id", "8", "--timeout", "60"}).at("run_id"), "8");
  for (const auto& request : other.heard()) EXPECT_EQ(request.run_id, 8);
}

/// Controllers of more runs than there are places for clocks, all on another host, speak before the
/// one that is meant; and of them nobody is asked.
TEST_F(Ctl, ThoseThatAreNotMeantTakeNoPlace) {
  const auto lcm = open_lcm(lcm_url(""));
  require_hearing(*lcm);
  Host host{lcm.get()};
  lcm->subscribe(channels::clock, &Host::on_clock, &host);
  const auto say_all = [&] {
    for (std::int64_t run = 0; run <= 40; ++run) {
      controller_status_t status = some_status(run == 40 ? 8 : 100 + run);
      status.instance = (std::int64_t{2 + run} << bits_below_clock) + 1;
      status.sent_ns = Host::reads();
      lcm->publish(channels::status, &status);
      while (handle_one(*lcm, 2)) {
      }
    }
  };
  const auto ctl = start({"ctl", "status", "--run-id", "8", "--timeout", "10"});
  while (!ctl->wait(0.02)) say_all();
  EXPECT_EQ(ctl->exit_code(), 0);
  EXPECT_EQ(host.asked.size(), 1u);
  const auto other = start({"ctl", "status", "--run-id", "9", "--timeout", "1"});
  while (!other->wait(0.02)) say_all();
  EXPECT_EQ(other->exit_code(), 4);
  EXPECT_EQ(host.asked.size(), 1u);
}

TEST_F(Ctl, NobodyIsExitCode4) {
  expect_refused({"ctl", "status", "--timeout", "0.2"}, 4, "no controller heard within 0.2 s");
  FakeController controller(some_status(7), "", 1000000);
  expect_refused({"ctl", "stop", "--timeout", "1"}, 4,
                 "the controller of run 7 did not take the request within 1 s");
  for (const char* action : {"status", "stop"}) {
    expect_refused({"ctl", action, "--run-id", "9", "--timeout", "1"}, 4,
                   "no controller of run 9 heard within 1 s, only one of run 7");
  }
}

TEST_F(Ctl, BadUsageIsExitCode2) {
  EXPECT_EQ(run({"ctl"}).exit_code, 2);
  const Said said = run({"ctl", "halt"});
  EXPECT_EQ(said.exit_code, 2);
  EXPECT_NE(said.error.find("{start,stop,reset,status}"), std::string::npos) << said.error;
  EXPECT_EQ(run({"ctl", "status", "--timeout", "0"}).exit_code, 2);
  EXPECT_EQ(run({"ctl", "status", "--run-id", "-1"}).exit_code, 2);
  expect_refused({"ctl", "status", "--lcm-url", "nonsense://"}, 2, "LCM cannot be opened");
}

}  // namespace
}  // namespace stillframe::test

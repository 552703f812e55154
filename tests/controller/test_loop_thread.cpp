#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "controller/in_process_io.hpp"
#include "controller/loop_thread.hpp"
#include "core/numerics/worst.hpp"
#include "msgs/clock.hpp"
#include "tests/controller/toy_plant.hpp"

// The thread of the loop on the clock, with a frame that moves when the loop looks at it.
namespace stillframe::controller {
namespace {

constexpr std::int64_t hour_ns = 3600 * ns_per_s, period_ns = 1'000'000;

class ToyFrame : public Io {
 public:
  explicit ToyFrame(std::int64_t start_ns)
      : start_ns_(start_ns), q_(m, 1e-6), v_(m, 1e-5), last_force(Eigen::VectorXd::Zero(m)) {}

  bool receive(Measurement& measurement) noexcept override {
    const std::int64_t now = monotonic_ns(), newest = (now - start_ns_) / period_ns;
    if (now < start_ns_ || seq_ >= newest) return false;
    for (; seq_ < newest; ++seq_) {
      for (std::size_t i = 0; i < m; ++i) {
        toy::move(i, q_[i], v_[i], last_force(static_cast<Eigen::Index>(i)), 1e-3);
      }
    }
    measurement.seq = seq_;
    measurement.time_ns = seq_ * period_ns;
    measurement.received_ns = now;
    measurement.applied = last_force;
    for (std::size_t i = 0; i < m; ++i) {
      const auto leg = static_cast<Eigen::Index>(i);
      const double w = two_pi * toy::frequencies_hz()[i];
      measurement.sigma(leg) = w * w * q_[i] + last_force(leg);
    }
    return true;
  }
  void send(const Command& command) noexcept override {
    last_force = command.force;
    largest = worst_of(largest, worst_of(last_force));
  }

 private:
  static constexpr std::size_t m = 4;
  std::int64_t start_ns_, seq_ = -1;
  std::vector<double> q_, v_;

 public:
  Eigen::VectorXd last_force;  ///< N; to be read when the thread has ended
  double largest = 0;
};

class OnTheClock : public testing::Test {
 protected:
  /// With patience for a machine that is late: what is looked at is how it ends.
  static Policy quick() {
    Policy policy;
    policy.arming_s = policy.ramp_in_s = 0.1;
    policy.ramp_out_s = 0.3;
    policy.hold_periods = 100;
    policy.late_periods = 100;
    policy.realtime = Policy::Realtime::off;
    return policy;
  }

  Policy policy_ = quick();
  Gains gains_ = toy::gains(5, 1000, 1);
  std::int64_t now_ = monotonic_ns();
  ToyFrame frame_{now_};
  Loop loop_{frame_, Supervisor(gains_, policy_, true), policy_,
             LoopSetting{.sample_rate_hz = 1000, .start_ns = now_, .now_ns = now_}};
};

TEST_F(OnTheClock, AnExceptionLetsGoOfTheFrameBeforeItLeavesTheScope) {
  try {
    LoopThread thread(loop_, policy_, 1000);
    while (loop_.counters().n_active == 0) sleep_until(monotonic_ns() + period_ns);
    throw std::runtime_error("a file system");
  } catch (const std::runtime_error&) {
  }
  EXPECT_GT(frame_.largest, 0);
  EXPECT_EQ(frame_.last_force, Eigen::VectorXd::Zero(4));
  EXPECT_FALSE(loop_.counters().driving);
  EXPECT_EQ(loop_.counters().state, State::idle);
}

TEST_F(OnTheClock, EndLeavesTheLoopAsItIs) {
  LoopThread thread(loop_, policy_, 1000);
  while (loop_.counters().n_active == 0) sleep_until(monotonic_ns() + period_ns);
  thread.end();
  EXPECT_TRUE(loop_.counters().driving);
}

TEST(RunPeriodic, EndsThoughItsRunBeginsInAnHour) {
  const std::int64_t now = monotonic_ns();
  const Gains gains = toy::gains(5, 1000, 1);
  ToyFrame frame(now + hour_ns);
  Loop loop(frame, Supervisor(gains, {}, true), {},
            {.sample_rate_hz = 1000, .start_ns = now + hour_ns, .now_ns = now});
  Policy policy;
  policy.realtime = Policy::Realtime::off;
  { const LoopThread thread(loop, policy, 1000); }
  EXPECT_EQ(loop.counters().n_periods, 0);
}

/// A loop that drives its frame in an hour: its thread finds nothing to do, and what is looked at
/// is the clock of who waits for it.
class WhoWaits : public testing::Test {
 protected:
  WhoWaits() {
    Measurement m;
    Command command;
    m.sigma = m.applied = command.force = Eigen::VectorXd::Zero(4);
    for (; m.seq < 2000 && !loop_.counters().driving; ++m.seq) {
      m.time_ns = m.seq * period_ns;
      m.received_ns = start_ns_ + m.time_ns;
      m.sigma.setConstant(m.seq % 2 == 0 ? 1 : -1);  // alive
      io_.put(m);
      loop_.period(loop_.next_ns());
      while (io_.take(command)) m.applied = command.force;
    }
    EXPECT_TRUE(loop_.counters().driving);
  }

  /// At once. Times of the policy below zero stand for time that has passed: nobody sleeps here.
  bool gives_up(Policy policy, double rate_hz) {
    policy.realtime = Policy::Realtime::off;
    LoopThread thread(loop_, policy, rate_hz);
    thread.let_go();
    const bool has_let_go = thread.has_let_go();
    thread.end();
    return has_let_go;
  }

  Gains gains_ = toy::gains(5, 1000, 1);
  InProcessIo io_{4};
  std::int64_t start_ns_ = monotonic_ns() + hour_ns;
  Loop loop_{io_,
             Supervisor(gains_, {}, true),
             {},
             LoopSetting{.sample_rate_hz = 1000, .start_ns = start_ns_, .now_ns = start_ns_}};
};

// After half a second, or five periods if they are longer. What is not overdue yet is not for two
// seconds, however late the machine is.
TEST_F(WhoWaits, GivesUpARampThatIsOverdue) {
  const auto gives_up_after = [&](double seconds, double rate_hz) {
    Policy policy;
    policy.hold_periods = 1'000'000;  // it is not silent
    policy.ramp_out_s = -seconds;
    policy.fade_s = 0;
    return gives_up(policy, rate_hz);
  };
  EXPECT_TRUE(gives_up_after(0.6, 200));
  EXPECT_TRUE(gives_up_after(0.6, 20));
  EXPECT_FALSE(gives_up_after(3, 1));
  EXPECT_TRUE(gives_up_after(5.1, 1));
}

// One that holds nothing for a plant that is silent: between two measurements there is a second.
TEST_F(WhoWaits, HearsTwoPeriodsOfASlowLoop) {
  Policy policy;
  policy.hold_periods = -1;
  EXPECT_FALSE(gives_up(policy, 1));
}

}  // namespace
}  // namespace stillframe::controller

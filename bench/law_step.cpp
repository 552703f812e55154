// What a period costs beside its sockets: the control law, the law with its checks, the supervisor,
// and the whole period of the loop with its records, over an in-process Io. Every step is timed by
// itself; what the two looks at the clock take stands beside and is subtracted from nothing.
#include <sys/resource.h>

#include <future>
#include <random>

#include "bench/machine.hpp"
#include "bench/times.hpp"
#include "controller/answer.hpp"
#include "controller/in_process_io.hpp"
#include "controller/loop.hpp"
#include "controller/realtime.hpp"
#include "core/cli/command.hpp"
#include "msgs/clock.hpp"

namespace {

using namespace stillframe;
using namespace stillframe::controller;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Options {
  std::string gains;
  std::int64_t n_steps = 1'000'000, n_paced = 10'000;
  int priority = 49;
};

/// Forces like those of the run, made beforehand.
class Forces {
 public:
  explicit Forces(Index m) : values_(m, 4096) {
    std::mt19937_64 random(1);
    std::normal_distribution<double> noise;
    for (double& value : values_.reshaped()) value = noise(random);
  }
  auto operator()(std::int64_t k) const { return values_.col(k % values_.cols()); }

 private:
  MatrixXd values_;
};

std::int64_t page_faults() {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return usage.ru_minflt + usage.ru_majflt;
}

/// Runs a step so many times, back to back or (period_ns > 0) one a period, and prints one row.
template <class Before, class Step>
void row(const std::string& name, std::int64_t n, std::int64_t period_ns, const Before& before,
         const Step& step) {
  std::vector<std::int64_t> taken(static_cast<std::size_t>(n), 1);
  const std::int64_t start = monotonic_ns(), faults = page_faults();
  for (std::int64_t k = 0; k < n; ++k) {
    if (period_ns > 0) sleep_until(start + (k + 1) * period_ns);
    before(k);
    const std::int64_t begin = monotonic_ns();
    step(k);
    taken[static_cast<std::size_t>(k)] = monotonic_ns() - begin;
  }
  const std::int64_t n_faults = page_faults() - faults;
  Times all(taken.size());
  for (const std::int64_t ns : taken) all.add(ns);
  all.print_row(name + (n_faults > 0 ? " (" + std::to_string(n_faults) + " page faults)" : ""));
  std::fflush(stdout);
}

constexpr auto nothing = [](std::int64_t) {};

void law_row(const std::string& name, const Gains& gains, std::int64_t n, std::int64_t period_ns) {
  Law law(law_from_gains(gains));
  const Forces sigma(law.n_legs());
  const Forces floor(law.floor().n_floor());
  VectorXd s(law.n_legs()), w(law.floor().n_floor()), force = VectorXd::Zero(law.n_legs());
  row(
      name, n, period_ns,
      [&](std::int64_t k) {
        s = sigma(k);
        w = floor(k);
      },
      [&](std::int64_t) {
        law.hear_floor(1, w);
        law.step(s, force, force);
      });
}

/// Legs 1 and 12 from six: the first alone, or two frames side by side.
Gains with_legs(Gains gains, Index m) {
  const auto part = [m](const MatrixXd& K) {
    MatrixXd out = MatrixXd::Zero(m, m);
    const Index n = std::min<Index>(m, K.rows());
    for (Index i = 0; i + n <= m; i += n) out.block(i, i, n, n) = K.topLeftCorner(n, n);
    return out;
  };
  gains.K_P = part(gains.K_P);
  gains.K_I = part(gains.K_I);
  gains.legs.assign(static_cast<std::size_t>(m), "leg");
  return gains;
}

/// The PI that a law of one's own is held against, in its place.
Gains plain(Gains gains) {
  gains.feed_forward = {};
  gains.law.reset();
  gains.lead_samples = 0;
  gains.roll_off_hz.reset();
  return gains;
}

void law_rows(const Gains& gains, std::int64_t n, std::int64_t period_ns) {
  Gains lead = plain(gains), roll_off = plain(gains), both;
  lead.lead_samples = 1.5;
  roll_off.roll_off_hz = 200;
  both = lead;
  both.roll_off_hz = 200;
  law_row("law, 6 legs", plain(gains), n, period_ns);
  law_row("law, 6 legs, lead", lead, n, period_ns);
  law_row("law, 6 legs, roll-off", roll_off, n, period_ns);
  law_row("law, 6 legs, lead and roll-off", both, n, period_ns);
  if (gains.law || !gains.feed_forward.filter.empty()) {
    law_row("law of the file, with its feed-forward", gains, n, period_ns);
  }
  law_row("law, 1 leg, lead and roll-off", with_legs(both, 1), n, period_ns);
  law_row("law, 12 legs, lead and roll-off", with_legs(both, 12), n, period_ns);
}

void answer_row(const Gains& gains, std::int64_t n, std::int64_t period_ns) {
  Answer answer(law_from_gains(gains), gains.force_limit_n, true);
  const Forces sigma(gains.n_legs());
  stillframe_msgs::measurement_t measurement{};
  stillframe_msgs::command_t command{};
  answer.prepare(command);
  measurement.n_legs = command.n_legs;
  measurement.sigma.resize(command.force.size());
  measurement.applied_force.resize(command.force.size());
  measurement.floor_acceleration.resize(gains.feed_forward.floor.size());
  row(
      "lock-step answer, gains of the file", n, period_ns,
      [&](std::int64_t k) {
        measurement.seq = k;
        for (Index i = 0; i < gains.n_legs(); ++i) {
          measurement.sigma[static_cast<std::size_t>(i)] = sigma(k)(i);
        }
        measurement.applied_force = command.force;
      },
      [&](std::int64_t) { answer.answer(measurement, command); });
}

/// The loop with a plant that is only noise; its time is made up, so that nothing waits.
class Period {
 public:
  explicit Period(const Gains& gains)
      : T_ns_(static_cast<std::int64_t>(1e9 / gains.sample_rate_hz)),
        sigma_(gains.n_legs()),
        floor_(gains.plant.B_w.cols()),
        io_(gains.n_legs(), 64, gains.plant.B_w.cols()),
        supervisor_(gains, policy_, true),
        loop_(io_, supervisor_, policy_,
              {.sample_rate_hz = gains.sample_rate_hz,
               .phase = 0.5,
               .n_floor = gains.plant.B_w.cols()}) {
    measurement_.sigma = measurement_.applied = command_.force = VectorXd::Zero(gains.n_legs());
  }
  void before(std::int64_t) {
    while (loop_.records().oldest() != nullptr) loop_.records().pop();
    while (loop_.checkpoints().oldest() != nullptr) loop_.checkpoints().pop();
    while (io_.take(command_)) measurement_.applied = command_.force;
    measurement_.seq = loop_.next_ns() / T_ns_;
    measurement_.time_ns = measurement_.received_ns = measurement_.seq * T_ns_;
    measurement_.sigma = sigma_(measurement_.seq);
    // m/s^2; of a larger one the made-up forces would say that it is none.
    measurement_.floor = 1e-6 * floor_(measurement_.seq);
    io_.put(measurement_);
  }
  void step() { loop_.period(loop_.next_ns()); }
  bool is_active() const { return loop_.counters().state == State::active; }
  std::int64_t n_answered() const { return loop_.counters().n_answered; }

 private:
  // The forces are made up, and no loop's: without room they would be a fault.
  Policy policy_{.limited_part = 1, .free_rate_n_per_s = 1e12};
  std::int64_t T_ns_;
  Forces sigma_, floor_;
  InProcessIo io_;
  Supervisor supervisor_;
  Loop loop_;
  Measurement measurement_;
  Command command_;
};

void period_row(const Gains& gains, std::int64_t n, std::int64_t period_ns) {
  Period period(gains);
  // To the active state, and until the feed-forward has come in.
  for (std::int64_t k = 0; k < 5 * gains.sample_rate_hz; ++k) {
    period.before(k);
    period.step();
  }
  const std::int64_t answered = period.n_answered();
  row(
      "whole period, gains of the file", n, period_ns, [&](std::int64_t k) { period.before(k); },
      [&](std::int64_t) { period.step(); });
  if (!period.is_active() || period.n_answered() - answered != n) {
    std::printf("  (not every period was an active one)\n");
  }
}

void rows(const Gains& gains, std::int64_t n, std::int64_t period_ns) {
  row("nothing: the clock itself", n, period_ns, nothing, nothing);
  law_rows(gains, n, period_ns);
  answer_row(gains, n, period_ns);
  period_row(gains, n, period_ns);
}

void run(const Options& options, const RealtimeReport& report) {
  use_fifo(options.priority);
  const Gains gains = read_gains(options.gains);
  std::printf("%s\n%s\n", machine_line(STILLFRAME_FLAGS).c_str(), report.text.c_str());
  Times::print_head("back to back");
  rows(gains, options.n_steps, 0);
  Times::print_head("one a millisecond, the processor idle between");
  rows(gains, options.n_paced, 1'000'000);
}

}  // namespace

int main(int argc, char** argv) try {
  Options options;
  cli::Command app("Time of the control law and of a whole period of the loop.");
  app.option("gains", options.gains, "gains file of six legs").required();
  app.option("--steps", options.n_steps, "back to back");
  app.option("--paced", options.n_paced, "at 1 kHz");
  app.option("--priority", options.priority, "SCHED_FIFO, 0: ordinary");
  if (const auto code = app.parse(argc, argv)) return *code;
  Policy policy;
  policy.priority = options.priority;
  const RealtimeReport report = prepare_process(policy);
  std::async(std::launch::async, [&] { run(options, report); }).get();
} catch (const std::exception& error) {
  std::fprintf(stderr, "bench_law_step: %s\n", error.what());
  return 4;
}

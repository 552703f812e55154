#include "tests/faults/kinds.hpp"

#include <csignal>
#include <stdexcept>

#include "msgs/clock.hpp"
#include "tests/faults/busy_threads.hpp"

namespace stillframe::faults {

namespace {

constexpr std::int64_t n_samples = 400;        // of a fault: well beyond hold and gap limits
constexpr std::int64_t n_samples_long = 1300;  // beyond hold and fade
constexpr double stopped_s = 0.4;              // of a process that takes no samples

/// A fault on the wire, the same in every episode.
std::function<void(Stage&)> on_the_wire(Fault fault, std::int64_t n = n_samples) {
  return [fault, n](Stage& stage) {
    stage.rig.relay().inflict(fault, stage.seed, n);
    stage.rig.wait_samples(n);
  };
}

std::function<void(Stage&)> both_ways(const Disturbance& disturbance) {
  return on_the_wire({.measurements = disturbance, .commands = disturbance});
}

/// Wrong values in one leg, another in every episode.
std::function<void(Stage&)> corrupted(Corruption corruption, std::int64_t n = n_samples) {
  return [corruption, n](Stage& stage) {
    Fault fault{.measurements = {}, .commands = {}, .corruption = corruption};
    fault.leg = static_cast<std::int32_t>(stage.whole_between(0, 5));
    on_the_wire(fault, n)(stage);
  };
}

/// One way only: the controller hears the frame, and the frame does not hear the controller.
std::function<void(Stage&)> commands_lost(std::int64_t n) {
  return on_the_wire({.measurements = {}, .commands = {.loss = 1}}, n);
}

void delay(Stage& stage) {
  const Disturbance late{.delay_periods = stage.between(1, 5)};
  on_the_wire({.measurements = late, .commands = late})(stage);
}

void jitter(Stage& stage) {
  const Disturbance late{.jitter_periods = stage.between(1, 5)};
  on_the_wire({.measurements = late, .commands = late})(stage);
}

/// The time itself is what is inflicted: nothing comes meanwhile that could be waited for.
void let_pass(double seconds) {
  sleep_until(monotonic_ns() + static_cast<std::int64_t>(seconds * ns_per_s));
}

void stop_plant(Stage& stage) {
  stage.rig.plant().suspend();
  let_pass(stopped_s);
  stage.rig.plant().signal(SIGCONT);
}

void stop_controller(Stage& stage) {
  stage.rig.controller().suspend();
  let_pass(stopped_s);
  stage.rig.controller().signal(SIGCONT);
}

void kill_plant(Stage& stage) {
  stage.rig.plant().kill();
  let_pass(stage.between(0, stopped_s));
  stage.rig.start_plant();
}

void kill_controller(Stage& stage) {
  stage.rig.controller().kill();
  let_pass(stage.between(0, stopped_s));
  stage.rig.start_controller();
}

void second_controller(Stage& stage) {
  const auto second = stage.rig.another_controller();
  const auto code = second->wait(20);
  if (code == 3) return;
  throw std::runtime_error("a second controller ended with " +
                           (code ? std::to_string(*code) : "nothing within 20 s") +
                           ", and not with 3\n" + second->said());
}

void overload(Stage& stage) {
  // The loop's own priority: whoever has the processor keeps it.
  BusyThreads busy(49, [&stage] { return stage.between(0.002, 0.03); });
  stage.rig.wait_samples(n_samples);
}

void hogs(Stage& stage) {
  BusyThreads busy({}, [] { return 0.1; });
  stage.rig.wait_samples(n_samples);
}

void nothing_wrong(Stage& stage) { stage.rig.wait_samples(n_samples); }

const std::vector<std::string> unmoved{"active"};
const std::vector<std::string> ridden_out{"active", "resumed"};
const std::vector<std::string> silent{"silence"};
const std::vector<std::string> passing{"active", "resumed", "silence", "losses", "suspended"};

}  // namespace

std::vector<Kind> wire_kinds() {
  std::vector<Kind> kinds;
  using enum Counted;
  kinds.push_back({"no fault", unmoved, nothing_wrong, measurements_lost});
  // Ten losses in a row within 400 samples: once in 1e17 episodes at 1 %, in 3e7 at 10 %; at 50 %
  // in one of six.
  kinds.push_back({"loss 1 %", unmoved, both_ways({.loss = 0.01}), measurements_lost});
  kinds.push_back({"loss 10 %", unmoved, both_ways({.loss = 0.1}), measurements_lost});
  kinds.push_back({"loss 50 %", ridden_out, both_ways({.loss = 0.5}), measurements_lost});
  kinds.push_back({"bursts of 20 lost", ridden_out, both_ways({.burst = 0.01, .burst_length = 20}),
                   measurements_lost});
  kinds.push_back({"all commands lost 0.4 s", {"unheard"}, commands_lost(n_samples)});
  kinds.push_back({"all commands lost 1.3 s", {"unheard"}, commands_lost(n_samples_long)});
  kinds.push_back(
      {.name = "delay 1 to 5 periods", .allowed = silent, .inflict = delay, .delays = true});
  // Up to half a period is in time, so some get through at any jitter.
  kinds.push_back({.name = "jitter up to 5 periods",
                   .allowed = {"active", "resumed", "silence"},
                   .inflict = jitter,
                   .delays = true});
  kinds.push_back({"30 % twice", unmoved, both_ways({.duplication = 0.3}), duplicates});
  kinds.push_back({"30 % out of order", unmoved, both_ways({.reordering = 0.3}), duplicates});
  return kinds;
}

std::vector<Kind> process_kinds() {
  std::vector<Kind> kinds;
  kinds.push_back({.name = "plant stopped 0.4 s",
                   .allowed = silent,
                   .inflict = stop_plant,
                   .stops_time = true});
  kinds.push_back({.name = "controller stopped 0.4 s",
                   .allowed = {"suspended"},
                   .inflict = stop_controller,
                   .stops_time = true});
  kinds.push_back({.name = "plant killed, restarted",
                   .allowed = {"silence", "joined"},
                   .inflict = kill_plant,
                   .plant_restarts = true,
                   .stops_time = true});
  kinds.push_back({.name = "controller killed, restarted",
                   .allowed = {"joined"},
                   .inflict = kill_controller,
                   .controller_restarts = true,
                   .stops_time = true});
  kinds.push_back({.name = "second controller", .allowed = unmoved, .inflict = second_controller});
  kinds.push_back({.name = "overload at the loop's priority",
                   .allowed = passing,
                   .inflict = overload,
                   .alone = true});
  kinds.push_back({.name = "processor hogs", .allowed = passing, .inflict = hogs, .alone = true});
  kinds.push_back({.name = "clock stepped by an hour",
                   .allowed = unmoved,
                   .inflict = nothing_wrong,
                   .controller_prefix = {"env", std::string("LD_PRELOAD=") + CLOCK_STEPS}});
  return kinds;
}

std::vector<Kind> corruption_kinds() {
  std::vector<Kind> kinds;
  using enum Corruption;
  kinds.push_back({"wrong size", silent, corrupted(wrong_size), Counted::messages_bad});
  kinds.push_back({"truncated", silent, corrupted(truncated), Counted::messages_bad});
  kinds.push_back({"of another run, beside", unmoved, corrupted(other_run), Counted::messages_bad});
  kinds.push_back({"replayed, beside", unmoved, corrupted(replayed), Counted::duplicates});
  kinds.push_back({"of a later sample, beside", unmoved, corrupted(later), Counted::duplicates});
  kinds.push_back({"not finite 0.4 s", silent, corrupted(not_finite)});
  kinds.push_back(
      {"not finite 1.3 s", {"not_finite, latched"}, corrupted(not_finite, n_samples_long)});
  kinds.push_back({"out of range 0.4 s", silent, corrupted(out_of_range)});
  kinds.push_back(
      {"out of range 1.3 s", {"out_of_range, latched"}, corrupted(out_of_range, n_samples_long)});
  // Of a sensor that lies the law makes something until it is found: the tenth that is the rule for
  // what breaks.
  kinds.push_back({.name = "one sensor frozen",
                   .allowed = {"restless, latched"},
                   .inflict = corrupted(frozen),
                   .at_most = 1.1});
  return kinds;
}

std::vector<Kind> all_kinds() {
  std::vector<Kind> kinds = wire_kinds();
  for (const auto& more : {corruption_kinds(), process_kinds()}) {
    kinds.insert(kinds.end(), more.begin(), more.end());
  }
  return kinds;
}

}  // namespace stillframe::faults

#include "plant_sim/run_plant.hpp"

#include <algorithm>
#include <cmath>

#include "msgs/clock.hpp"
#include "msgs/stop_signal.hpp"
#include "plant_sim/amplifier.hpp"
#include "plant_sim/command_queue.hpp"

namespace stillframe {

using namespace stillframe_msgs;

namespace {

constexpr std::int64_t ns_per_ms = 1'000'000;
constexpr std::int64_t announce_every_ns = 500 * ns_per_ms;
constexpr const char* unwritten = "the logger does not write what it is sent";

/// What both ways of running share: counters, progress, the messages at both ends.
class Run {
 public:
  Run(Plant& plant, PlantLink& link, const PlantRunOptions& options)
      : plant_(plant),
        link_(link),
        options_(options),
        queue_(link.info().n_legs, link.info().delay_samples),
        n_(link.info().n_samples) {
    timing_.run_id = link.info().run_id;
    timing_.source = "plant";
  }

  void begin(std::int64_t start_ns) {
    // Without it a controller would never learn t_0; in lock-step the first measurement says as
    // much.
    announce(start_ns);
    if (start_ns > 0) link_.publish_state(run_state_t::RUNNING, start_ns, "");
    began_ns_ = monotonic_ns();
  }

  /// A run_info counts only with somebody behind it, and who follows it waits for the start.
  void announce(std::int64_t start_ns) {
    link_.publish_state(run_state_t::RUNNING, start_ns, "");
    link_.publish_info();
    link_.publish_state(run_state_t::RUNNING, start_ns, "");
  }

  void measure(std::int64_t k) {
    link_.publish_measurement(k, plant_.read());
    ++timing_.n_periods;
    const std::int64_t now = monotonic_ns();
    if (options_.progress && now - reported_ns_ > 200 * ns_per_ms) {
      reported_ns_ = now;
      options_.progress(k, n_);
    }
  }

  CommandQueue& queue() { return queue_; }

  /// Moves on by one sample with the commands that act in it. Answers the reason why the motion
  /// cannot go on, or an empty text.
  std::string advance() {
    const std::int64_t before = monotonic_ns();
    std::string reason = plant_.advance(queue_.before(), queue_.after(), queue_.fraction());
    timing_.worst_compute_ns = std::max(timing_.worst_compute_ns, monotonic_ns() - before);
    return reason;
  }

  PlantOutcome end() {
    timing_.wall_time_ns = monotonic_ns() - began_ns_;
    timing_.n_duplicate = link_.n_duplicate();
    timing_.n_foreign = link_.n_foreign();
    if (options_.progress) options_.progress(n_, n_);
    link_.publish_state(run_state_t::ENDED, 0, "");
    link_.publish_timing(timing_);
    return {.ended = true, .reason = ""};
  }

  PlantOutcome fail(const std::string& reason) {
    link_.publish_state(run_state_t::FAILED, 0, reason);
    return {.ended = false, .reason = reason};
  }

  timing_t& timing() { return timing_; }
  std::int64_t n() const { return n_; }

 private:
  Plant& plant_;
  PlantLink& link_;
  const PlantRunOptions& options_;
  CommandQueue queue_;
  std::int64_t n_;
  timing_t timing_{};
  std::int64_t began_ns_ = 0, reported_ns_ = 0;
};

/// Waits until the command for sample k has come; answers why it will not.
std::string await_command(PlantLink& link, std::int64_t k, double timeout_s) {
  const std::int64_t begin = monotonic_ns();
  std::int64_t asked = begin;
  while (link.command_seq() < k) {
    link.listen(50);
    link.take_commands(k);
    if (stop_requested()) return "interrupted";
    if (!link.controller_failure().empty()) return link.controller_failure();
    const std::int64_t now = monotonic_ns();
    if (static_cast<double>(now - begin) > timeout_s * 1e9) {
      return "no command for sample " + std::to_string(k) + " within " + std::to_string(timeout_s) +
             " s";
    }
    if (now - asked > 200 * ns_per_ms) {
      link.free_seat();
      link.repeat_measurement();
      asked = now;
    }
  }
  return "";
}

}  // namespace

std::string await_controller(PlantLink& link, double timeout_s) {
  const std::int64_t begin = monotonic_ns();
  while (!link.controller_ready()) {
    link.publish_state(run_state_t::WAITING, 0, "");
    link.publish_info();
    const std::int64_t asked = monotonic_ns();
    while (!link.controller_ready() && monotonic_ns() - asked < 50 * ns_per_ms) {
      link.listen(10);
      if (stop_requested()) return "interrupted";
      if (!link.controller_failure().empty()) return link.controller_failure();
      if (!link.rival().empty()) return link.rival();
    }
    if (static_cast<double>(monotonic_ns() - begin) > timeout_s * 1e9) {
      return "no controller answered within " + std::to_string(timeout_s) +
             " s; start one with: stillframe-controller --gains FILE" + link.unanswered();
    }
  }
  return "";
}

PlantOutcome run_lock_step(Plant& plant, PlantLink& link, const PlantRunOptions& options) {
  Run run(plant, link, options);
  const bool answer_first = run.queue().needs_answer();
  link.go_direct();
  run.begin(0);
  if (!link.begin_pacing()) return run.fail(stop_requested() ? "interrupted" : unwritten);
  for (std::int64_t k = 0; k < run.n(); ++k) {
    if (!link.wait_for_log()) return run.fail(stop_requested() ? "interrupted" : unwritten);
    run.measure(k);
    std::string reason;
    if (!answer_first) reason = run.advance();
    const std::string missing = await_command(link, k, options.timeout_s);
    if (!missing.empty()) return run.fail(missing);
    run.queue().push(link.command_force());
    if (answer_first) reason = run.advance();
    if (!reason.empty()) return run.fail(reason);
  }
  return run.end();
}

PlantOutcome run_wall_clock(Plant& plant, PlantLink& link, const PlantRunOptions& options) {
  Run run(plant, link, options);
  const double period_ns = 1e9 / link.info().sample_rate_hz;
  const Amplifier amplifier(options.amplifier_hold_samples, options.amplifier_fade_s,
                            1 / link.info().sample_rate_hz);
  // Both processes get time to settle before the first deadline.
  const std::int64_t start = monotonic_ns() + 100 * ns_per_ms;
  link.set_clock(start, period_ns);
  run.begin(start);
  std::int64_t heard_ns = start, announced_ns = start, n_heard = 0;
  for (std::int64_t k = 0; k < run.n(); ++k) {
    const std::int64_t deadline = start + std::llround(static_cast<double>(k) * period_ns);
    sleep_until(deadline);
    const std::int64_t now = monotonic_ns();
    link.refuse_after(static_cast<std::int64_t>(static_cast<double>(now - start) / period_ns) + 1);
    while (link.listen(0)) {
    }
    if (stop_requested()) return run.fail("interrupted");
    if (!link.controller_failure().empty()) return run.fail(link.controller_failure());
    if (!link.rival().empty()) return run.fail(link.rival());
    run.timing().worst_wake_up_ns = std::max(run.timing().worst_wake_up_ns, now - deadline);
    if (static_cast<double>(now - deadline) > period_ns) ++run.timing().n_late;
    link.take_commands(k - 1);
    const std::int64_t n_missing = k - 1 - link.command_seq();
    if (n_missing > options.amplifier_hold_samples) link.free_seat();
    if (link.n_commands() > 0 && n_missing > 0) ++run.timing().n_lost;
    if (link.n_commands() != n_heard) heard_ns = now;
    n_heard = link.n_commands();
    if (static_cast<double>(now - heard_ns) > options.timeout_s * 1e9) {
      return run.fail("no command for " + std::to_string(options.timeout_s) +
                      " s; the plant itself " + "was late by a period or more in " +
                      std::to_string(run.timing().n_late) + " of " + std::to_string(k) +
                      " samples" + link.unanswered());
    }
    // For a controller that comes, or comes back, while the run goes on.
    if (now - announced_ns > announce_every_ns) {
      announced_ns = now;
      run.announce(start);
    }
    run.measure(k);
    // What came in time stands for the command of the sample before.
    run.queue().push(amplifier.part(n_missing) * link.command_force());
    const std::string reason = run.advance();
    if (!reason.empty()) return run.fail(reason);
  }
  return run.end();
}

}  // namespace stillframe

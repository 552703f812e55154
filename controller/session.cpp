#include "controller/session.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include "controller/flight_file.hpp"
#include "controller/flight_folder.hpp"
#include "controller/law.hpp"
#include "msgs/clock.hpp"
#include "msgs/stop_signal.hpp"

namespace stillframe::controller {

using stillframe_msgs::run_state_t;

namespace {

constexpr int look_ms = 10;        // between looks at the loop
constexpr int most_messages = 64;  // between two looks at it
constexpr std::int64_t status_every_ns = 100'000'000, lost_after_ns = 1'000'000'000;
constexpr std::int64_t asleep_ns = 50'000'000;  // no other could begin in that time
constexpr double silent_samples = 3;            // in a row, of a plant that is there
// A controller that comes to a run which has gone on for longer than this was not there before.
constexpr std::int64_t joined_after_ns = 500'000'000;
constexpr std::int64_t announce_every_ns = 500'000'000;

LoopSetting setting_of(const Gains& gains, double phase, const Start& start,
                       const ControllerLink& link) {
  const std::int64_t start_ns = start.start_ns;
  const std::int64_t now = monotonic_ns();
  const auto samples = static_cast<double>(now - start_ns) * 1e-9 * gains.sample_rate_hz;
  return {.sample_rate_hz = gains.sample_rate_hz,
          .phase = phase,
          .start_ns = start_ns,
          .now_ns = now,
          .first_seq = now - start_ns > joined_after_ns ? std::llround(samples) : 0,
          .n_floor = link.run_info().n_floor,
          .n_frame = link.run_info().n_frame,
          .pacing = link.hosts()          ? Pacing::card
                    : link.is_elsewhere() ? Pacing::other_host
                                          : Pacing::same_clock,
          .start_doubt_ns = start.start_doubt_ns};
}

Supervisor supervisor_of(const Gains& gains, const Policy& policy, bool active,
                         const Latch& latch) {
  Supervisor supervisor(gains, policy, active);
  if (latch.fault() == Fault::none) return supervisor;
  const auto leg = std::ranges::find(gains.legs, latch.leg());
  supervisor.begin_latched(latch.fault(), leg == gains.legs.end() ? -1 : leg - gains.legs.begin());
  return supervisor;
}

}  // namespace

Session::Session(Io& io, ControllerLink& link, const Gains& gains, const Policy& policy,
                 const Presence& presence, Latch& latch, Background& disk,
                 const SessionOptions& options, const Start& start)
    : io_(io),
      link_(link),
      policy_(policy),
      presence_(presence),
      latch_(latch),
      disk_(disk),
      options_(options),
      start_ns_(start.start_ns),
      plant_start_ns_(link.hosts() ? start.start_ns : link.plant_state().start_monotonic_ns),
      sample_rate_hz_(gains.sample_rate_hz),
      loop_(io, supervisor_of(gains, policy, link.run_info().loop != "passive", latch), policy,
            setting_of(gains, options.phase, start, link)),
      telemetry_(link, loop_, io, presence, options.policy_text),
      told_latched_(latch.fault() != Fault::none),
      alive_ns_(monotonic_ns()) {}

Outcome Session::run() {
  bound_samples();
  LoopThread thread(loop_, policy_, sample_rate_hz_);
  while (!is_over(thread)) {
    listen();
    bound_samples();
    announce();
    serve_requests();
    telemetry_.publish_records();
    tell(false);
    give_flight();
    look_for_end();
  }
  thread.end();
  if (end_ == Outcome::ended && !link_.hosts()) {
    n_unheard_ = std::max<std::int64_t>(link_.run_info().n_samples - 1 - loop_.last_seq(), 0);
  } else if (loop_.counters().driving) {
    options_.warn("a force is left with the amplifiers, which hold it and then let go of it");
  }
  telemetry_.publish_records();
  tell(true);
  give_flight();
  return *end_;
}

// The frame is let go of first. What another controller serves is its own to let go of, and where
// all is silent there is nobody who hears.
bool Session::is_over(LoopThread& thread) {
  if (!end_) return false;
  if (end_ == Outcome::refused || end_ == Outcome::silent) return true;
  thread.let_go();
  return thread.has_let_go();
}

// After a sleep, of the process or of the loop alone, its state is that of before. Whoever claimed
// to hold the frame then would send away the controller that took its place meanwhile; so nothing
// is said or judged before the loop has woken up, which begins with finding out that it slept.
bool Session::knows_the_loop() const {
  const std::int64_t woke_ns = loop_.counters().woke_ns;
  const auto most_periods = static_cast<double>(std::max<std::int64_t>(1, policy_.hold_periods));
  return woke_ns == 0 || monotonic_ns() - woke_ns < asleep_ns + samples_ns(most_periods);
}

std::int64_t Session::samples_ns(double n) const {
  return static_cast<std::int64_t>(n / sample_rate_hz_ * ns_per_s);
}

// Told at once, because the state may be the same as before.
void Session::end(Outcome outcome) {
  if (end_) return;
  end_ = outcome;
  told_ns_ = 0;
}

void Session::listen() {
  int left = most_messages;
  for (Heard heard = link_.take(look_ms); heard.message && left > 0;
       heard = link_.take(0), --left) {
    if (heard.run_info) link_.publish_state(link_.run_info().run_id, run_state_t::READY, "");
    if (heard.run_state) {
      const run_state_t& plant = link_.plant_state();
      if (plant.state == run_state_t::ENDED) end(Outcome::ended);
      if (plant.state == run_state_t::FAILED) end(Outcome::plant_failed);
      if (plant.state == run_state_t::RUNNING && plant.start_monotonic_ns != plant_start_ns_) {
        end(Outcome::began_anew);
      }
    }
    const bool another = heard.other_plant || (heard.other_run && options_.any_run);
    // A plant that says it is there is not left for another one, however late its measurements are.
    const std::int64_t heard_ns = std::max(alive_ns_, link_.last_heard_ns());
    if (another &&
        monotonic_ns() - heard_ns > std::max(lost_after_ns, samples_ns(silent_samples))) {
      end(Outcome::began_anew);
    }
    // Whoever asks repeats it until the status names it.
    if (heard.request && link_.admits_request()) {
      requests_.hear(static_cast<Request>(link_.request().request), link_.request().nonce);
    }
    if (heard.other_status && knows_the_loop()) {
      if (const auto why =
              presence_.reason_to_leave(loop_.counters().state, link_.other_status())) {
        reason_ = *why;
        end_ = Outcome::refused;
        return;
      }
    }
  }
}

std::string Session::refusal(Request request) const {
  const LoopCounters& counters = loop_.counters();
  if (request < Request::start || request > Request::reset) return "there is no such request";
  if (request != Request::start) return "";
  if (end_) return "the controller ends";
  if (link_.run_info().loop == "passive") return "the run is passive";
  if (!counters.latched) return "";
  return "a fault is latched (" + fault_in_words(counters, link_.run_info().leg_names) +
         "); mend its cause and reset it first";
}

void Session::serve_requests() {
  requests_.serve(loop_.requests(), [this](Request request) { return refusal(request); });
  if (!knows_the_loop()) return;
  while (const auto answer = requests_.answer()) {
    last_request_ = *answer;
    telemetry_.publish_status(last_request_);
  }
}

void Session::tell(bool whatever) {
  if (!whatever && !knows_the_loop()) return;
  const LoopCounters& counters = loop_.counters();
  const State state = counters.state.load(std::memory_order_acquire);
  const std::int64_t now = monotonic_ns();
  const std::int64_t n_faults = counters.n_faults;
  const bool latched = counters.latched;
  if (state == told_state_ && n_faults == told_faults_ && latched == told_latched_ &&
      loop_.counters().broken_floor == told_floor_ && now - told_ns_ < status_every_ns &&
      !whatever) {
    return;
  }
  telemetry_.publish_status(last_request_);
  if (latched != told_latched_) keep_latch();
  if (n_faults != told_faults_ || latched > told_latched_) {
    options_.warn("fault: " + fault_in_words(counters, link_.run_info().leg_names) +
                  (latched ? ", latched" : ", passing"));
  } else if (state != told_state_ && state != State::fading && state != State::ramp_in) {
    options_.say(std::string(to_text(state)));
  }
  tell_floor();
  told_state_ = state;
  told_faults_ = n_faults;
  told_latched_ = latched;
  told_ns_ = now;
}

void Session::tell_floor() {
  const std::int64_t sensor = loop_.counters().broken_floor;
  if (sensor == told_floor_) return;
  told_floor_ = sensor;
  const auto& names = link_.run_info().floor_names;
  if (sensor < 0) return options_.say("feed-forward is back");
  options_.warn("feed-forward fades out, feedback goes on alone: " +
                names[static_cast<std::size_t>(sensor)] + " repeats one reading, or reads noise");
}

void Session::keep_latch() {
  if (loop_.counters().latched) {
    const LoopCounters& counters = loop_.counters();
    latch_.hold(counters.fault, link_.run_info().run_id,
                leg_of_fault(counters, link_.run_info().leg_names));
  } else {
    latch_.clear();
  }
}

void Session::give_flight() {
  const auto recorder = loop_.share_flight();
  if (!recorder->is_frozen()) flight_given_ = false;
  if (flight_given_ || !recorder->is_frozen()) return;
  flight_given_ = true;
  const FlightBounds bounds{.files = policy_.record_files, .bytes = policy_.record_mb * 1e6};
  disk_.give([recorder, bounds, info = link_.run_info(), policy_text = options_.policy_text,
              folder = options_.flight_folder, warn = options_.warn] {
    try {
      const auto file = next_flight_file(folder, info.run_id);
      write_flight_file(file, info, *recorder, policy_text);
      warn("flight record: " + file.string());
      make_room(folder, bounds);
    } catch (const std::exception& error) {
      warn(error.what());
    }
    recorder->resume();
  });
}

void Session::look_for_end() {
  const std::int64_t now = monotonic_ns();
  const LoopCounters& counters = loop_.counters();
  const std::int64_t count = counters.n_answered + counters.n_duplicate;
  if (count != alive_count_) alive_ns_ = now;
  alive_count_ = count;
  if (stop_requested()) end(Outcome::interrupted);
  const IoState io = io_.state();
  if (is_overruled(io.obeys_another_since_ns, now, sample_rate_hz_)) {
    reason_ = "the plant obeys another controller; end that one first";
    end(Outcome::refused);
  }
  // What a rig is heard to say on the bus is said by this process.
  const std::int64_t heard_ns =
      link_.hosts() ? alive_ns_ : std::max(alive_ns_, link_.last_heard_ns());
  if (io.failed || static_cast<double>(now - heard_ns) > options_.timeout_s * ns_per_s) {
    end(Outcome::silent);
  }
  const std::int64_t n_samples = link_.run_info().n_samples;
  if (link_.hosts() && n_samples > 0 &&
      now - start_ns_ > samples_ns(static_cast<double>(n_samples))) {
    end(Outcome::ended);
  }
}

// What arrives late may come of the plant's clock or of the way: the clock is asked.
void Session::bound_samples() {
  if (!link_.is_elsewhere() || link_.hosts()) return;
  const auto start = link_.start(plant_start_ns_);
  start ? loop_.bound(start->earliest_ns, start->latest_ns) : loop_.bound(0, -1);
  const std::int64_t n_held = loop_.counters().n_held;
  if (n_held == told_held_) return;
  told_held_ = n_held;
  link_.doubt_plant();
  if (std::exchange(told_late_, true)) return;
  options_.warn(
      "the samples come late: their way takes longer, which delay_samples has to count, or the "
      "plant's clock has stood still, and is asked");
}

// A rig has no process of its own that says so.
void Session::announce() {
  const std::int64_t now = monotonic_ns();
  const std::int64_t n_locks = loop_.counters().n_locks;
  if (n_locks != told_locks_) {
    options_.warn(
        link_.hosts()
            ? "the clock of the samples has stepped, paused or begun anew"
            : "the samples come at another time from here on: a clock has stood still, or their "
              "way got shorter");
    told_locks_ = n_locks;
    told_late_ = false;
  }
  if (!link_.hosts() || now - announced_ns_ < announce_every_ns) return;
  announced_ns_ = now;
  link_.announce(start_ns_);
}

std::string Session::never_active() const {
  const LoopCounters& now = loop_.counters();
  const double lasted_s = static_cast<double>(now.n_periods + now.n_late) / sample_rate_hz_;
  const bool wanted = policy_.start_at_once && link_.run_info().loop != "passive";
  if (!wanted || now.latched || now.n_active > 0) return "";
  if (lasted_s < 2 * (policy_.arming_s + policy_.ramp_in_s) + 1) return "";
  return "the loop was never active: of " + std::to_string(now.n_periods) + " periods " +
         std::to_string(now.n_missing) + " had no sound measurement that was on time";
}

void Session::add_to(stillframe_msgs::timing_t& all, LoopTimes& times) const {
  const LoopCounters& now = loop_.counters();
  all.n_periods += now.n_periods;
  all.n_late += now.n_late;
  all.n_lost += now.n_lost + n_unheard_;
  all.n_duplicate += now.n_duplicate;
  all.n_listened += now.n_listened;
  all.worst_wake_up_ns = std::max(all.worst_wake_up_ns, now.worst_wake_up_ns.load());
  all.worst_compute_ns = std::max(all.worst_compute_ns, now.worst_compute_ns.load());
  all.wall_time_ns += monotonic_ns() - start_ns_;
  times.wake_up.add(loop_.times().wake_up);
  times.receive.add(loop_.times().receive);
  times.compute.add(loop_.times().compute);
  times.publish.add(loop_.times().publish);
}

}  // namespace stillframe::controller

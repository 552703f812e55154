#include "controller/session.hpp"

#include <algorithm>
#include <cmath>
#include <thread>

#include "controller/flight_file.hpp"
#include "controller/law.hpp"
#include "controller/realtime.hpp"
#include "msgs/clock.hpp"
#include "msgs/stop_signal.hpp"

namespace stillframe::controller {

using stillframe_msgs::run_state_t;

namespace {

constexpr int wait_ms = 10;  // between looks at the loop
constexpr std::size_t most_asked = 16;
constexpr std::int64_t ms = 1'000'000, status_every_ns = 100 * ms, lost_after_ns = 1000 * ms;
// A controller that comes to a run which has gone on for longer than this was not there before.
constexpr std::int64_t late_start_ns = 500 * ms;

LoopSetting setting_of(const Gains& gains, double phase, std::int64_t start_ns) {
  const std::int64_t now = monotonic_ns();
  const auto samples = static_cast<double>(now - start_ns) * 1e-9 * gains.sample_rate_hz;
  return {.sample_rate_hz = gains.sample_rate_hz,
          .phase = phase,
          .start_ns = start_ns,
          .now_ns = now,
          .first_seq = now - start_ns > late_start_ns ? std::llround(samples) : 0};
}

}  // namespace

Session::Session(LcmIo& io, const Gains& gains, const Policy& policy, const Presence& presence,
                 Keyboard& keyboard, const SessionOptions& options, std::int64_t start_ns)
    : io_(io),
      policy_(policy),
      presence_(presence),
      keyboard_(keyboard),
      options_(options),
      stream_(options.lcm_url, io.run_info(), policy),
      start_ns_(start_ns),
      sample_rate_hz_(gains.sample_rate_hz),
      loop_(stream_,
            Supervisor(law_from_gains(gains), policy, gains.sample_rate_hz, gains.force_limit_n,
                       io.run_info().loop != "passive"),
            policy, setting_of(gains, options.phase, start_ns)),
      telemetry_(io, loop_, stream_, presence, options.policy_text),
      alive_ns_(monotonic_ns()) {}

Outcome Session::run() {
  std::atomic<bool> stop{false};
  std::thread thread([&] {
    if (policy_.realtime != Policy::Realtime::off) prepare_thread(policy_.priority, policy_.cpu);
    run_periodic(loop_, stop);
  });
  while (!end_) {
    listen();
    take_keys();
    serve_requests();
    telemetry_.publish_records();
    tell();
    if (loop_.flight().stands_still()) write_flight();
    if (!end_) end_ = broken_off();
  }
  stop = true;
  thread.join();
  if (end_ == Outcome::ended) {
    n_unheard_ = std::max<std::int64_t>(io_.run_info().n_samples - 1 - loop_.last_seq(), 0);
  }
  telemetry_.publish_records();
  tell();
  if (loop_.flight().stands_still()) write_flight();
  return *end_;
}

void Session::listen() {
  for (Heard heard = io_.take(wait_ms); heard.message; heard = io_.take(0)) {
    if (heard.run_info) io_.publish_state(io_.run_info().run_id, run_state_t::READY, "");
    if (heard.run_state) {
      const run_state_t& plant = io_.plant_state();
      if (plant.state == run_state_t::ENDED) end_ = Outcome::ended;
      if (plant.state == run_state_t::FAILED) end_ = Outcome::plant_failed;
      if (plant.state == run_state_t::RUNNING && plant.start_monotonic_ns != start_ns_) {
        end_ = Outcome::began_anew;
      }
    }
    if (heard.other_run && options_.any_run && monotonic_ns() - alive_ns_ > lost_after_ns) {
      end_ = Outcome::began_anew;
    }
    if (heard.request) {
      const auto& request = io_.request();
      const auto same = [&](const Asked& asked) { return asked.nonce == request.nonce; };
      // Whoever asks repeats it until the status names it.
      if (request.nonce != last_request_.nonce && asked_.size() < most_asked &&
          std::none_of(asked_.begin(), asked_.end(), same)) {
        asked_.push_back({static_cast<Request>(request.request), request.nonce});
      }
    }
    if (heard.other_status) {
      if (const auto why = presence_.gives_way(loop_.counters().state, io_.other_status())) {
        reason_ = *why;
        end_ = Outcome::refused;
      }
    }
    if (end_) return;
  }
}

std::string Session::refusal(Request request) const {
  const LoopCounters& counters = loop_.counters();
  if (request < Request::start || request > Request::reset) return "there is no such request";
  if (request != Request::start) return "";
  if (io_.run_info().loop == "passive") return "the run is passive";
  if (!counters.latched) return "";
  return "a fault is latched (" + std::string(to_text(counters.fault.load())) +
         "); mend its cause and reset it first";
}

// One after the other: a reset must have been taken before a start can be judged.
void Session::serve_requests() {
  while (!asked_.empty()) {
    const Asked front = asked_.front();
    std::string refused;
    if (n_requests_ < 0) {
      refused = refusal(front.request);
      if (refused.empty()) {
        n_requests_ = loop_.counters().n_requests;
        loop_.request(front.request);
        return;
      }
    } else if (loop_.counters().n_requests == n_requests_) {
      return;
    }
    n_requests_ = -1;
    asked_.pop_front();
    if (front.nonce == 0) {
      if (!refused.empty()) options_.warn("refused: " + refused);
      continue;
    }
    last_request_ = {.nonce = front.nonce, .answer = refused};
    telemetry_.publish_status(last_request_);
  }
}

void Session::take_keys() {
  while (const auto key = keyboard_.key()) {
    const auto request = *key == 's'                  ? Request::start
                         : *key == 'x' || *key == ' ' ? Request::stop
                         : *key == 'r'                ? Request::reset
                                                      : Request::none;
    if (request == Request::none) {
      options_.say("keys: s start, x or space stop, r reset a latched fault, Ctrl-C end");
    } else if (asked_.size() < most_asked) {
      asked_.push_back({request, 0});
    }
  }
}

void Session::tell() {
  const LoopCounters& counters = loop_.counters();
  const State state = counters.state.load(std::memory_order_acquire);
  const std::int64_t now = monotonic_ns();
  const std::int64_t n_faults = counters.n_faults;
  const bool latched = counters.latched;
  if (state == told_state_ && n_faults == told_faults_ && latched == told_latched_ &&
      now - told_ns_ < status_every_ns && !end_) {
    return;
  }
  telemetry_.publish_status(last_request_);
  if (n_faults != told_faults_ || latched > told_latched_) {
    options_.warn("fault: " + std::string(to_text(counters.fault.load())) +
                  (latched ? ", latched" : ", passing"));
  } else if (state != told_state_ && state != State::fading && state != State::ramp_in) {
    options_.say(std::string(to_text(state)));
  }
  told_state_ = state;
  told_faults_ = n_faults;
  told_latched_ = latched;
  told_ns_ = now;
}

void Session::write_flight() {
  std::filesystem::path file;
  for (int n = 1; file.empty() || std::filesystem::exists(file); ++n) {
    file = options_.flight_folder /
           ("flight-" + std::to_string(io_.run_info().run_id) + "-" + std::to_string(n) + ".lcm");
  }
  try {
    write_flight_file(file, io_.run_info(), loop_.flight(), options_.policy_text);
    options_.warn("flight record: " + file.string());
  } catch (const std::exception& error) {
    options_.warn(error.what());
  }
  loop_.flight().resume();
}

std::optional<Outcome> Session::broken_off() {
  const std::int64_t now = monotonic_ns();
  const LoopCounters& counters = loop_.counters();
  const std::int64_t count = counters.n_answered + counters.n_duplicate;
  if (count != alive_count_) alive_ns_ = now;
  alive_count_ = count;
  if (stop_requested()) {
    // Out of the frame's way smoothly first, if anybody is there to be let go.
    if (let_go_until_ns_ == 0) {
      loop_.request(Request::stop);
      const double most_s = policy_.ramp_out_s + policy_.fade_s + 0.5;
      let_go_until_ns_ = now + static_cast<std::int64_t>(most_s * ns_per_s);
    }
    if (!counters.driving || now > let_go_until_ns_ || now - alive_ns_ > lost_after_ns) {
      return Outcome::interrupted;
    }
  }
  const std::int64_t heard_ns = std::max(alive_ns_, io_.last_heard_ns());
  if (static_cast<double>(now - heard_ns) > options_.timeout_s * ns_per_s) return Outcome::silent;
  return std::nullopt;
}

std::string Session::never_active() const {
  const LoopCounters& now = loop_.counters();
  const double lasted_s = static_cast<double>(now.n_periods + now.n_late) / sample_rate_hz_;
  const bool wanted = policy_.start_at_once && io_.run_info().loop != "passive";
  if (!wanted || now.n_active > 0) return "";
  if (lasted_s < 2 * (policy_.arming_s + policy_.ramp_in_s) + 1) return "";
  return "the loop was never active: of " + std::to_string(now.n_periods) + " periods " +
         std::to_string(now.n_missing) + " had no sound measurement that was on time";
}

void Session::add_to(Counters& all, LoopTimes& times) const {
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

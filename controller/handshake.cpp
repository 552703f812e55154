#include "controller/handshake.hpp"

#include <limits>

#include "core/errors/formatted.hpp"
#include "core/errors/input_error.hpp"
#include "msgs/clock.hpp"
#include "msgs/stop_signal.hpp"

namespace stillframe::controller {

using stillframe_msgs::run_info_t;
using stillframe_msgs::run_state_t;

namespace {

// A plant gives both sides a tenth of a second to settle; a loop that waits for longer than this
// would be a loop that cannot be ended.
constexpr std::int64_t farthest_start_ns = 10 * ns_per_s;

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const auto& name : names) text += (text.empty() ? "" : ", ") + name;
  return "[" + text + "]";
}

std::string shown(double value) { return formatted("%.17g", value); }

std::string differs(const std::string& what, const std::string& gains, const std::string& plant) {
  return what + ": the gains file says " + gains + ", the plant says " + plant;
}

bool sizes_are_sound(const run_info_t& info) {
  return info.n_floor >= 0 && info.n_frame >= 0 && info.n_legs > 0 && info.n_samples > 0;
}

}  // namespace

std::string disagreement(const Gains& gains, const run_info_t& info) {
  if (info.format_version != 1) {
    return "format_version: found " + std::to_string(info.format_version) + ", allowed is 1";
  }
  if (!sizes_are_sound(info)) return "run_info: sizes that no run can have";
  if (info.scene_hash != gains.scene_hash) {
    return differs("scene_hash", gains.scene_hash, info.scene_hash) +
           "; design the gains for this scene";
  }
  if (info.leg_names != gains.legs) {
    return differs("legs", joined(gains.legs), joined(info.leg_names));
  }
  if (const auto& floor = gains.heard_floor(); !floor.empty() && info.floor_names != floor) {
    return differs(gains.feed_forward.filter.empty() ? "law: floor" : "feed_forward: floor",
                   joined(floor), joined(info.floor_names)) +
           "; a law hears the accelerations that it was designed for, in their order";
  }
  if (info.sample_rate_hz != gains.sample_rate_hz) {
    return differs("sample_rate_hz", shown(gains.sample_rate_hz), shown(info.sample_rate_hz));
  }
  if (info.delay_samples != gains.delay_samples) {
    return differs("delay_samples", shown(gains.delay_samples), shown(info.delay_samples));
  }
  if (info.mode != "lock_step" && info.mode != "wall_clock") {
    return "mode: found " + info.mode + ", allowed are lock_step and wall_clock";
  }
  if (info.loop != "active" && info.loop != "passive") {
    return "loop: found " + info.loop + ", allowed are active and passive";
  }
  if (info.mode == "wall_clock" && info.delay_samples < 1) {
    return "delay_samples: found " + shown(info.delay_samples) +
           ", allowed in wall-clock mode is 1 or more: the command of a sample is known at the "
           "next";
  }
  return {};
}

std::string unsound_start(std::int64_t said_ns, std::int64_t start_ns, std::int64_t now_ns) {
  if (said_ns >= 0 && start_ns <= now_ns + farthest_start_ns) return {};
  return "start_monotonic_ns: found " + std::to_string(said_ns) + ", by the clock of this host " +
         std::to_string(start_ns) + ", allowed is 0 or more and by that clock up to " +
         std::to_string(farthest_start_ns / ns_per_s) + " s from now (" + std::to_string(now_ns) +
         ")";
}

Start shake_hands(ControllerLink& link, const Gains& gains, std::optional<std::int64_t> run_id,
                  double timeout_s) {
  const auto limit_ns = static_cast<std::int64_t>(timeout_s * ns_per_s);
  std::int64_t last_asked_ns = monotonic_ns();
  bool ready = false;
  while (!stop_requested()) {
    const Heard heard = link.take(look_every_ms);
    const run_info_t& info = link.run_info();
    if (heard.run_info && (!run_id || info.run_id == *run_id)) {
      last_asked_ns = monotonic_ns();
      if (!ready) {
        const std::string reason = disagreement(gains, info);
        if (!reason.empty()) {
          link.publish_state(info.run_id, run_state_t::FAILED, reason);
          throw InputError(reason);
        }
        link.follow(info);
        ready = true;
      }
      link.publish_state(info.run_id, run_state_t::READY, "");
    }
    if (heard.run_state) {
      const run_state_t& plant = link.plant_state();
      if (plant.state == run_state_t::RUNNING) {
        const auto start = link.start(plant.start_monotonic_ns);
        if (!start && PeerClocks::is_reading(plant.start_monotonic_ns)) continue;
        const std::int64_t doubt_ns = start ? (start->latest_ns - start->earliest_ns) / 2 : 0;
        const std::int64_t start_ns =
            start ? start->earliest_ns + doubt_ns : std::numeric_limits<std::int64_t>::max();
        const std::string reason =
            unsound_start(plant.start_monotonic_ns, start_ns, monotonic_ns());
        if (reason.empty()) return {{}, start_ns, doubt_ns};
        link.publish_state(info.run_id, run_state_t::FAILED, reason);
        throw InputError(reason);
      }
      if (plant.state == run_state_t::FAILED) return {Outcome::plant_failed, 0, 0};
      if (plant.state == run_state_t::ENDED) return {Outcome::missed, 0, 0};
    }
    // In lock-step the first measurement says as much as RUNNING; the plant repeats it.
    if (heard.measurement && info.mode == "lock_step") return {};
    if (monotonic_ns() - last_asked_ns > limit_ns) return {Outcome::silent, 0, 0};
  }
  return {Outcome::interrupted, 0, 0};
}

}  // namespace stillframe::controller

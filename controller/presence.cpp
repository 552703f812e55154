#include "controller/presence.hpp"

#include <algorithm>
#include <utility>

#include "controller/slow_loops.hpp"
#include "msgs/clock.hpp"
#include "msgs/identity.hpp"

namespace stillframe::controller {

namespace {

constexpr double overruled_s = 0.2;

bool holds_the_frame(State state) {
  return state == State::ramp_in || state == State::active || state == State::fading ||
         state == State::ramp_out;
}

}  // namespace

bool is_overruled(std::int64_t since_ns, std::int64_t now_ns, double sample_rate_hz) noexcept {
  const double held_s = static_cast<double>(amplifiers_hold) / sample_rate_hz;
  return since_ns != 0 &&
         static_cast<double>(now_ns - since_ns) > std::max(overruled_s, held_s) * ns_per_s;
}

std::optional<std::string> Presence::reason_to_leave(
    State own, const stillframe_msgs::controller_status_t& other) const {
  const auto state = static_cast<State>(other.state);
  const bool own_holds = holds_the_frame(own), other_holds = holds_the_frame(state);
  const bool other_first = began_first({other.instance, other.started_ns, other.sent_ns},
                                       {instance_, started_ns_, monotonic_ns()});
  if (own_holds != other_holds ? own_holds : !other_first) return std::nullopt;
  return "another controller (process " + std::to_string(other.pid) + ", " +
         std::string(to_text(state)) + ") serves run " + std::to_string(other.run_id) +
         "; end it first: two controllers would drive the frame against each other";
}

}  // namespace stillframe::controller

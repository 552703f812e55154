#include "controller/server.hpp"

#include <algorithm>

#include "msgs/clock.hpp"
#include "msgs/stop_signal.hpp"

namespace stillframe::controller {

using stillframe_msgs::run_state_t;

Server::Server(LcmIo& io, Answer& answer, double timeout_s, Counters& counters) noexcept
    : io_(io),
      answer_(answer),
      counters_(counters),
      limit_ns_(static_cast<std::int64_t>(timeout_s * ns_per_s)) {}

void Server::answer_measurement() noexcept {
  const std::int64_t seq = io_.measurement().seq;
  if (seq <= last_seq_) {
    ++counters_.n_duplicate;
    if (seq == last_seq_) io_.repeat_command();
    return;
  }
  const std::int64_t begin = monotonic_ns();
  answer_.answer(io_.measurement(), io_.command());
  const std::int64_t end = monotonic_ns();
  io_.publish_command();
  counters_.worst_compute_ns = std::max(counters_.worst_compute_ns, end - begin);
  counters_.n_lost += seq - last_seq_ - 1;
  if (last_seq_ < 0) first_ns_ = begin;
  counters_.wall_time_ns = begin - first_ns_;
  last_seq_ = seq;
}

std::optional<Outcome> Server::told_end() noexcept {
  switch (io_.plant_state().state) {
    case run_state_t::ENDED:
      counters_.n_lost += std::max<std::int64_t>(io_.run_info().n_samples - 1 - last_seq_, 0);
      return Outcome::ended;
    case run_state_t::FAILED:
      return Outcome::plant_failed;
    default:
      return std::nullopt;
  }
}

std::optional<Outcome> Server::broken_off() const noexcept {
  if (stop_requested()) return Outcome::interrupted;
  if (monotonic_ns() - io_.last_heard_ns() > limit_ns_) return Outcome::silent;
  return std::nullopt;
}

}  // namespace stillframe::controller

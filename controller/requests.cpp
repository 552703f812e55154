#include "controller/requests.hpp"

#include <algorithm>

#include "msgs/peer_clocks.hpp"

namespace stillframe::controller {

namespace {

// A repetition is at most fresh_ns old; more than so many others meanwhile are no persons.
constexpr std::size_t most_remembered = 1024;

}  // namespace

bool Requests::admits(const stillframe_msgs::control_request_t& request, std::int64_t now_ns) {
  if (request.nonce == 0 || request.sent_ns > now_ns || request.sent_ns <= now_ns - fresh_ns)
    return false;
  if (request.asked_ns <= 0 || request.asked_ns > request.sent_ns) return false;
  if (std::find(obeyed_.begin(), obeyed_.end(), request.nonce) != obeyed_.end()) return false;
  const bool stop = request.request == stillframe_msgs::control_request_t::STOP;
  if (!stop && request.asked_ns <= last_asked_ns_) return false;
  last_asked_ns_ = std::max(last_asked_ns_, request.asked_ns);
  if (obeyed_.size() == most_remembered) obeyed_.erase(obeyed_.begin());
  obeyed_.push_back(request.nonce);
  return true;
}

}  // namespace stillframe::controller

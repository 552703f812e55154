#include "controller/request_queue.hpp"

#include <algorithm>

namespace stillframe::controller {

namespace {

constexpr std::size_t most_waiting = 16;
// Whoever asks repeats itself for seconds, ten times in each: more than could be asked meanwhile.
constexpr std::size_t most_settled = 256;

}  // namespace

void RequestQueue::hear(Request request, std::int64_t nonce) {
  if (is_known(nonce)) return;
  if (request != Request::stop) {
    // Where there is no room it is as if it had not been heard; it will be heard again.
    if (waiting_.size() < most_waiting) waiting_.push_back({request, nonce, 0});
    return;
  }
  std::deque<Asked> others;
  for (Asked& asked : waiting_) {
    if (asked.request == Request::start) {
      settle(asked, "a stop was heard before it was obeyed");
    } else {
      asked.number = 0;  // the stop may have taken its place
      others.push_back(asked);
    }
  }
  others.push_front({request, nonce, 0});
  if (others.size() > most_waiting) others.pop_back();
  waiting_ = std::move(others);
}

void RequestQueue::serve(RequestSlot& slot, const Refusal& refusal) {
  while (!waiting_.empty()) {
    Asked& front = waiting_.front();
    if (front.number == 0) {
      const std::string reason = refusal(front.request);
      if (!reason.empty()) {
        settle(front, reason);
        waiting_.pop_front();
        continue;
      }
      front.number = slot.ask(front.request);
    }
    if (front.number == 0 || !slot.is_done(front.number)) return;
    settle(front, "");
    waiting_.pop_front();
  }
}

std::optional<LastRequest> RequestQueue::answer() {
  if (answers_.empty()) return std::nullopt;
  const LastRequest oldest = answers_.front();
  answers_.pop_front();
  return oldest;
}

bool RequestQueue::is_known(std::int64_t nonce) const {
  return std::find(settled_.begin(), settled_.end(), nonce) != settled_.end() ||
         std::any_of(waiting_.begin(), waiting_.end(),
                     [nonce](const Asked& asked) { return asked.nonce == nonce; });
}

void RequestQueue::settle(const Asked& asked, const std::string& answer) {
  answers_.push_back({.nonce = asked.nonce, .answer = answer});
  settled_.push_back(asked.nonce);
  if (settled_.size() > most_settled) settled_.pop_front();
}

}  // namespace stillframe::controller

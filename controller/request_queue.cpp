#include "controller/request_queue.hpp"

namespace stillframe::controller {

namespace {

constexpr std::size_t most_waiting = 16;
// A status tells one; those that nobody has read by then are the oldest.
constexpr std::size_t most_answers = 256;
constexpr auto no_room = "too many requests wait";

}  // namespace

void RequestQueue::hear(Request request, std::int64_t nonce) {
  const Asked heard{request, nonce, 0};
  if (request != Request::stop) {
    if (waiting_.size() < most_waiting) {
      waiting_.push_back(heard);
    } else {
      settle(heard, no_room);
    }
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
  others.push_front(heard);
  if (others.size() > most_waiting) {
    settle(others.back(), no_room);
    others.pop_back();
  }
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

void RequestQueue::settle(const Asked& asked, const std::string& answer) {
  answers_.push_back({.nonce = asked.nonce, .answer = answer});
  if (answers_.size() > most_answers) answers_.pop_front();
}

}  // namespace stillframe::controller

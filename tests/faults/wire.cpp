#include "tests/faults/wire.hpp"

namespace stillframe::faults {

void Wire::begin(const Disturbance& disturbance, std::uint64_t seed) {
  model_.emplace(disturbance, seed, period_ns_);
}

void Wire::end(std::int64_t now_ns) {
  if (!model_) return;
  std::vector<Departure> departures;
  model_->release(now_ns, departures);
  add(departures);
  past_ = counts();
  model_.reset();
}

void Wire::pass(Bytes message, std::int64_t now_ns) {
  std::vector<Departure> departures;
  if (model_) {
    model_->pass(std::move(message), now_ns, departures);
  } else {
    departures.push_back({now_ns, std::move(message)});
  }
  add(departures);
}

std::optional<Bytes> Wire::take(std::int64_t now_ns) {
  if (next_ns() > now_ns) return std::nullopt;
  Bytes bytes = queue_.top().bytes;
  queue_.pop();
  return bytes;
}

WireCounts Wire::counts() const {
  WireCounts sum = past_;
  if (!model_) return sum;
  sum.n_passed += model_->counts().n_passed;
  sum.n_lost += model_->counts().n_lost;
  sum.n_duplicated += model_->counts().n_duplicated;
  sum.n_reordered += model_->counts().n_reordered;
  return sum;
}

void Wire::add(std::vector<Departure>& departures) {
  for (auto& departure : departures) {
    queue_.push({departure.leave_ns, n_++, std::move(departure.bytes)});
  }
}

}  // namespace stillframe::faults

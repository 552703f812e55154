#include "controller/flight_recorder.hpp"

#include <algorithm>

namespace stillframe::controller {

namespace {

template <class T>
std::vector<const T*> in_order(const std::vector<T>& ring, std::size_t n) {
  std::vector<const T*> all;
  for (std::size_t i = n - std::min(n, ring.size()); i < n; ++i) {
    all.push_back(&ring[i % ring.size()]);
  }
  return all;
}

}  // namespace

FlightRecorder::FlightRecorder(std::size_t n_records, std::size_t n_checkpoints,
                               std::int64_t n_after, const LoopRecord& record,
                               const LoopCheckpoint& checkpoint)
    : records_(std::max<std::size_t>(n_records, 1), record),
      checkpoints_(std::max<std::size_t>(n_checkpoints, 1), checkpoint),
      n_after_(n_after) {}

void FlightRecorder::add(const LoopRecord& record) noexcept {
  if (is_frozen()) return;
  records_[n_records_++ % records_.size()] = record;
  if (left_ > 0 && --left_ == 0) finish();
}

void FlightRecorder::add(const LoopCheckpoint& checkpoint) noexcept {
  if (!is_frozen()) checkpoints_[n_checkpoints_++ % checkpoints_.size()] = checkpoint;
}

void FlightRecorder::trigger() noexcept {
  if (left_ < 0) left_ = std::max<std::int64_t>(n_after_, 1);
}

void FlightRecorder::finish() noexcept {
  if (left_ < 0) return;
  left_ = -1;
  frozen_.store(true, std::memory_order_release);
}

std::vector<const LoopRecord*> FlightRecorder::records() const {
  return in_order(records_, n_records_);
}

std::vector<const LoopCheckpoint*> FlightRecorder::checkpoints() const {
  return in_order(checkpoints_, n_checkpoints_);
}

}  // namespace stillframe::controller

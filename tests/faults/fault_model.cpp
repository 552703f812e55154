#include "tests/faults/fault_model.hpp"

#include <cmath>
#include <utility>

namespace stillframe::faults {

FaultModel::FaultModel(const Disturbance& disturbance, std::uint64_t seed, std::int64_t period_ns)
    : disturbance_(disturbance), engine_(seed), period_ns_(static_cast<double>(period_ns)) {}

void FaultModel::pass(Bytes message, std::int64_t now_ns, std::vector<Departure>& out) {
  ++counts_.n_passed;
  // Always as many numbers a message, so that one kind of fault does not move the others' moments.
  const double loss = random(), burst = random(), jitter = random(), duplication = random(),
               reordering = random();
  if (burst_left_ == 0 && burst < disturbance_.burst) burst_left_ = disturbance_.burst_length;
  if (burst_left_ > 0 || loss < disturbance_.loss) {
    if (burst_left_ > 0) --burst_left_;
    ++counts_.n_lost;
    return;
  }
  if (held_back_.empty() && reordering < disturbance_.reordering) {
    ++counts_.n_reordered;
    held_back_.push_back(std::move(message));
    return;
  }
  const double periods = disturbance_.delay_periods + jitter * disturbance_.jitter_periods;
  const std::int64_t leave_ns = now_ns + std::llround(periods * period_ns_);
  if (duplication < disturbance_.duplication) {
    ++counts_.n_duplicated;
    out.push_back({leave_ns, message});
  }
  out.push_back({leave_ns, std::move(message)});
  let_go(leave_ns, out);
}

void FaultModel::release(std::int64_t now_ns, std::vector<Departure>& out) {
  // Nothing has overtaken it yet.
  counts_.n_reordered -= static_cast<std::int64_t>(held_back_.size());
  let_go(now_ns, out);
}

void FaultModel::let_go(std::int64_t now_ns, std::vector<Departure>& out) {
  for (auto& message : held_back_) out.push_back({now_ns, std::move(message)});
  held_back_.clear();
}

}  // namespace stillframe::faults

#include "tests/faults/corruption.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace stillframe::faults {

namespace {

constexpr std::int64_t ahead = 5000;  // samples

}  // namespace

void Corruptor::begin(Corruption corruption, std::int32_t leg) {
  corruption_ = corruption;
  leg_ = leg;
  has_frozen_ = false;
}

std::vector<Bytes> Corruptor::apply(const Bytes& bytes,
                                    const stillframe_msgs::measurement_t& measurement) {
  // A new run has no past of its own, and its sequence numbers begin again.
  if (measurement.seq == 0) past_.clear();
  past_.push_back(bytes);
  if (past_.size() > replay_age + 1) past_.pop_front();
  if (corruption_ == Corruption::none) return {bytes};
  ++n_corrupted_;
  return damage(bytes, measurement);
}

std::vector<Bytes> Corruptor::damage(const Bytes& bytes,
                                     stillframe_msgs::measurement_t measurement) {
  double& sigma = measurement.sigma.at(static_cast<std::size_t>(leg_));
  switch (corruption_) {
    case Corruption::none:
      break;
    case Corruption::not_finite:
      sigma = std::numeric_limits<double>::quiet_NaN();
      return {encoded(measurement)};
    case Corruption::out_of_range:
      sigma = 1e9;
      return {encoded(measurement)};
    case Corruption::wrong_size:
      ++measurement.n_legs;
      measurement.sigma.push_back(0);
      measurement.applied_force.push_back(0);
      return {encoded(measurement)};
    case Corruption::truncated:
      return {Bytes(bytes.begin(), bytes.end() - 12)};
    case Corruption::frozen:
      if (!std::exchange(has_frozen_, true)) frozen_sigma_ = sigma;
      sigma = frozen_sigma_;
      return {encoded(measurement)};
    case Corruption::other_run:
      ++measurement.run_id;
      ++measurement.seq;
      for (double& value : measurement.sigma) value = 1e4;
      return {encoded(measurement), bytes};
    case Corruption::later:
      // As of an earlier run of the same number that went on for longer: number and time agree.
      measurement.time_ns +=
          measurement.time_ns / std::max<std::int64_t>(measurement.seq, 1) * ahead;
      measurement.seq += ahead;
      for (double& value : measurement.sigma) value = 1e4;
      return {encoded(measurement), bytes};
    case Corruption::replayed:
      return {past_.front(), bytes};
  }
  return {bytes};
}

}  // namespace stillframe::faults

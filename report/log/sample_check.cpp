#include "report/log/sample_check.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace stillframe::report {

namespace {

bool same_bits(const double* values, const std::vector<double>& others) {
  return others.empty() || std::memcmp(values, others.data(), others.size() * sizeof(double)) == 0;
}

}  // namespace

SampleCheck::SampleCheck(const stillframe_msgs::run_info_t& info)
    : n_floor_(static_cast<std::size_t>(info.n_floor)) {
  const auto add = [](std::vector<std::string>& to, const char* what, const auto& names) {
    for (const std::string& name : names) to.push_back(std::string(what) + " of " + name);
  };
  add(measured_, "floor acceleration", info.floor_names);
  add(measured_, "sigma", info.leg_names);
  add(measured_, "applied force", info.leg_names);
  add(measured_, "acceleration", info.frame_names);
  add(commanded_, "command", info.leg_names);
}

void SampleCheck::measurement(std::int64_t seq, const double* values) {
  look(seq, values, measured_);
  const double* floor_end = values + n_floor_;
  if (last_seq_ < 0) first_floor_.assign(values, floor_end);
  floor_moves_ = floor_moves_ || !same_bits(values, first_floor_);
  // A floor that rests shows zeros, and lets a frame come to rest on it.
  if (seq == last_seq_ + 1 && last_seq_ >= 0 && same_bits(values, last_) &&
      std::any_of(values, floor_end, [](double value) { return value != 0; })) {
    ++faults_.n_repeats;
  }
  last_.assign(values, values + measured_.size());
  last_seq_ = seq;
}

void SampleCheck::command(std::int64_t seq, const double* values) { look(seq, values, commanded_); }

void SampleCheck::look(std::int64_t seq, const double* values,
                       const std::vector<std::string>& names) {
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (std::abs(values[i]) <= largest_value) continue;
    if (faults_.n_not_finite++ == 0) {
      faults_.first_not_finite = "seq " + std::to_string(seq) + ", " + names[i];
    }
  }
}

SampleFaults SampleCheck::faults() const {
  SampleFaults result = faults_;
  // One input that never changes is a floor of its own, and no sensor that is stuck.
  if (!floor_moves_) result.n_repeats = 0;
  return result;
}

}  // namespace stillframe::report

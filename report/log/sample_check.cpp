#include "report/log/sample_check.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace stillframe::report {

namespace {

bool same_bits(const double* values, const std::vector<double>& others) {
  return others.empty() || std::memcmp(values, others.data(), others.size() * sizeof(double)) == 0;
}

void follow(std::vector<ChannelCourse>& courses, const double* values) {
  for (ChannelCourse& course : courses) {
    const double value = *values++;
    if (course.n++ == 0) course.first = course.lowest = course.highest = value;
    course.lowest = std::min(course.lowest, value);
    course.highest = std::max(course.highest, value);
    // A value that is no number is another one than any.
    if (value != course.first) ++course.n_other;
  }
}

}  // namespace

SampleCheck::SampleCheck(const stillframe_msgs::run_info_t& info)
    : n_floor_(static_cast<std::size_t>(info.n_floor)),
      n_legs_(static_cast<std::size_t>(info.n_legs)) {
  const auto add = [](std::vector<std::string>& to, const char* what, const auto& names) {
    for (const std::string& name : names) to.push_back(std::string(what) + " of " + name);
  };
  add(measured_, "floor acceleration", info.floor_names);
  add(measured_, "sigma", info.leg_names);
  add(measured_, "applied force", info.leg_names);
  add(measured_, "acceleration", info.frame_names);
  add(commanded_, "command", info.leg_names);
  measured_course_.resize(measured_.size());
  commanded_course_.resize(commanded_.size());
}

void SampleCheck::measurement(std::int64_t seq, const double* values) {
  look(seq, values, measured_);
  follow(measured_course_, values);
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

void SampleCheck::command(std::int64_t seq, const double* values) {
  look(seq, values, commanded_);
  follow(commanded_course_, values);
}

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
  const auto part = [&](std::size_t first, std::size_t n) {
    const auto begin = measured_course_.begin() + static_cast<std::ptrdiff_t>(first);
    return std::vector<ChannelCourse>(begin, begin + static_cast<std::ptrdiff_t>(n));
  };
  const std::size_t frame = n_floor_ + 2 * n_legs_;
  result.floor = part(0, n_floor_);
  result.applied = part(n_floor_ + n_legs_, n_legs_);
  result.frame = part(frame, measured_course_.size() - frame);
  result.commanded = commanded_course_;
  return result;
}

}  // namespace stillframe::report

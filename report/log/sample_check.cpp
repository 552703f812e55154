#include "report/log/sample_check.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "report/log/same_bits.hpp"

namespace stillframe::report {

namespace {

/// What may be seen to move where a channel should: the frame beside the floor, the command beside
/// the force of its leg, and floor and sigma beside the frame.
std::vector<CourseRecorder::Beside> beside(const stillframe_msgs::run_info_t& info) {
  const auto n_floor = static_cast<std::size_t>(info.n_floor),
             n_legs = static_cast<std::size_t>(info.n_legs),
             n_frame = static_cast<std::size_t>(info.n_frame);
  const std::size_t frame = n_floor + 2 * n_legs, commands = frame + n_frame;
  // A rest keeps a number of every channel, of which a log may claim any number.
  constexpr std::size_t most_followed = 1000;
  if (commands + n_legs > most_followed) {
    return std::vector<CourseRecorder::Beside>(commands + n_legs);
  }
  std::vector<CourseRecorder::Beside> result(n_floor, {frame, commands});
  for (std::size_t i = 0; i < 2 * n_legs; ++i) {
    const std::size_t command = commands + i % n_legs;
    result.push_back({command, command + 1});
  }
  result.insert(result.end(), n_frame, {0, n_floor + n_legs});
  result.resize(commands + n_legs);
  return result;
}

}  // namespace

SampleCheck::SampleCheck(const stillframe_msgs::run_info_t& info)
    : n_floor_(static_cast<std::size_t>(info.n_floor)),
      n_legs_(static_cast<std::size_t>(info.n_legs)),
      courses_(beside(info)) {
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
  courses_.take(seq, values, 0, measured_.size());
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
  courses_.take(seq, values, measured_.size(), commanded_.size());
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
  auto all = courses_.courses();
  auto take = [from = all.begin()](std::vector<ChannelCourse>& to, std::size_t n) mutable {
    const auto end = from + static_cast<std::ptrdiff_t>(n);
    to.assign(std::make_move_iterator(from), std::make_move_iterator(end));
    from = end;
  };
  take(result.floor, n_floor_);
  take(result.sigma, n_legs_);
  take(result.applied, n_legs_);
  take(result.frame, measured_.size() - n_floor_ - 2 * n_legs_);
  take(result.commanded, n_legs_);
  return result;
}

}  // namespace stillframe::report

#include "plant_sim/command_track.hpp"

namespace stillframe {

namespace {

// Far more than a controller sends while it lets go of a plant that is silent.
constexpr std::size_t most_waiting = 100'000;

}  // namespace

CommandTrack::Result CommandTrack::add(std::int64_t seq,
                                       const Eigen::Ref<const Eigen::VectorXd>& force) {
  if (seq <= seq_) return Result::duplicate;
  if (waiting_.size() >= most_waiting) return Result::too_many;
  return waiting_.try_emplace(seq, force).second ? Result::taken : Result::duplicate;
}

void CommandTrack::advance_to(std::int64_t k) {
  const auto end = waiting_.upper_bound(k);
  if (end == waiting_.begin()) return;
  const auto newest = std::prev(end);
  seq_ = newest->first;
  force_ = newest->second;
  waiting_.erase(waiting_.begin(), end);
}

}  // namespace stillframe

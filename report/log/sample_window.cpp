#include "report/log/sample_window.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "report/log/same_bits.hpp"

namespace stillframe::report {

using Eigen::Index;
using stillframe_msgs::command_t;
using stillframe_msgs::measurement_t;

void SeqTally::left(std::int64_t seq) {
  finish(expected_ < 0 ? seq : std::max(seq, expected_));
  ++count.n_received;
  count.n_after = 0;
  expected_ = seq + 1;
}

void SeqTally::finish(std::int64_t end) {
  if (expected_ < 0) expected_ = end;
  if (end <= expected_) return;
  if (count.gaps.size() < ChannelCount::most_gaps) count.gaps.push_back({expected_, end - 1});
  count.n_lost += end - expected_;
  count.n_after = end - expected_;
  expected_ = end;
}

namespace {

/// Leaves out what lies behind the last measurement, where there is nothing to answer: a controller
/// that lets go of its forces says so once more behind the end of a run.
void cut_gaps(ChannelCount& count, std::int64_t end) {
  while (!count.gaps.empty() && count.gaps.back().last >= end) {
    SequenceGap& gap = count.gaps.back();
    const std::int64_t first = std::max(gap.first, end);
    count.n_lost -= gap.last - first + 1;
    gap.last = first - 1;
    if (gap.last < gap.first) count.gaps.pop_back();
  }
}

void require_positive(std::int64_t value, const char* name) {
  if (value < 1) throw std::invalid_argument(std::string(name) + " must be positive");
}

}  // namespace

SampleWindow::SampleWindow(const stillframe_msgs::run_info_t& info, const ScanSettings& settings,
                           LogVisitor& visitor, CommandSink command_sink)
    : n_floor_(info.n_floor),
      n_legs_(info.n_legs),
      n_frame_(info.n_frame),
      block_samples_(settings.block_samples),
      announced_(info.n_samples),
      capacity_(settings.reorder_samples),
      visitor_(visitor),
      command_sink_(std::move(command_sink)),
      check_(info) {
  require_positive(block_samples_, "block_samples");
  require_positive(capacity_, "reorder_samples");
  slots_.resize(static_cast<std::size_t>(capacity_));
  values_.resize(static_cast<Index>(capacity_), n_floor_ + 4 * n_legs_ + n_frame_);
  block_.time_s.resize(block_samples_);
  block_.floor_acceleration.resize(block_samples_, n_floor_);
  block_.sigma.resize(block_samples_, n_legs_);
  block_.applied_force.resize(block_samples_, n_legs_);
  block_.frame_acceleration.resize(block_samples_, n_frame_);
  block_.command_force.resize(block_samples_, n_legs_);
  block_.excitation.resize(block_samples_, n_legs_);
  measurements_.expect(0);
}

bool SampleWindow::make_room(std::int64_t seq) {
  // The first message may be a late one, so some room is left before it.
  if (base_ < 0) base_ = end_ = std::max<std::int64_t>(0, seq - capacity_ + 1);
  if (seq < base_) return false;
  if (seq - base_ >= capacity_) let_go(seq - capacity_ + 1);
  end_ = std::max(end_, seq + 1);
  return true;
}

void SampleWindow::let_go(std::int64_t end) {
  for (std::int64_t seq = base_; seq < std::min(end, end_); ++seq) {
    hand_out(seq, slots_[static_cast<std::size_t>(row_of(seq))]);
  }
  base_ = end;
  end_ = std::max(end_, base_);
}

void SampleWindow::hand_out(std::int64_t seq, Slot& slot) {
  const Index row = row_of(seq);
  if (slot.has_measurement) {
    measurements_.left(seq);
    check_.measurement(seq, values_.row(row).data());
    append(seq, slot, row);
  }
  if (slot.has_command) {
    commands_.left(seq);
    if (slot.saturated) ++n_saturated_;
    check_.command(seq, values_.row(row).data() + values_.cols() - n_legs_);
    if (command_sink_) command_sink_(seq, values_.row(row).tail(n_legs_).transpose());
  }
  slot = {};
}

void SampleWindow::append(std::int64_t seq, const Slot& slot, Index row) {
  if (filled_ > 0 && seq != block_.first_seq + filled_) emit();
  if (filled_ == 0) block_.first_seq = seq;
  const auto values = values_.row(row);
  block_.time_s(filled_) = static_cast<double>(slot.time_ns) / 1e9;
  block_.floor_acceleration.row(filled_) = values.head(n_floor_);
  block_.sigma.row(filled_) = values.segment(n_floor_, n_legs_);
  block_.applied_force.row(filled_) = values.segment(n_floor_ + n_legs_, n_legs_);
  block_.frame_acceleration.row(filled_) = values.segment(n_floor_ + 2 * n_legs_, n_frame_);
  if (slot.has_command) {
    block_.command_force.row(filled_) = values.tail(n_legs_);
  } else {
    block_.command_force.row(filled_).setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  if (slot.has_excitation) {
    block_.excitation.row(filled_) = values.tail(2 * n_legs_).head(n_legs_);
  } else {
    block_.excitation.row(filled_).setZero();
  }
  if (++filled_ == block_samples_) emit();
}

void SampleWindow::emit() {
  if (filled_ == block_samples_) {
    visitor_.samples(block_);
  } else if (filled_ > 0) {
    visitor_.samples({.first_seq = block_.first_seq,
                      .time_s = block_.time_s.head(filled_),
                      .floor_acceleration = block_.floor_acceleration.topRows(filled_),
                      .sigma = block_.sigma.topRows(filled_),
                      .applied_force = block_.applied_force.topRows(filled_),
                      .frame_acceleration = block_.frame_acceleration.topRows(filled_),
                      .command_force = block_.command_force.topRows(filled_),
                      .excitation = block_.excitation.topRows(filled_)});
  }
  filled_ = 0;
}

bool SampleWindow::is_same(const Slot& slot, Index row, const measurement_t& message) const {
  const double* values = values_.row(row).data();
  return slot.time_ns == message.time_ns && same_bits(values, message.floor_acceleration) &&
         same_bits(values + n_floor_, message.sigma) &&
         same_bits(values + n_floor_ + n_legs_, message.applied_force) &&
         same_bits(values + n_floor_ + 2 * n_legs_, message.frame_acceleration);
}

bool SampleWindow::is_same(const Slot& slot, Index row, const command_t& message) const {
  const double* values = values_.row(row).data() + values_.cols() - n_legs_;
  return slot.command_time_ns == message.time_ns && slot.saturated == (message.saturated != 0) &&
         same_bits(values, message.force);
}

SampleWindow::Place SampleWindow::put(const measurement_t& message) {
  measurements_.arrived(message.seq);
  if (!make_room(message.seq)) return Place::too_late;
  const Index row = row_of(message.seq);
  Slot& slot = slots_[static_cast<std::size_t>(row)];
  if (slot.has_measurement) {
    if (!is_same(slot, row, message)) return Place::conflicting;
    ++measurements_.count.n_duplicates;
    return Place::repeat;
  }
  slot.has_measurement = true;
  slot.time_ns = message.time_ns;
  double* values = values_.row(row).data();
  for (const auto* part : {&message.floor_acceleration, &message.sigma, &message.applied_force,
                           &message.frame_acceleration}) {
    values = std::copy(part->begin(), part->end(), values);
  }
  return Place::taken;
}

SampleWindow::Place SampleWindow::put(const command_t& message) {
  commands_.arrived(message.seq);
  if (!make_room(message.seq)) return Place::too_late;
  const Index row = row_of(message.seq);
  Slot& slot = slots_[static_cast<std::size_t>(row)];
  if (slot.has_command) {
    if (!is_same(slot, row, message)) return Place::conflicting;
    ++commands_.count.n_duplicates;
    return Place::repeat;
  }
  slot.has_command = true;
  slot.saturated = message.saturated != 0;
  slot.command_time_ns = message.time_ns;
  std::copy(message.force.begin(), message.force.end(),
            values_.row(row).data() + values_.cols() - n_legs_);
  return Place::taken;
}

void SampleWindow::put(const stillframe_msgs::excitation_t& message) {
  if (!holds(message.seq) || static_cast<Index>(message.force.size()) != n_legs_) return;
  const Index row = row_of(message.seq);
  slots_[static_cast<std::size_t>(row)].has_excitation = true;
  std::copy(message.force.begin(), message.force.end(),
            values_.row(row).data() + values_.cols() - 2 * n_legs_);
}

template <>
bool SampleWindow::contradicts(const measurement_t& message) const {
  if (!holds(message.seq)) return false;
  const Index row = row_of(message.seq);
  const Slot& slot = slots_[static_cast<std::size_t>(row)];
  return slot.has_measurement && !is_same(slot, row, message);
}

template <>
bool SampleWindow::contradicts(const command_t& message) const {
  if (!holds(message.seq)) return false;
  const Index row = row_of(message.seq);
  const Slot& slot = slots_[static_cast<std::size_t>(row)];
  return slot.has_command && !is_same(slot, row, message);
}

void SampleWindow::finish() {
  if (base_ >= 0) let_go(end_);
  emit();
  // From the first command on every measurement is to have one.
  commands_.finish(measurements_.next());
  cut_gaps(commands_.count, measurements_.next());
  measurements_.finish(announced_);
}

}  // namespace stillframe::report

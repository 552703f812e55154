#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "report/log/log_scan.hpp"
#include "report/log/sample_check.hpp"
#include "stillframe_msgs/command_t.hpp"
#include "stillframe_msgs/excitation_t.hpp"
#include "stillframe_msgs/measurement_t.hpp"

namespace stillframe::report {

/// Counts the messages of one channel as they leave the window in the order of seq.
class SeqTally {
 public:
  ChannelCount count;

  void arrived(std::int64_t seq) {
    if (seq < largest_) ++count.n_out_of_order;
    if (seq > largest_) largest_ = seq;
  }
  /// Gaps are counted from `expected` on, which is set by the first call where there is none.
  void left(std::int64_t seq);
  /// The messages up to end - 1 that have not come never will.
  void finish(std::int64_t end);
  void expect(std::int64_t seq) { expected_ = seq; }
  /// The one after the last that came.
  std::int64_t next() const { return expected_; }

 private:
  std::int64_t largest_ = -1, expected_ = -1;
};

/// The newest samples of a run, in which late messages find their place and commands find their
/// measurements; what is too old for that leaves it, in the order of seq, as blocks. Set-up.
class SampleWindow {
 public:
  /// Every distinct command in the order of seq, its measurement logged or not.
  using CommandSink = std::function<void(std::int64_t seq, const Eigen::VectorXd& force)>;

  /// Errors: std::invalid_argument if a setting is not positive.
  SampleWindow(const stillframe_msgs::run_info_t& info, const ScanSettings& settings,
               LogVisitor& visitor, CommandSink command_sink);

  enum class Place {
    taken,
    repeat,       ///< the same message is there
    conflicting,  ///< another message with this seq is there
    too_late,
  };
  Place put(const stillframe_msgs::measurement_t& message);
  Place put(const stillframe_msgs::command_t& message);
  /// Of a sample that is there, and one of another size is passed over.
  void put(const stillframe_msgs::excitation_t& message);
  /// Whether another message with this seq is there.
  template <typename Message>
  bool contradicts(const Message& message) const;

  /// Hands out all that is left and counts the samples up to the announced end.
  void finish();

  const ChannelCount& measurements() const { return measurements_.count; }
  const ChannelCount& commands() const { return commands_.count; }
  std::int64_t n_saturated() const { return n_saturated_; }
  SampleFaults faults() const { return check_.faults(); }

 private:
  /// A place for one measurement and the command that answers it.
  struct Slot {
    bool has_measurement = false, has_command = false, has_excitation = false, saturated = false;
    std::int64_t time_ns = 0, command_time_ns = 0;
  };

  bool make_room(std::int64_t seq);
  void let_go(std::int64_t end);
  void hand_out(std::int64_t seq, Slot& slot);
  void append(std::int64_t seq, const Slot& slot, Eigen::Index row);
  void emit();

  bool is_same(const Slot& slot, Eigen::Index row,
               const stillframe_msgs::measurement_t& message) const;
  bool is_same(const Slot& slot, Eigen::Index row, const stillframe_msgs::command_t& message) const;
  bool holds(std::int64_t seq) const { return seq >= base_ && seq < end_; }
  Eigen::Index row_of(std::int64_t seq) const { return static_cast<Eigen::Index>(seq % capacity_); }

  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  Eigen::Index n_floor_, n_legs_, n_frame_, block_samples_;
  std::int64_t announced_, capacity_;
  LogVisitor& visitor_;
  CommandSink command_sink_;
  std::int64_t base_ = -1, end_ = -1;  ///< the seq that are held: base .. end - 1
  std::vector<Slot> slots_;            ///< of seq modulo capacity
  Rows values_;  ///< a row a slot: floor, sigma, applied, frame, excitation, command
  SampleBlock block_;
  Eigen::Index filled_ = 0;
  SeqTally measurements_, commands_;
  SampleCheck check_;
  std::int64_t n_saturated_ = 0;
};

}  // namespace stillframe::report

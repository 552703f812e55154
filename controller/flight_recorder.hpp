#pragma once

#include <atomic>
#include <vector>

#include "controller/loop_record.hpp"

namespace stillframe::controller {

/// The last seconds of a loop in memory. A fault lets it run on for a while, so that the end of the
/// motion is in it too, and then stands still until another thread has taken it. Construction is
/// set-up; add and trigger are hot, for the loop's thread: noexcept, no allocation.
class FlightRecorder {
 public:
  /// Keeps n_records records and n_checkpoints checkpoints; stands still n_after records after a
  /// trigger.
  FlightRecorder(std::size_t n_records, std::size_t n_checkpoints, std::int64_t n_after,
                 const LoopRecord& record, const LoopCheckpoint& checkpoint);

  void add(const LoopRecord& record) noexcept;
  void add(const LoopCheckpoint& checkpoint) noexcept;
  /// A fault: the recorder will stand still n_after records from now.
  void trigger() noexcept;
  /// The end of the loop: it stands still at once if it had been triggered.
  void finish() noexcept;

  /// For the other thread: true while it stands still; then the contents may be read, oldest first,
  /// until resume.
  bool is_frozen() const noexcept { return frozen_.load(std::memory_order_acquire); }
  std::vector<const LoopRecord*> records() const;
  std::vector<const LoopCheckpoint*> checkpoints() const;
  void resume() noexcept { frozen_.store(false, std::memory_order_release); }

 private:
  std::vector<LoopRecord> records_;
  std::vector<LoopCheckpoint> checkpoints_;
  std::size_t n_records_ = 0, n_checkpoints_ = 0;  ///< ever added
  std::int64_t n_after_, left_ = -1;
  std::atomic<bool> frozen_{false};
};

}  // namespace stillframe::controller

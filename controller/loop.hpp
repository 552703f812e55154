#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

#include "controller/deadlines.hpp"
#include "controller/flight_recorder.hpp"
#include "controller/histogram.hpp"
#include "controller/io.hpp"
#include "controller/request_slot.hpp"
#include "controller/ring.hpp"
#include "controller/sample_clock.hpp"
#include "controller/screen.hpp"
#include "controller/supervisor.hpp"

namespace stillframe::controller {

/// What a loop has counted so far. Written by its thread alone, read by any.
struct LoopCounters {
  std::atomic<std::int64_t> n_periods{0};    ///< wake-ups
  std::atomic<std::int64_t> n_late{0};       ///< periods skipped whole
  std::atomic<std::int64_t> n_answered{0};   ///< measurements that a command answered
  std::atomic<std::int64_t> n_lost{0};       ///< measurements before the newest that none answered
  std::atomic<std::int64_t> n_duplicate{0};  ///< heard again, overtaken, or of another time
  std::atomic<std::int64_t> n_active{0};     ///< periods with the whole gain
  std::atomic<std::int64_t> n_missing{0};    ///< periods without a measurement to answer
  std::atomic<std::int64_t> n_listened{0};   ///< measurements met while it must not command
  std::atomic<std::int64_t> n_saturated{0}, n_faults{0}, n_rejoins{0};
  std::atomic<std::int64_t> n_records_dropped{0}, n_page_faults{0};
  std::atomic<std::int64_t> n_locks{0};  ///< SampleClock::n_locks
  std::atomic<std::int64_t> n_held{0};   ///< SampleClock::n_held
  std::atomic<double> drift{0};          ///< SampleClock::drift
  std::atomic<std::int64_t> woke_ns{0};  ///< when the last period began, CLOCK_MONOTONIC
  std::atomic<std::int64_t> worst_wake_up_ns{0}, worst_compute_ns{0};
  std::atomic<State> state{State::idle};
  std::atomic<Fault> fault{Fault::none};
  std::atomic<std::int64_t> broken_floor{-1};  ///< Supervisor::broken_floor
  std::atomic<std::int64_t> first_leg{-1};     ///< Supervisor::first_leg
  std::atomic<bool> latched{false};
  std::atomic<bool> driving{false};  ///< a force is commanded, or is about to be
};

/// How long the stages of a period took.
struct LoopTimes {
  Histogram wake_up;  ///< past the deadline
  Histogram receive;  ///< from the sample to its receipt
  Histogram compute;  ///< from the wake-up to the command: screening, supervisor and law
  Histogram publish;  ///< Io::send
};

/// Where a loop stands in time.
struct LoopSetting {
  double sample_rate_hz = 0;
  double phase = 0.5;          ///< of a deadline in its sample, 0 to below 1
  std::int64_t start_ns = 0;   ///< t_0 of the samples, CLOCK_MONOTONIC
  std::int64_t now_ns = 0;     ///< deadlines before it are none of this loop's
  std::int64_t first_seq = 0;  ///< samples before it were not ours to answer
  Eigen::Index n_floor = 0;    ///< accelerations of the floor in a measurement
  Eigen::Index n_frame = 0;    ///< and of the frame
  Pacing pacing = Pacing::same_clock;
  std::int64_t start_doubt_ns = 0;  ///< of SampleClock
};

/// The periodic loop of a wall-clock run: at each deadline it takes what has come, screens the
/// newest measurement, goes through the supervisor and sends the command. It talks to the world
/// through Io alone; other threads reach it through requests, rings and counters. Construction is
/// set-up; period is hot: noexcept, no allocation, no lock, no system call of its own but the
/// clock, and once a second the count of its page faults.
class Loop {
 public:
  /// io outlives the loop. Errors: std::invalid_argument as Deadlines.
  Loop(Io& io, const Supervisor& supervisor, const Policy& policy, const LoopSetting& setting);

  /// The deadline to sleep until (CLOCK_MONOTONIC, ns).
  std::int64_t next_ns() const noexcept { return deadlines_.next_ns(); }
  /// Goes through the period whose deadline has just passed; now_ns: the time of the wake-up.
  void period(std::int64_t now_ns) noexcept;
  /// The end, on the loop's thread: gives the flight record free.
  void finish() noexcept { flight_->finish(); }

  /// Asks for a change of state at the next period. Any thread.
  void request(Request request) noexcept { requests_.ask(request); }
  RequestSlot& requests() noexcept { return requests_; }
  /// SampleClock::bound, or unbound if earliest_ns > latest_ns. One thread, beside the loop's.
  void bound(std::int64_t earliest_ns, std::int64_t latest_ns) noexcept {
    // Each was true when it was set; where two of two moments cross, nothing is known for a period.
    earliest_start_ns_.store(earliest_ns, std::memory_order_relaxed);
    latest_start_ns_.store(latest_ns, std::memory_order_relaxed);
  }

  const LoopCounters& counters() const noexcept { return counters_; }
  /// To be read when the loop's thread has ended.
  const LoopTimes& times() const noexcept { return times_; }
  std::int64_t last_seq() const noexcept { return last_answered_; }
  /// Telemetry, for one reading thread.
  Ring<LoopRecord>& records() noexcept { return records_; }
  Ring<LoopCheckpoint>& checkpoints() noexcept { return checkpoints_; }
  FlightRecorder& flight() noexcept { return *flight_; }
  /// For a thread that may read it longer than the loop lives.
  std::shared_ptr<FlightRecorder> share_flight() noexcept { return flight_; }
  /// Of the loop's thread alone while it runs.
  const Supervisor& supervisor() const noexcept { return supervisor_; }

 private:
  Defect take_newest(std::int64_t now_ns) noexcept;
  void bound_clock() noexcept;
  void count(std::int64_t now_ns) noexcept;
  void enable() noexcept;
  void give_checkpoint() noexcept;
  void give_record() noexcept;

  Io& io_;
  Supervisor supervisor_;
  SampleClock clock_;
  Screen screen_;
  Deadlines deadlines_;
  bool enabled_ = false;
  std::int64_t disable_after_, idle_ = 0;  ///< periods without driving
  std::int64_t checkpoint_every_, since_checkpoint_ = 0;
  std::int64_t period_ = -1, last_answered_, page_faults_at_start_ = -1;
  std::int64_t page_faults_every_, since_page_faults_ = 0;
  Measurement incoming_, newest_;
  LoopRecord record_;
  LoopCheckpoint checkpoint_;
  LoopCounters counters_;
  LoopTimes times_;
  Ring<LoopRecord> records_;
  Ring<LoopCheckpoint> checkpoints_;
  std::shared_ptr<FlightRecorder> flight_;
  RequestSlot requests_;
  std::atomic<std::int64_t> earliest_start_ns_{0}, latest_start_ns_{-1};
};

/// Runs the loop at its deadlines until `stop`, which it looks at twenty times a second however far
/// off a deadline is. Hot: no allocation.
void run_periodic(Loop& loop, const std::atomic<bool>& stop) noexcept;

}  // namespace stillframe::controller

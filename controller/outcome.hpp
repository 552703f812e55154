#pragma once

#include <cstdint>

namespace stillframe::controller {

/// How a run ended, as seen by the controller.
enum class Outcome {
  ended,         ///< the plant said so
  plant_failed,  ///< the plant said so
  missed,        ///< it had ended before its start was heard
  silent,        ///< nothing was heard for the time limit
  interrupted,   ///< SIGINT or SIGTERM
  began_anew,    ///< the plant was started again, or another one
  refused,       ///< another controller serves the run
};

/// What the controller measured of its own timing; the fields of timing_t.
struct Counters {
  std::int64_t n_periods = 0;         ///< measurements answered, or wake-ups in wall-clock mode
  std::int64_t n_late = 0;            ///< periods skipped whole
  std::int64_t n_lost = 0;            ///< measurements never answered
  std::int64_t n_duplicate = 0;       ///< measurements heard again
  std::int64_t n_listened = 0;        ///< measurements met while it must not command
  std::int64_t worst_wake_up_ns = 0;  ///< past the deadline
  std::int64_t worst_compute_ns = 0;  ///< of Answer::answer
  std::int64_t wall_time_ns = 0;      ///< from the first sample to the last
};

}  // namespace stillframe::controller

#pragma once

#include <cstdint>
#include <optional>

#include "controller/answer.hpp"
#include "controller/lcm_io.hpp"
#include "controller/outcome.hpp"

namespace stillframe::controller {

/// What both modes do with the messages of a run: answer a measurement, count, see the end.
/// Construction is set-up; the rest is hot: noexcept, no allocation.
class Server {
 public:
  /// All arguments outlive the server. timeout_s: s without a word from the plant.
  Server(LcmIo& io, Answer& answer, double timeout_s, Counters& counters) noexcept;

  /// Answers the measurement that io holds, or repeats the last command if it is the last one
  /// again.
  void answer_measurement() noexcept;

  /// The end of the run if the plant has just told it.
  std::optional<Outcome> told_end() noexcept;

  /// The end of the run by silence or by a signal.
  std::optional<Outcome> broken_off() const noexcept;

 private:
  LcmIo& io_;
  Answer& answer_;
  Counters& counters_;
  std::int64_t limit_ns_;
  std::int64_t last_seq_ = -1;
  std::int64_t first_ns_ = 0;
};

}  // namespace stillframe::controller

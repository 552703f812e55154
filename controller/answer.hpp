#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "controller/law.hpp"
#include "controller/limits.hpp"
#include "stillframe_msgs/command_t.hpp"
#include "stillframe_msgs/measurement_t.hpp"

namespace stillframe::controller {

/// One measurement in, one command out: finiteness, the law (over the samples that were missed,
/// told by seq), finiteness again, the last gate. A value that is not finite, before or after the
/// law, commands zero force and is counted; after the law it also sets the law back to rest,
/// because its state is lost. Construction is set-up; answer is hot: noexcept, no allocation.
class Answer {
 public:
  /// active: false commands zero force and never runs the law. Errors: std::invalid_argument.
  Answer(DiscreteLaw law, std::optional<double> force_limit, bool active);

  /// Writes the command (N) for a measurement of the law's number of legs; command.force has that
  /// size already (prepare).
  void answer(const stillframe_msgs::measurement_t& measurement,
              stillframe_msgs::command_t& command) noexcept;

  /// Gives a command message its size. Set-up.
  void prepare(stillframe_msgs::command_t& command) const;

  std::int64_t n_fallback() const noexcept { return n_fallback_; }  ///< zero forces for safety
  std::int64_t n_saturated() const noexcept {
    return n_saturated_;
  }  ///< commands that were limited

 private:
  Law law_;
  Limits limits_;
  bool active_;
  std::int64_t n_fallback_ = 0, n_saturated_ = 0, last_seq_ = -1;
};

}  // namespace stillframe::controller

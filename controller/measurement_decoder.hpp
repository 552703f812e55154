#pragma once

#include <lcm/lcm-cpp.hpp>

#include "stillframe_msgs/measurement_t.hpp"
#include "stillframe_msgs/run_info_t.hpp"

namespace stillframe::controller {

/// Takes the measurements of one plant and run out of what comes on the bus, into one message that
/// it keeps. Identity and sizes are read before decoding: another plant's measurement must not
/// overwrite one that waits to be answered, and a damaged one must not give the vectors whatever
/// size it claims. follow is set-up; decode is hot: noexcept, no allocation.
class MeasurementDecoder {
 public:
  enum class Result { taken, other_run, malformed };

  /// Fixes run, plant and sizes.
  void follow(const stillframe_msgs::run_info_t& info);
  Result decode(const lcm::ReceiveBuffer& buffer) noexcept;
  const stillframe_msgs::measurement_t& message() const noexcept { return message_; }

 private:
  bool has_run_sizes(const lcm::ReceiveBuffer& buffer) const noexcept;

  std::int64_t run_id_ = 0, plant_instance_ = 0;
  stillframe_msgs::measurement_t message_;
};

}  // namespace stillframe::controller

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "controller/supervisor.hpp"

namespace stillframe::controller {

/// One period of the loop, all that decided its command and when; msgs/loop_record_t.lcm.
struct LoopRecord {
  std::int64_t period = 0, n_elapsed = 1;
  std::int64_t deadline_ns = 0, wake_up_ns = 0, computed_ns = 0, published_ns = 0;
  State state = State::idle;
  Fault fault = Fault::none;
  Defect defect = Defect::missing;  ///< none: the measurement was answered
  Request request = Request::none;
  bool sent = false;
  Measurement measurement;  ///< only with defect none
  Command command;
  Eigen::VectorXd excitation;  ///< m, N, what was added to the law's force in it
};

/// The supervisor's memory before a period; msgs/loop_checkpoint_t.lcm.
struct LoopCheckpoint {
  std::int64_t period = 0;
  std::vector<double> memory;
};

}  // namespace stillframe::controller

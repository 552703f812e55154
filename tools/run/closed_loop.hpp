#pragma once

#include "controller/answer.hpp"
#include "controller/gains.hpp"
#include "plant_sim/command_queue.hpp"
#include "plant_sim/plant.hpp"

namespace stillframe::tools {

/// Plant and controller of a lock-step run in one program, without LCM: the same Plant,
/// CommandQueue and Answer as the two processes have, in the same order, so that every number is
/// the same to the bit. Set-up: construction. step() is hot as Plant::advance and Answer are.
class ClosedLoop {
 public:
  /// active: false commands zero force. Errors: as Plant.
  ClosedLoop(const Scene& scene, const controller::Gains& gains,
             std::unique_ptr<floor::FloorSource> floor, std::int64_t run_id, bool active);

  /// One sample: reads the instruments, answers, moves on. Answers an empty text, or why the motion
  /// cannot go on; the measurement and the command of the sample are there either way.
  std::string step();

  const stillframe_msgs::measurement_t& measurement() const { return measurement_; }
  const stillframe_msgs::command_t& command() const { return command_; }
  /// The plant, for what it says of itself.
  const Plant& plant() const { return plant_; }
  const controller::Answer& answer() const { return answer_; }
  /// The longest that the plant and the controller took over their part of a sample, ns.
  std::int64_t worst_plant_ns() const { return worst_plant_ns_; }
  std::int64_t worst_answer_ns() const { return worst_answer_ns_; }

 private:
  void measure();

  double sample_rate_hz_;
  Plant plant_;
  CommandQueue queue_;
  controller::Answer answer_;
  stillframe_msgs::measurement_t measurement_;
  stillframe_msgs::command_t command_;
  Eigen::VectorXd force_;
  std::int64_t worst_plant_ns_ = 0, worst_answer_ns_ = 0;
};

}  // namespace stillframe::tools

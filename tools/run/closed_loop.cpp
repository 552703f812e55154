#include "tools/run/closed_loop.hpp"

#include <algorithm>

#include "controller/law.hpp"
#include "msgs/clock.hpp"
#include "plant_sim/measurement_message.hpp"

namespace stillframe::tools {

ClosedLoop::ClosedLoop(const Scene& scene, const controller::Gains& gains,
                       std::unique_ptr<floor::FloorSource> floor, std::int64_t run_id, bool active)
    : sample_rate_hz_(gains.sample_rate_hz),
      plant_(scene, std::move(floor)),
      queue_(gains.n_legs(), gains.delay_samples),
      answer_(controller::law_from_gains(gains), gains.force_limit_n, active) {
  measurement_.run_id = run_id;
  measurement_.plant_instance = measurement_.controller_instance = 0;
  answer_.prepare(command_);
}

void ClosedLoop::measure() {
  write_measurement(plant_.read(), plant_.sample(), sample_rate_hz_, measurement_);
}

std::string ClosedLoop::step() {
  const auto advance = [this] {
    return plant_.advance(queue_.before(), queue_.after(), queue_.fraction());
  };
  const std::int64_t begin = monotonic_ns();
  measure();
  const std::int64_t asked = monotonic_ns();
  answer_.answer(measurement_, command_);
  const std::int64_t answered = monotonic_ns();
  std::string reason;
  if (!queue_.needs_answer()) reason = advance();
  force_ = Eigen::Map<const Eigen::VectorXd>(command_.force.data(), command_.n_legs);
  queue_.push(force_);
  if (queue_.needs_answer()) reason = advance();
  worst_answer_ns_ = std::max(worst_answer_ns_, answered - asked);
  worst_plant_ns_ = std::max(worst_plant_ns_, monotonic_ns() - answered + asked - begin);
  return reason;
}

}  // namespace stillframe::tools

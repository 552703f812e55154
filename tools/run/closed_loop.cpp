#include "tools/run/closed_loop.hpp"

#include <cmath>

#include "controller/law.hpp"

namespace stillframe::tools {

namespace {

void copy(const Eigen::VectorXd& from, std::int32_t& count, std::vector<double>& to) {
  count = static_cast<std::int32_t>(from.size());
  to.assign(from.begin(), from.end());
}

}  // namespace

ClosedLoop::ClosedLoop(const Scene& scene, const controller::Gains& gains,
                       std::unique_ptr<floor::FloorSource> floor, std::int64_t run_id, bool active)
    : period_ns_(1e9 / gains.sample_rate_hz),
      plant_(scene, std::move(floor)),
      queue_(gains.n_legs(), gains.delay_samples),
      answer_(controller::law_from_gains(gains), gains.force_limit_n, active) {
  measurement_.run_id = run_id;
  answer_.prepare(command_);
}

void ClosedLoop::measure() {
  const Reading& reading = plant_.read();
  measurement_.seq = plant_.sample();
  measurement_.time_ns = std::llround(static_cast<double>(plant_.sample()) * period_ns_);
  copy(reading.floor_acceleration, measurement_.n_floor, measurement_.floor_acceleration);
  copy(reading.sigma, measurement_.n_legs, measurement_.sigma);
  copy(reading.applied_force, measurement_.n_legs, measurement_.applied_force);
  copy(reading.frame_acceleration, measurement_.n_frame, measurement_.frame_acceleration);
}

std::string ClosedLoop::step() {
  const auto advance = [this] {
    return plant_.advance(queue_.before(), queue_.after(), queue_.fraction());
  };
  measure();
  answer_.answer(measurement_, command_);
  std::string reason;
  if (!queue_.needs_answer()) reason = advance();
  force_ = Eigen::Map<const Eigen::VectorXd>(command_.force.data(), command_.n_legs);
  queue_.push(force_);
  if (queue_.needs_answer()) reason = advance();
  return reason;
}

}  // namespace stillframe::tools

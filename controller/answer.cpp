#include "controller/answer.hpp"

#include <utility>

namespace stillframe::controller {

using Eigen::Map;
using Eigen::VectorXd;

Answer::Answer(DiscreteLaw law, std::optional<double> force_limit, bool active)
    : law_(std::move(law)),
      // Without a rate or a power the gate does not depend on the sample time.
      limits_(force_limit, Policy{}, law_.n_legs(), 1.0),
      active_(active) {}

void Answer::prepare(stillframe_msgs::command_t& command) const {
  command.instance = command.sent_ns = 0;
  command.n_legs = static_cast<std::int32_t>(law_.n_legs());
  command.force.assign(static_cast<size_t>(law_.n_legs()), 0.0);
}

void Answer::answer(const stillframe_msgs::measurement_t& measurement,
                    stillframe_msgs::command_t& command) noexcept {
  const Map<const VectorXd> sigma(measurement.sigma.data(), law_.n_legs());
  const Map<const VectorXd> applied(measurement.applied_force.data(), law_.n_legs());
  const Map<const VectorXd> floor(measurement.floor_acceleration.data(),
                                  std::ssize(measurement.floor_acceleration));
  Map<VectorXd> force(command.force.data(), law_.n_legs());
  command.run_id = measurement.run_id;
  command.plant_instance = measurement.plant_instance;
  command.seq = measurement.seq;
  command.time_ns = measurement.time_ns;
  command.saturated = 0;
  force.setZero();
  if (!sigma.allFinite() || !applied.allFinite()) {
    ++n_fallback_;
    return;
  }
  if (!active_) return;
  const std::int64_t n = last_seq_ < 0 ? 1 : measurement.seq - last_seq_;
  law_.hear_floor(n, floor);
  law_.step_over(n, sigma, applied, force);
  last_seq_ = measurement.seq;
  if (!force.allFinite() || !law_.state().allFinite()) {
    force.setZero();
    law_.reset();
    law_.rest_floor();
    ++n_fallback_;
    return;
  }
  if (limits_.pass(force).limited) {
    command.saturated = 1;
    ++n_saturated_;
  }
}

}  // namespace stillframe::controller

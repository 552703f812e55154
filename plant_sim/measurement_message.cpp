#include "plant_sim/measurement_message.hpp"

#include <cmath>

namespace stillframe {

namespace {

void copy(const Eigen::VectorXd& from, std::int32_t& count, std::vector<double>& to) {
  count = static_cast<std::int32_t>(from.size());
  to.assign(from.begin(), from.end());
}

}  // namespace

void write_measurement(const Reading& reading, std::int64_t k, double sample_rate_hz,
                       stillframe_msgs::measurement_t& message) {
  const double period_ns = 1e9 / sample_rate_hz;
  message.seq = k;
  message.time_ns = std::llround(static_cast<double>(k) * period_ns);
  copy(reading.floor_acceleration, message.n_floor, message.floor_acceleration);
  copy(reading.sigma, message.n_legs, message.sigma);
  copy(reading.applied_force, message.n_legs, message.applied_force);
  copy(reading.frame_acceleration, message.n_frame, message.frame_acceleration);
}

}  // namespace stillframe

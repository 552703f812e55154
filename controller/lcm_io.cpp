#include "controller/lcm_io.hpp"

#include <array>

#include "msgs/channels.hpp"
#include "msgs/clock.hpp"
#include "msgs/lcm_bus.hpp"
#include "stillframe_msgs/timing_t.hpp"

namespace stillframe::controller {

using stillframe_msgs::run_state_t;
using stillframe_msgs::timing_t;

namespace {

constexpr const char* plant_source = "plant";
constexpr const char* controller_source = "controller";

}  // namespace

LcmIo::LcmIo(const std::string& url)
    : lcm_(open_lcm(url)), command_channel_(channels::command), last_heard_ns_(monotonic_ns()) {
  lcm_->subscribe(channels::run_info, &LcmIo::on_run_info, this);
  lcm_->subscribe(channels::run_state, &LcmIo::on_run_state, this);
  // A full queue drops the newest message, not the oldest: leave room for a stall of a second or
  // so.
  lcm_->subscribe(channels::measurement, &LcmIo::on_measurement, this)->setQueueCapacity(4096);
}

Heard LcmIo::take(int timeout_ms) noexcept {
  heard_ = {};
  heard_.message = handle_one(*lcm_, timeout_ms);
  return heard_;
}

void LcmIo::follow(const stillframe_msgs::run_info_t& info) {
  run_id_ = info.run_id;
  measurement_.n_floor = info.n_floor;
  measurement_.n_legs = info.n_legs;
  measurement_.n_frame = info.n_frame;
  measurement_.floor_acceleration.resize(static_cast<size_t>(info.n_floor));
  measurement_.sigma.resize(static_cast<size_t>(info.n_legs));
  measurement_.applied_force.resize(static_cast<size_t>(info.n_legs));
  measurement_.frame_acceleration.resize(static_cast<size_t>(info.n_frame));
  command_.n_legs = info.n_legs;
  command_.force.assign(static_cast<size_t>(info.n_legs), 0.0);
  command_bytes_.resize(static_cast<size_t>(command_.getEncodedSize()));
  following_ = true;
}

void LcmIo::publish_command() noexcept {
  n_command_bytes_ =
      command_.encode(command_bytes_.data(), 0, static_cast<int>(command_bytes_.size()));
  repeat_command();
}

void LcmIo::repeat_command() noexcept {
  if (n_command_bytes_ <= 0) return;
  lcm_->publish(command_channel_, command_bytes_.data(), static_cast<unsigned>(n_command_bytes_));
}

void LcmIo::publish_state(std::int64_t run_id, std::int32_t state, const std::string& text) {
  const run_state_t message{.run_id = run_id,
                            .source = controller_source,
                            .state = state,
                            .start_monotonic_ns = 0,
                            .text = text};
  lcm_->publish(channels::run_state, &message);
}

void LcmIo::publish_timing(const Counters& counters) {
  const timing_t message{.run_id = run_id_,
                         .source = controller_source,
                         .n_periods = counters.n_periods,
                         .n_late = counters.n_late,
                         .n_lost = counters.n_lost,
                         .n_duplicate = counters.n_duplicate,
                         .worst_wake_up_ns = counters.worst_wake_up_ns,
                         .worst_compute_ns = counters.worst_compute_ns,
                         .wall_time_ns = counters.wall_time_ns};
  lcm_->publish(channels::timing, &message);
}

void LcmIo::on_run_info(const lcm::ReceiveBuffer* buffer, const std::string&) {
  // Once a run is followed its run_info is settled; a repetition only asks for an answer.
  stillframe_msgs::run_info_t message;
  if (!decode(*buffer, message)) {
    ++n_malformed_;
    return;
  }
  if (following_ && message.run_id != run_id_) return;
  if (!following_) run_info_ = std::move(message);
  heard_.run_info = true;
  last_heard_ns_ = monotonic_ns();
}

void LcmIo::on_run_state(const lcm::ReceiveBuffer* buffer, const std::string&) {
  run_state_t message;
  if (!decode(*buffer, message)) {
    ++n_malformed_;
    return;
  }
  if (message.source != plant_source || !following_ || message.run_id != run_id_) return;
  plant_state_ = std::move(message);
  heard_.run_state = true;
  last_heard_ns_ = monotonic_ns();
}

void LcmIo::on_measurement(const lcm::ReceiveBuffer* buffer, const std::string&) {
  if (!following_ || !is_of_run(*buffer)) return;
  if (!has_run_sizes(*buffer) || !decode(*buffer, measurement_)) {
    ++n_malformed_;
    return;
  }
  heard_.measurement = true;
  last_heard_ns_ = monotonic_ns();
}

// Run and sizes are read before decoding: another run's measurement must not overwrite one that
// waits to be answered, and a damaged one must not give the vectors whatever size it claims.
bool LcmIo::is_of_run(const lcm::ReceiveBuffer& buffer) const noexcept {
  constexpr int offset = 8;  // after the fingerprint
  std::int64_t run_id = 0;
  return __int64_t_decode_array(buffer.data, offset, static_cast<int>(buffer.data_size) - offset,
                                &run_id, 1) > 0 &&
         run_id == run_id_;
}

bool LcmIo::has_run_sizes(const lcm::ReceiveBuffer& buffer) const noexcept {
  constexpr int offset = 8 + 3 * 8;  // fingerprint, run_id, seq, time_ns
  if (static_cast<int>(buffer.data_size) != measurement_.getEncodedSize()) return false;
  std::array<std::int32_t, 3> sizes{};
  __int32_t_decode_array(buffer.data, offset, 12, sizes.data(), 3);
  return sizes[0] == measurement_.n_floor && sizes[1] == measurement_.n_legs &&
         sizes[2] == measurement_.n_frame;
}

}  // namespace stillframe::controller

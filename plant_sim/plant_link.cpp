#include "plant_sim/plant_link.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "msgs/channels.hpp"
#include "msgs/lcm_bus.hpp"
#include "plant_sim/measurement_message.hpp"

namespace stillframe {

using namespace stillframe_msgs;

PlantLink::PlantLink(const std::string& url, run_info_t info)
    : lcm_(open_lcm(url)),
      info_(std::move(info)),
      last_allowed_(info_.mode == "wall_clock" ? -1 : std::numeric_limits<std::int64_t>::max()),
      commands_(info_.n_legs) {
  // A full queue drops the newest message, not the oldest: leave room for a stall of a second or
  // so.
  lcm_->subscribe(channels::command, &PlantLink::on_command, this)->setQueueCapacity(4096);
  lcm_->subscribe(channels::run_state, &PlantLink::on_state, this);
}

template <class Message>
void PlantLink::publish(const char* channel, const Message& message) {
  bytes_.resize(static_cast<size_t>(message.getEncodedSize()));
  message.encode(bytes_.data(), 0, static_cast<int>(bytes_.size()));
  send(channel, bytes_);
}

void PlantLink::send(const char* channel, const std::vector<std::uint8_t>& bytes) {
  lcm_->publish(channel, bytes.data(), static_cast<unsigned>(bytes.size()));
  if (pacer_) pacer_->sent(bytes.size(), std::strlen(channel));
}

void PlantLink::pace_by(const std::filesystem::path& log) {
  pacer_.emplace(log, [this] { send(channels::logger_check, {}); });
}

bool PlantLink::begin_pacing() { return !pacer_ || pacer_->begin(); }

bool PlantLink::wait_for_log() noexcept { return !pacer_ || pacer_->wait(); }

void PlantLink::publish_info() { publish(channels::run_info, info_); }

void PlantLink::publish_state(std::int32_t state, std::int64_t start_monotonic_ns,
                              const std::string& text) {
  run_state_t message;
  message.run_id = info_.run_id;
  message.source = "plant";
  message.state = state;
  message.start_monotonic_ns = start_monotonic_ns;
  message.text = text;
  publish(channels::run_state, message);
}

void PlantLink::publish_timing(const timing_t& timing) { publish(channels::timing, timing); }

void PlantLink::publish_measurement(std::int64_t k, const Reading& reading) {
  measurement_.run_id = info_.run_id;
  write_measurement(reading, k, info_.sample_rate_hz, measurement_);
  measurement_bytes_.resize(static_cast<size_t>(measurement_.getEncodedSize()));
  measurement_.encode(measurement_bytes_.data(), 0, static_cast<int>(measurement_bytes_.size()));
  repeat_measurement();
}

void PlantLink::repeat_measurement() { send(channels::measurement, measurement_bytes_); }

bool PlantLink::listen(int timeout_ms) noexcept { return handle_one(*lcm_, timeout_ms); }

void PlantLink::on_command(const lcm::ReceiveBuffer* buffer, const std::string& channel) {
  if (pacer_) pacer_->sent(buffer->data_size, channel.size());
  if (!decode(*buffer, command_)) {
    ++n_malformed_;
    return;
  }
  if (command_.run_id != info_.run_id) return;
  const bool finite = std::all_of(command_.force.begin(), command_.force.end(),
                                  [](double force) { return std::isfinite(force); });
  if (command_.n_legs != info_.n_legs || !finite || command_.seq > last_allowed_) {
    ++n_malformed_;
    return;
  }
  const Eigen::Map<const Eigen::VectorXd> force(command_.force.data(), info_.n_legs);
  switch (commands_.add(command_.seq, force)) {
    case CommandTrack::Result::taken:
      ++n_commands_;
      return;
    case CommandTrack::Result::duplicate:
      ++n_duplicate_;
      return;
    case CommandTrack::Result::too_many:
      ++n_malformed_;
  }
}

void PlantLink::on_state(const lcm::ReceiveBuffer* buffer, const std::string&) {
  run_state_t state;
  if (!decode(*buffer, state) || state.run_id != info_.run_id || state.source != "controller")
    return;
  if (state.state == run_state_t::READY) controller_ready_ = true;
  if (state.state == run_state_t::FAILED)
    controller_failure_ = "the controller refused: " + state.text;
}

}  // namespace stillframe

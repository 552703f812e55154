#include "controller/controller_link.hpp"

#include <poll.h>

#include <algorithm>
#include <future>
#include <utility>

#include "controller/realtime.hpp"
#include "msgs/channels.hpp"
#include "msgs/clock.hpp"
#include "msgs/clock_bus.hpp"
#include "msgs/identity.hpp"
#include "msgs/lcm_bus.hpp"

namespace stillframe::controller {

using stillframe_msgs::run_state_t;
using stillframe_msgs::timing_t;

namespace {

constexpr const char* plant_source = "plant";
constexpr const char* controller_source = "controller";

constexpr std::size_t most_announced = 16;

/// The thread of liblcm that reads the socket has the priority of the one that makes it: requests
/// to stop come through it.
std::unique_ptr<lcm::LCM> open_served(const std::string& url, const Policy& policy) {
  return std::async(std::launch::async,
                    [&] {
                      prepare_servant(policy);
                      auto lcm = open_lcm(url);
                      require_hearing(*lcm);
                      return lcm;
                    })
      .get();
}

}  // namespace

ControllerLink::ControllerLink(const std::string& url, const Policy& policy)
    : url_(url),
      policy_(policy),
      instance_(new_instance()),
      clocks_(instance_),
      command_channel_(channels::command),
      last_heard_ns_(monotonic_ns()) {
  hear_lcm();
}

void ControllerLink::hear_lcm() {
  lcm_ = open_served(url_, policy_);
  lcm_->subscribe(channels::run_info, &ControllerLink::on_run_info, this);
  lcm_->subscribe(channels::run_state, &ControllerLink::on_run_state, this);
  // A full queue drops the newest message, not the oldest: leave room for a stall of a second or
  // so.
  measurement_subscription_ =
      lcm_->subscribe(channels::measurement, &ControllerLink::on_measurement, this);
  measurement_subscription_->setQueueCapacity(4096);
  lcm_->subscribe(channels::request, &ControllerLink::on_request, this);
  lcm_->subscribe(channels::status, &ControllerLink::on_status, this);
  lcm_->subscribe(channels::clock, &ControllerLink::on_clock, this);
}

void ControllerLink::stop_measurements() {
  if (measurement_subscription_ == nullptr) return;
  lcm_->unsubscribe(measurement_subscription_);
  measurement_subscription_ = nullptr;
}

Heard ControllerLink::take(int timeout_ms) noexcept {
  heard_ = {};
  if (!line_) {
    heard_.message = handle_one(*lcm_, timeout_ms);
    ask_clocks(*lcm_, clocks_);
    return heard_;
  }
  if (!direct_) {
    pollfd ready[] = {{.fd = line_->descriptor(), .events = POLLIN, .revents = 0},
                      {.fd = lcm_->getFileno(), .events = POLLIN, .revents = 0}};
    poll(ready, 2, timeout_ms);
    timeout_ms = 0;
    if (ready[0].revents == 0) {
      heard_.message = handle_one(*lcm_, 0);
      return heard_;
    }
  }
  try {
    take_line(timeout_ms);
  } catch (const std::exception&) {
    // LCM is not to be had any more: nothing is heard, and the run ends for that.
  }
  return heard_;
}

void ControllerLink::take_line(int timeout_ms) {
  switch (line_->take(timeout_ms)) {
    case DirectLine::Came::nothing:
      return;
    case DirectLine::Came::end:
      line_.reset();
      if (std::exchange(direct_, false)) hear_lcm();
      return;
    case DirectLine::Came::message:
      break;
  }
  if (!std::exchange(direct_, true)) {
    measurement_subscription_ = nullptr;
    lcm_ = open_lcm(url_);
  }
  heard_.message = true;
  const lcm::ReceiveBuffer buffer = buffer_of(line_->bytes());
  if (line_->channel() == channels::measurement) on_measurement(&buffer, command_channel_);
  if (line_->channel() == channels::run_state) on_run_state(&buffer, command_channel_);
}

void ControllerLink::follow(const stillframe_msgs::run_info_t& info) {
  run_id_ = info.run_id;
  plant_instance_ = info.plant_instance;
  measurements_.follow(info);
  command_.instance = instance_;
  command_.sent_ns = 0;
  command_.n_legs = info.n_legs;
  command_.force.assign(static_cast<size_t>(info.n_legs), 0.0);
  command_bytes_.resize(static_cast<size_t>(command_.getEncodedSize()));
  if (info.mode == "lock_step") line_ = DirectLine::to(info.plant_instance);
  following_ = true;
}

void ControllerLink::host(const stillframe_msgs::run_info_t& info) {
  run_info_ = info;
  hosts_ = true;
  follow(info);
}

void ControllerLink::publish_plant_state(std::int32_t state, std::int64_t start_ns) {
  const run_state_t message{.run_id = run_id_,
                            .plant_instance = plant_instance_,
                            .instance = plant_instance_,
                            .sent_ns = monotonic_ns(),
                            .source = plant_source,
                            .state = state,
                            .start_monotonic_ns = start_ns,
                            .text = ""};
  lcm_->publish(channels::run_state, &message);
}

void ControllerLink::announce(std::int64_t start_ns) {
  publish_plant_state(run_state_t::RUNNING, start_ns);
  lcm_->publish(channels::run_info, &run_info_);
}

void ControllerLink::publish_end() { publish_plant_state(run_state_t::ENDED, 0); }

void ControllerLink::publish_samples(const LoopRecord& record) {
  const auto list = [](const Eigen::VectorXd& v) {
    return std::vector<double>(v.begin(), v.end());
  };
  if (record.defect == Defect::none) {
    const Measurement& from = record.measurement;
    stillframe_msgs::measurement_t message;
    message.run_id = run_id_;
    message.plant_instance = plant_instance_;
    message.controller_instance = from.heard ? instance_ : 0;
    message.seq = from.seq;
    message.time_ns = from.time_ns;
    message.n_floor = static_cast<std::int32_t>(from.floor.size());
    message.n_legs = static_cast<std::int32_t>(from.sigma.size());
    message.n_frame = static_cast<std::int32_t>(from.frame.size());
    message.floor_acceleration = list(from.floor);
    message.sigma = list(from.sigma);
    message.applied_force = list(from.applied);
    message.frame_acceleration = list(from.frame);
    lcm_->publish(channels::measurement, &message);
  }
  if (!record.sent) return;
  command_.run_id = run_id_;
  command_.plant_instance = plant_instance_;
  command_.seq = record.command.seq;
  command_.time_ns = record.command.time_ns;
  command_.sent_ns = record.published_ns;
  command_.force = list(record.command.force);
  command_.saturated = record.command.saturated ? 1 : 0;
  lcm_->publish(channels::command, &command_);
}

void ControllerLink::publish_command() noexcept {
  n_command_bytes_ =
      command_.encode(command_bytes_.data(), 0, static_cast<int>(command_bytes_.size()));
  repeat_command();
}

void ControllerLink::repeat_command() noexcept {
  if (n_command_bytes_ <= 0) return;
  lcm_->publish(command_channel_, command_bytes_.data(), static_cast<unsigned>(n_command_bytes_));
  // A plant that does not read it is gone, which the next take finds out.
  if (direct_) {
    line_->send(channels::command, command_bytes_.data(), static_cast<size_t>(n_command_bytes_));
  }
}

void ControllerLink::publish_state(std::int64_t run_id, std::int32_t state,
                                   const std::string& text) {
  const run_state_t message{.run_id = run_id,
                            .plant_instance = run_info_.plant_instance,
                            .instance = instance_,
                            .sent_ns = monotonic_ns(),
                            .source = controller_source,
                            .state = state,
                            .start_monotonic_ns = 0,
                            .text = text};
  lcm_->publish(channels::run_state, &message);
  if (!direct_) return;
  std::vector<std::uint8_t> bytes(static_cast<size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  line_->send(channels::run_state, bytes.data(), bytes.size());
}

void ControllerLink::publish_timing(timing_t counters) {
  counters.run_id = run_id_;
  counters.source = controller_source;
  lcm_->publish(channels::timing, &counters);
}

void ControllerLink::on_run_info(const lcm::ReceiveBuffer* buffer, const std::string&) {
  // Once a run is followed its run_info is settled; a repetition only asks for an answer.
  stillframe_msgs::run_info_t message;
  if (!decode(*buffer, message)) {
    ++n_malformed_;
    return;
  }
  if (!is_announced(message)) return;
  if (following_ && !is_followed(message.run_id, message.plant_instance)) {
    (message.run_id == run_id_ ? heard_.other_plant : heard_.other_run) = true;
    return;
  }
  if (!following_) run_info_ = std::move(message);
  heard_.run_info = true;
  last_heard_ns_ = monotonic_ns();
}

void ControllerLink::on_run_state(const lcm::ReceiveBuffer* buffer, const std::string&) {
  run_state_t message;
  if (!decode(*buffer, message)) {
    ++n_malformed_;
    return;
  }
  if (message.source != plant_source) return;
  note_announced(message);
  if (!following_ || !is_followed(message.run_id, message.plant_instance)) return;
  plant_state_ = std::move(message);
  heard_.run_state = true;
  last_heard_ns_ = monotonic_ns();
}

/// Remembers which plants have just said that they are there.
void ControllerLink::note_announced(const run_state_t& state) {
  const auto same = [&](const Announced& a) {
    return a.run_id == state.run_id && a.plant_instance == state.plant_instance;
  };
  std::erase_if(announced_, same);
  const bool there = state.state == run_state_t::WAITING || state.state == run_state_t::RUNNING;
  if (!there || !clocks_.is_fresh(state.plant_instance, state.sent_ns, monotonic_ns())) return;
  if (announced_.size() == most_announced) announced_.erase(announced_.begin());
  announced_.push_back({state.run_id, state.plant_instance, state.sent_ns});
}

// A recorded run_info says the same as a live one, but nobody stands behind it.
bool ControllerLink::is_announced(const stillframe_msgs::run_info_t& info) {
  const std::int64_t now = monotonic_ns();
  return std::any_of(announced_.begin(), announced_.end(), [&](const Announced& a) {
    return a.run_id == info.run_id && a.plant_instance == info.plant_instance &&
           clocks_.is_fresh(a.plant_instance, a.sent_ns, now);
  });
}

bool ControllerLink::is_followed(std::int64_t run_id, std::int64_t plant_instance) const noexcept {
  return run_id == run_id_ && plant_instance == plant_instance_;
}

void ControllerLink::on_request(const lcm::ReceiveBuffer* buffer, const std::string&) {
  if (!decode(*buffer, request_)) {
    ++n_malformed_;
    return;
  }
  heard_.request = request_.run_id == 0 || (following_ && request_.run_id == run_id_);
}

void ControllerLink::on_status(const lcm::ReceiveBuffer* buffer, const std::string&) {
  if (!decode(*buffer, other_status_)) {
    ++n_malformed_;
    return;
  }
  heard_.other_status =
      following_ && is_followed(other_status_.run_id, other_status_.plant_instance) &&
      other_status_.instance != instance_ &&
      clocks_.is_fresh(other_status_.instance, other_status_.sent_ns, monotonic_ns());
}

void ControllerLink::on_clock(const lcm::ReceiveBuffer* buffer, const std::string&) {
  if (!take_clock(*lcm_, clocks_, *buffer)) ++n_malformed_;
}

std::optional<PeerClocks::Instant> ControllerLink::start(std::int64_t said_ns) {
  return clocks_.instant(plant_instance_, said_ns, monotonic_ns());
}

bool ControllerLink::is_elsewhere() const noexcept {
  return !on_one_clock(plant_instance_, instance_);
}

// Of whom asks from another host both times are taken as early as they can have been, so that none
// of them is yet to come.
bool ControllerLink::admits_request() {
  const std::int64_t now = monotonic_ns();
  const auto sent = clocks_.instant(request_.nonce, request_.sent_ns, now);
  const auto asked = clocks_.instant(request_.nonce, request_.asked_ns, now);
  if (!sent || !asked) return false;
  request_.sent_ns = sent->earliest_ns;
  request_.asked_ns = asked->earliest_ns;
  return requests_.admits(request_, now);
}

void ControllerLink::on_measurement(const lcm::ReceiveBuffer* buffer, const std::string&) {
  if (!following_) return;
  switch (measurements_.decode(*buffer)) {
    case MeasurementDecoder::Result::other_run:
      return;
    case MeasurementDecoder::Result::malformed:
      ++n_malformed_;
      return;
    case MeasurementDecoder::Result::taken:
      heard_.measurement = true;
      last_heard_ns_ = monotonic_ns();
  }
}

}  // namespace stillframe::controller

#include "controller/lcm_stream.hpp"

#include <Eigen/Core>

#include "controller/realtime.hpp"
#include "msgs/channels.hpp"
#include "msgs/clock.hpp"
#include "msgs/lcm_bus.hpp"

namespace stillframe::controller {

using Eigen::Map;
using Eigen::VectorXd;

namespace {

// A second and more of measurements at any rate up to 4 kHz; the loop empties it every period.
constexpr std::size_t n_measurements = 4096, n_commands = 256;
constexpr int look_up_ms = 50;  // between looks at the stop flag

}  // namespace

LcmStream::LcmStream(const std::string& url, const stillframe_msgs::run_info_t& info,
                     std::int64_t instance, const Policy& policy)
    : in_(open_lcm(url)),
      out_(open_lcm(url)),
      measurements_(n_measurements, measurement_of(info.n_legs, info.n_floor)),
      commands_(n_commands, command_of(info.n_legs)) {
  decoder_.follow(info);
  message_.run_id = info.run_id;
  message_.plant_instance = info.plant_instance;
  message_.instance = instance;
  message_.n_legs = info.n_legs;
  message_.force.assign(static_cast<size_t>(info.n_legs), 0.0);
  bytes_.resize(static_cast<size_t>(message_.getEncodedSize()));
  sem_init(&something_to_send_, 0, 0);
  receiver_ = std::thread([this, policy] { run_receiver(policy); });
  sender_ = std::thread([this, policy] { run_sender(policy); });
  listening_.wait(false);
  if (!deaf_) return;
  end_threads();
  refuse_deaf();
}

LcmStream::~LcmStream() { end_threads(); }

void LcmStream::end_threads() {
  stop_ = true;
  sem_post(&something_to_send_);
  receiver_.join();
  sender_.join();
  sem_destroy(&something_to_send_);
}

bool LcmStream::receive(Measurement& measurement) noexcept {
  return measurements_.take(measurement);
}

void LcmStream::send(const Command& command) noexcept {
  if (commands_.give(command)) {
    sem_post(&something_to_send_);
  } else {
    ++n_commands_dropped_;
  }
}

void LcmStream::run_receiver(const Policy& policy) noexcept {
  prepare_servant(policy);
  // Here, because LCM starts its own reading thread now, which inherits the priority.
  deaf_ = in_->getFileno() < 0;
  if (!deaf_) {
    in_->subscribe(channels::measurement, &LcmStream::on_measurement, this)
        ->setQueueCapacity(n_measurements);
  }
  listening_ = true;
  listening_.notify_all();
  while (!stop_) handle_one(*in_, look_up_ms);
}

void LcmStream::on_measurement(const lcm::ReceiveBuffer* buffer, const std::string&) noexcept {
  if (decoder_.decode(*buffer) != MeasurementDecoder::Result::taken) {
    ++n_bad_;
    return;
  }
  const auto& message = decoder_.message();
  const std::int64_t now = monotonic_ns();
  note_obeyed(message.controller_instance, now);
  Measurement* place = measurements_.free_place();
  if (place == nullptr) {
    ++n_bad_;
    return;
  }
  place->seq = message.seq;
  place->time_ns = message.time_ns;
  place->received_ns = now;
  place->sigma = Map<const VectorXd>(message.sigma.data(), message.n_legs);
  place->applied = Map<const VectorXd>(message.applied_force.data(), message.n_legs);
  place->heard = message.controller_instance == message_.instance;
  place->floor = Map<const VectorXd>(message.floor_acceleration.data(), message.n_floor);
  measurements_.push();
}

void LcmStream::note_obeyed(std::int64_t controller, std::int64_t now_ns) noexcept {
  const bool another = controller != 0 && controller != message_.instance;
  if (!another) {
    obeys_another_since_ns_ = 0;
  } else if (obeys_another_since_ns_ == 0) {
    obeys_another_since_ns_ = now_ns;
  }
}

void LcmStream::run_sender(const Policy& policy) noexcept {
  prepare_servant(policy);
  while (!stop_) {
    // Interrupted by a signal it looks, finds nothing, and waits again.
    sem_wait(&something_to_send_);
    while (const Command* command = commands_.oldest()) {
      message_.seq = command->seq;
      message_.time_ns = command->time_ns;
      message_.saturated = command->saturated ? 1 : 0;
      Map<VectorXd>(message_.force.data(), message_.n_legs) = command->force;
      commands_.pop();
      message_.sent_ns = monotonic_ns();
      const int size = message_.encode(bytes_.data(), 0, static_cast<int>(bytes_.size()));
      if (size > 0) out_->publish(channels::command, bytes_.data(), static_cast<unsigned>(size));
    }
  }
}

}  // namespace stillframe::controller

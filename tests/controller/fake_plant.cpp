#include "tests/controller/fake_plant.hpp"

#include <stdexcept>
#include <utility>

#include "msgs/channels.hpp"
#include "msgs/clock.hpp"

namespace stillframe::controller::toy {

using namespace stillframe_msgs;

FakePlant::FakePlant(run_info_t info) : info_(std::move(info)) {
  if (!lcm_.good()) throw std::runtime_error("no LCM; run through scripts/private_network");
  lcm_.subscribe(channels::command, &FakePlant::on_command, this)->setQueueCapacity(0);
  lcm_.subscribe(channels::run_state, &FakePlant::on_state, this);
  lcm_.subscribe(channels::timing, &FakePlant::on_timing, this);
  lcm_.subscribe(channels::clock, &FakePlant::on_clock, this);
  const size_t m = frequencies_hz().size();
  q_.assign(m, 1e-6);
  v_.assign(m, 1e-5);
  applied_.assign(m, 0.0);
}

int FakePlant::announce() {
  for (int attempt = 0; attempt < 1000; ++attempt) {
    publish_state(run_state_t::WAITING);
    lcm_.publish(channels::run_info, &info_);
    if (is_answered()) return states.back().state;
  }
  return -1;
}

bool FakePlant::is_answered() {
  while (states.empty() && take(20)) {
  }
  return !states.empty();
}

void FakePlant::publish_state(std::int32_t state, std::int64_t start_ns, const std::string& text) {
  const run_state_t message{.run_id = info_.run_id,
                            .plant_instance = info_.plant_instance,
                            .instance = info_.plant_instance,
                            .sent_ns = monotonic_ns() + ahead_ns,
                            .source = "plant",
                            .state = state,
                            .start_monotonic_ns = start_ns,
                            .text = text};
  lcm_.publish(channels::run_state, &message);
}

void FakePlant::publish(const measurement_t& measurement) {
  lcm_.publish(channels::measurement, &measurement);
}

void FakePlant::publish_raw(const std::string& channel, const void* data, size_t size) {
  lcm_.publish(channel, data, static_cast<unsigned>(size));
}

std::optional<command_t> FakePlant::exchange(const measurement_t& measurement) {
  for (int attempt = 0; attempt < 50; ++attempt) {
    publish(measurement);
    while (take(200)) {
      if (!commands.empty() && commands.back().seq == measurement.seq) return commands.back();
    }
  }
  return std::nullopt;
}

bool FakePlant::take(int timeout_ms) { return lcm_.handleTimeout(timeout_ms) > 0; }

measurement_t FakePlant::measure(std::int64_t k) const {
  measurement_t message{};
  message.run_id = info_.run_id;
  message.plant_instance = info_.plant_instance;
  message.controller_instance = commands.empty() ? 0 : commands.back().instance;
  message.seq = k;
  message.time_ns = static_cast<std::int64_t>(static_cast<double>(k) * 1e9 / info_.sample_rate_hz);
  message.n_legs = info_.n_legs;
  message.applied_force = applied_;
  for (size_t i = 0; i < q_.size(); ++i) {
    const double w = two_pi * frequencies_hz()[i];
    message.sigma.push_back(w * w * q_[i] + applied_[i]);
  }
  return message;
}

void FakePlant::move(const std::vector<double>& force, double floor) {
  for (size_t i = 0; i < q_.size(); ++i) {
    // The floor's acceleration acts on a unit mass as a force of the leg does.
    toy::move(i, q_[i], v_[i], force[i] + floor, 1 / info_.sample_rate_hz);
  }
  applied_ = force;
}

void FakePlant::on_command(const lcm::ReceiveBuffer* buffer, const std::string&) {
  const auto* bytes = static_cast<const std::uint8_t*>(buffer->data);
  command_t message;
  if (message.decode(bytes, 0, static_cast<int>(buffer->data_size)) < 0) return;
  command_bytes.emplace_back(bytes, bytes + buffer->data_size);
  commands.push_back(message);
}

void FakePlant::on_state(const lcm::ReceiveBuffer*, const std::string&,
                         const run_state_t* message) {
  if (message->source == "controller") states.push_back(*message);
}

void FakePlant::on_clock(const lcm::ReceiveBuffer*, const std::string&,
                         const clock_exchange_t* message) {
  if (message->asked != info_.plant_instance || message->answered_ns != 0) return;
  clock_exchange_t answer = *message;
  answer.heard_ns = answer.answered_ns = monotonic_ns() + ahead_ns;
  lcm_.publish(channels::clock, &answer);
}

void FakePlant::on_timing(const lcm::ReceiveBuffer*, const std::string&, const timing_t* message) {
  if (message->source == "controller") timing = *message;
}

}  // namespace stillframe::controller::toy

#include "tests/faults/relay.hpp"

#include <poll.h>
#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "msgs/channels.hpp"
#include "msgs/clock.hpp"
#include "msgs/lcm_bus.hpp"
#include "stillframe_msgs/loop_records_t.hpp"
#include "stillframe_msgs/run_state_t.hpp"

namespace stillframe::faults {

using namespace stillframe_msgs;

namespace {

constexpr std::int64_t idle_ns = 20'000'000;  // between looks at stop_

/// Above plants and controllers: what is tested is the fault and not the relay's own lateness.
void ask_for_realtime() {
  const sched_param parameters{.sched_priority = 70};
  pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);  // best effort
}

Bytes bytes_of(const lcm::ReceiveBuffer& buffer) {
  const auto* data = static_cast<const std::uint8_t*>(buffer.data);
  return {data, data + buffer.data_size};
}

void publish(lcm::LCM& lcm, const std::string& channel, const Bytes& bytes) {
  lcm.publish(channel, bytes.data(), static_cast<unsigned>(bytes.size()));
}

/// Of the channel that has both directions: whether the message comes from there.
bool comes_from(const std::string& source, const lcm::ReceiveBuffer& buffer,
                const std::string& channel) {
  if (channel != channels::run_state) return true;
  run_state_t state;
  return decode(buffer, state) && state.source == source;
}

}  // namespace

Relay::Relay(const std::string& plant_url, const std::string& controller_url, double rate_hz)
    : measurements_(std::llround(1e9 / rate_hz)),
      commands_(std::llround(1e9 / rate_hz)),
      plant_(open_lcm(plant_url)),
      controller_(open_lcm(controller_url)),
      thread_([this] { run(); }) {}

Relay::~Relay() {
  stop_ = true;
  thread_.join();
}

void Relay::inflict(const Fault& fault, std::uint64_t seed, std::int64_t n_samples) {
  const std::lock_guard lock(mutex_);
  fault_ = fault;
  seed_ = seed;
  samples_left_ = n_samples;
  pending_ = true;
}

void Relay::follow(std::int32_t pid) {
  const std::lock_guard lock(mutex_);
  pid_ = pid;
}

void Relay::request(const control_request_t& request) {
  publish(*controller_, channels::request, encoded(request));
}

bool Relay::wait(const std::function<bool(const Trace&)>& condition, double limit_s) {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, std::chrono::duration<double>(limit_s),
                           [&] { return condition(trace_); });
}

RelayCounts Relay::counts() {
  const std::lock_guard lock(mutex_);
  return {measurements_.counts(), commands_.counts(), corruptor_.n_corrupted()};
}

void Relay::run() {
  ask_for_realtime();
  subscribe();  // here, so that LCM's own threads inherit the priority
  while (!stop_) {
    wait_for_messages();
    while (handle_one(*controller_, 0)) {
    }
    while (handle_one(*plant_, 0)) {
    }
    send_due();
  }
}

void Relay::subscribe() {
  // As many as a plant makes that catches up after a stop.
  constexpr int capacity = 10000;
  plant_->subscribe(channels::measurement, &Relay::on_measurement, this)
      ->setQueueCapacity(capacity);
  for (const char* channel : {channels::run_info, channels::run_state, channels::timing}) {
    plant_->subscribe(channel, &Relay::from_plant, this);
  }
  controller_->subscribe(channels::command, &Relay::on_command, this)->setQueueCapacity(capacity);
  controller_->subscribe(channels::status, &Relay::on_status, this);
  controller_->subscribe(channels::loop, &Relay::on_records, this)->setQueueCapacity(capacity);
  controller_->subscribe(channels::run_state, &Relay::from_controller, this);
}

void Relay::wait_for_messages() {
  std::int64_t wait_ns = idle_ns;
  {
    const std::lock_guard lock(mutex_);
    const std::int64_t next_ns = std::min(measurements_.next_ns(), commands_.next_ns());
    if (next_ns != Wire::never) {
      wait_ns = std::clamp<std::int64_t>(next_ns - monotonic_ns(), 0, idle_ns);
    }
  }
  pollfd ready[] = {{plant_->getFileno(), POLLIN, 0}, {controller_->getFileno(), POLLIN, 0}};
  const timespec timeout{.tv_sec = 0, .tv_nsec = wait_ns};
  ppoll(ready, 2, &timeout, nullptr);
}

void Relay::send_due() {
  const std::lock_guard lock(mutex_);
  const std::int64_t now_ns = monotonic_ns();
  while (const auto bytes = measurements_.take(now_ns)) {
    publish(*controller_, channels::measurement, *bytes);
  }
  while (const auto bytes = commands_.take(now_ns)) publish(*plant_, channels::command, *bytes);
}

void Relay::from_plant(const lcm::ReceiveBuffer* buffer, const std::string& channel) {
  if (comes_from("plant", *buffer, channel)) publish(*controller_, channel, bytes_of(*buffer));
}

void Relay::from_controller(const lcm::ReceiveBuffer* buffer, const std::string& channel) {
  if (comes_from("controller", *buffer, channel)) publish(*plant_, channel, bytes_of(*buffer));
}

void Relay::on_measurement(const lcm::ReceiveBuffer* buffer, const std::string&) {
  measurement_t measurement;
  if (!decode(*buffer, measurement)) return;
  const std::int64_t now_ns = monotonic_ns();
  {
    const std::lock_guard lock(mutex_);
    write_down(measurement, now_ns);
    begin_or_end(now_ns);
    for (Bytes& bytes : corruptor_.apply(bytes_of(*buffer), measurement)) {
      measurements_.pass(std::move(bytes), now_ns);
    }
  }
  send_due();
  if (measurement.seq % 10 == 0) changed_.notify_all();
}

void Relay::on_command(const lcm::ReceiveBuffer* buffer, const std::string&) {
  {
    const std::lock_guard lock(mutex_);
    commands_.pass(bytes_of(*buffer), monotonic_ns());
  }
  send_due();
}

void Relay::on_status(const lcm::ReceiveBuffer* buffer, const std::string&) {
  StatusAt at;
  if (!decode(*buffer, at.status)) return;
  {
    const std::lock_guard lock(mutex_);
    if (at.status.pid != pid_) return;
    at.run = trace_.runs.empty() ? 0 : trace_.runs.size() - 1;
    at.sample = trace_.sample();
    trace_.statuses.push_back(std::move(at));
  }
  changed_.notify_all();
}

void Relay::on_records(const lcm::ReceiveBuffer* buffer, const std::string&) {
  loop_records_t records;
  if (!decode(*buffer, records)) return;
  const std::lock_guard lock(mutex_);
  if (trace_.runs.empty()) return;
  const std::vector<std::int64_t>& arrivals = trace_.runs.back().arrival_ns;
  for (const loop_record_t& record : records.records) {
    PeriodAt at{.run = trace_.runs.size() - 1, .sample = trace_.sample(), .defect = record.defect};
    at.wake_up_ns = record.wake_up_ns - record.deadline_ns;
    const auto k = static_cast<std::size_t>(record.seq);
    if (record.defect == 0 && k < arrivals.size() && arrivals[k] > 0) {
      at.transit_ns = record.received_ns - arrivals[k];
    }
    trace_.periods.push_back(at);
  }
}

void Relay::write_down(const measurement_t& measurement, std::int64_t now_ns) {
  const auto k = static_cast<std::size_t>(measurement.seq);
  // A plant that was started again counts from 0.
  if (trace_.runs.empty() || measurement.seq < trace_.sample()) trace_.runs.emplace_back();
  RunTrace& run = trace_.runs.back();
  Accelerations unseen;
  unseen.fill(std::numeric_limits<double>::quiet_NaN());
  run.frame.resize(k + 1, unseen);
  run.arrival_ns.resize(k + 1, 0);
  std::copy_n(measurement.frame_acceleration.begin(),
              std::min<std::size_t>(unseen.size(), measurement.frame_acceleration.size()),
              run.frame[k].begin());
  run.applied.resize(k + 1, unseen);
  std::copy_n(measurement.applied_force.begin(),
              std::min<std::size_t>(unseen.size(), measurement.applied_force.size()),
              run.applied[k].begin());
  run.arrival_ns[k] = now_ns;
}

void Relay::begin_or_end(std::int64_t now_ns) {
  if (pending_) {
    measurements_.begin(fault_.measurements, seed_);
    commands_.begin(fault_.commands, seed_ + 1'000'003);
    corruptor_.begin(fault_.corruption, fault_.leg);
    pending_ = false;
  } else if (samples_left_ == 0) {
    measurements_.end(now_ns);
    commands_.end(now_ns);
    corruptor_.end();
  }
  if (samples_left_ > -1) --samples_left_;
}

}  // namespace stillframe::faults

#include "tests/stalls/watcher.hpp"

#include <chrono>

#include "controller/supervisor.hpp"
#include "msgs/channels.hpp"
#include "msgs/clock.hpp"
#include "msgs/lcm_bus.hpp"
#include "stillframe_msgs/command_t.hpp"
#include "stillframe_msgs/control_request_t.hpp"
#include "stillframe_msgs/loop_records_t.hpp"
#include "stillframe_msgs/measurement_t.hpp"

namespace stillframe::stalls {

using namespace stillframe_msgs;

namespace {

constexpr int look_up_ms = 20;
constexpr std::int64_t acted_upon = 2;  // samples; an older command is none that a plant takes
constexpr std::size_t remembered = 10'000;

std::chrono::duration<double> seconds(double s) { return std::chrono::duration<double>(s); }

}  // namespace

Watcher::Watcher(const std::string& url) : lcm_(open_lcm(url)) {
  lcm_->subscribe(channels::status, &Watcher::on_status, this)->setQueueCapacity(0);
  lcm_->subscribe(channels::loop, &Watcher::on_records, this)->setQueueCapacity(0);
  lcm_->subscribe(channels::request, &Watcher::on_request, this)->setQueueCapacity(0);
  lcm_->subscribe(channels::command, &Watcher::on_command, this)->setQueueCapacity(0);
  lcm_->subscribe(channels::measurement, &Watcher::on_measurement, this)->setQueueCapacity(0);
  thread_ = std::thread([this] {
    while (!end_) handle_one(*lcm_, look_up_ms);
  });
}

Watcher::~Watcher() {
  end_ = true;
  thread_.join();
}

std::optional<controller_status_t> Watcher::status(std::int32_t pid) {
  const std::lock_guard lock(mutex_);
  const auto found = statuses_.find(pid);
  if (found == statuses_.end()) return std::nullopt;
  return found->second;
}

bool Watcher::wait(std::int32_t pid, const std::function<bool(const controller_status_t&)>& fits,
                   double limit_s) {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, seconds(limit_s), [&] {
    const auto found = statuses_.find(pid);
    return found != statuses_.end() && fits(found->second);
  });
}

void Watcher::begin_stop(std::int32_t pid) {
  const std::lock_guard lock(mutex_);
  pid_ = pid;
  stop_began_ns_ = monotonic_ns();
  stop_heard_ns_ = 0;
  stop_ = {};
}

std::int64_t Watcher::stop_heard_ns() {
  const std::lock_guard lock(mutex_);
  return stop_heard_ns_;
}

Stop Watcher::stop(double limit_s) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, seconds(limit_s),
                    [&] { return stop_.obeyed_ns != 0 && stop_.told_ns != 0; });
  return stop_;
}

std::int64_t Watcher::n_two_forces() {
  const std::lock_guard lock(mutex_);
  return n_two_forces_;
}

std::int64_t Watcher::n_commands() {
  const std::lock_guard lock(mutex_);
  return n_commands_;
}

void Watcher::on_status(const lcm::ReceiveBuffer* buffer, const std::string&) {
  controller_status_t status;
  if (!decode(*buffer, status)) return;
  const std::lock_guard lock(mutex_);
  const bool holds = status.state == controller_status_t::ARMING ||
                     status.state == controller_status_t::RAMP_IN ||
                     status.state == controller_status_t::ACTIVE;
  // Times are those of sending: this thread is an ordinary one, and may be late itself.
  if (status.pid == pid_ && stop_began_ns_ != 0 && status.sent_ns > stop_began_ns_ &&
      stop_.told_ns == 0 && !holds) {
    stop_.told_ns = status.sent_ns;
  }
  statuses_[status.pid] = std::move(status);
  changed_.notify_all();
}

void Watcher::on_records(const lcm::ReceiveBuffer* buffer, const std::string&) {
  loop_records_t message;
  if (!decode(*buffer, message)) return;
  const std::lock_guard lock(mutex_);
  for (const loop_record_t& record : message.records) {
    const bool stops = record.request == static_cast<std::int32_t>(controller::Request::stop);
    if (!stops || stop_began_ns_ == 0 || record.computed_ns < stop_began_ns_) continue;
    if (stop_.obeyed_ns == 0) stop_.obeyed_ns = record.computed_ns;
  }
  changed_.notify_all();
}

void Watcher::on_request(const lcm::ReceiveBuffer* buffer, const std::string&) {
  control_request_t request;
  if (!decode(*buffer, request) || request.request != control_request_t::STOP) return;
  const std::lock_guard lock(mutex_);
  if (stop_heard_ns_ == 0) stop_heard_ns_ = request.sent_ns;
}

void Watcher::on_command(const lcm::ReceiveBuffer* buffer, const std::string&) {
  command_t command;
  if (!decode(*buffer, command)) return;
  const std::lock_guard lock(mutex_);
  ++n_commands_;
  if (newest_ - command.seq > acted_upon) return;
  const auto [first, is_new] = forces_.try_emplace(command.seq, command.force);
  if (!is_new && first->second != command.force) ++n_two_forces_;
  if (forces_.size() > remembered) forces_.erase(forces_.begin());
}

void Watcher::on_measurement(const lcm::ReceiveBuffer* buffer, const std::string&) {
  measurement_t measurement;
  if (!decode(*buffer, measurement)) return;
  const std::lock_guard lock(mutex_);
  newest_ = measurement.seq;
}

}  // namespace stillframe::stalls

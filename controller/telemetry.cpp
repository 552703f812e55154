#include "controller/telemetry.hpp"

#include <unistd.h>

#include "msgs/channels.hpp"
#include "msgs/clock.hpp"
#include "stillframe_msgs/excitation_t.hpp"
#include "stillframe_msgs/loop_records_t.hpp"

namespace stillframe::controller {

using stillframe_msgs::controller_status_t;
using stillframe_msgs::excitation_t;
using stillframe_msgs::loop_checkpoint_t;
using stillframe_msgs::loop_record_t;
using stillframe_msgs::loop_records_t;

namespace {

constexpr std::size_t records_a_message = 32;

std::vector<double> list(const Eigen::VectorXd& values) { return {values.begin(), values.end()}; }

Eigen::VectorXd vector(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

}  // namespace

loop_record_t to_message(const LoopRecord& record) {
  const bool have = record.defect == Defect::none;
  loop_record_t message;
  message.period = record.period;
  message.n_elapsed = record.n_elapsed;
  message.deadline_ns = record.deadline_ns;
  message.wake_up_ns = record.wake_up_ns;
  message.computed_ns = record.computed_ns;
  message.published_ns = record.published_ns;
  message.received_ns = have ? record.measurement.received_ns : 0;
  message.state = static_cast<std::int32_t>(record.state);
  message.fault = static_cast<std::int32_t>(record.fault);
  message.defect = static_cast<std::int32_t>(record.defect);
  message.request = static_cast<std::int32_t>(record.request);
  message.sent = record.sent ? 1 : 0;
  message.heard = record.measurement.heard ? 1 : 0;
  message.saturated = record.command.saturated ? 1 : 0;
  message.seq = record.measurement.seq;
  message.time_ns = record.measurement.time_ns;
  message.n_legs = static_cast<std::int32_t>(record.command.force.size());
  message.sigma = list(record.measurement.sigma);
  message.applied = list(record.measurement.applied);
  message.force = list(record.command.force);
  message.n_floor = static_cast<std::int32_t>(record.measurement.floor.size());
  message.floor = list(record.measurement.floor);
  return message;
}

loop_checkpoint_t to_message(const LoopCheckpoint& checkpoint, std::int64_t run_id,
                             std::int64_t instance, const std::string& policy_text) {
  loop_checkpoint_t message;
  message.policy_text = policy_text;
  message.run_id = run_id;
  message.instance = instance;
  message.period = checkpoint.period;
  message.n = static_cast<std::int32_t>(checkpoint.memory.size());
  message.memory = checkpoint.memory;
  return message;
}

LoopRecord from_message(const loop_record_t& message) {
  LoopRecord record;
  record.period = message.period;
  record.n_elapsed = message.n_elapsed;
  record.deadline_ns = message.deadline_ns;
  record.wake_up_ns = message.wake_up_ns;
  record.computed_ns = message.computed_ns;
  record.published_ns = message.published_ns;
  record.state = static_cast<State>(message.state);
  record.fault = static_cast<Fault>(message.fault);
  record.defect = static_cast<Defect>(message.defect);
  record.request = static_cast<Request>(message.request);
  record.sent = message.sent != 0;
  record.measurement = {.seq = message.seq,
                        .time_ns = message.time_ns,
                        .received_ns = message.received_ns,
                        .sigma = vector(message.sigma),
                        .applied = vector(message.applied),
                        .floor = vector(message.floor),
                        .heard = message.heard != 0};
  record.command.force = vector(message.force);
  record.command.saturated = message.saturated != 0;
  return record;
}

Telemetry::Telemetry(ControllerLink& link, Loop& loop, const Io& io, const Presence& presence,
                     const std::string& policy_text)
    : link_(link), loop_(loop), io_(io), presence_(presence), policy_text_(policy_text) {}

void Telemetry::publish_records() {
  const std::int64_t run_id = link_.run_info().run_id;
  while (const LoopCheckpoint* checkpoint = loop_.checkpoints().oldest()) {
    link_.publish(channels::checkpoint,
                  to_message(*checkpoint, run_id, presence_.instance(), policy_text_));
    loop_.checkpoints().pop();
  }
  loop_records_t message;
  message.run_id = run_id;
  message.instance = presence_.instance();
  excitation_t excitation;
  excitation.run_id = run_id;
  excitation.instance = presence_.instance();
  const auto give = [&] {
    message.n_records = static_cast<std::int32_t>(message.records.size());
    if (message.n_records > 0) link_.publish(channels::loop, message);
    message.records.clear();
  };
  while (const LoopRecord* record = loop_.records().oldest()) {
    message.records.push_back(to_message(*record));
    if (link_.hosts()) link_.publish_samples(*record);
    if (record->sent && !record->excitation.isZero(0)) {
      excitation.seq = record->command.seq;
      excitation.n_legs = static_cast<std::int32_t>(record->excitation.size());
      excitation.force.assign(record->excitation.begin(), record->excitation.end());
      link_.publish(channels::excitation, excitation);
    }
    loop_.records().pop();
    if (message.records.size() == records_a_message) give();
  }
  give();
}

std::string leg_of_fault(const LoopCounters& counters, const std::vector<std::string>& leg_names) {
  const Fault fault = counters.fault;
  const std::int64_t leg = counters.first_leg;
  // The other faults are of all legs, whatever began before them.
  const bool of_a_leg =
      fault == Fault::restless || fault == Fault::noisy || fault == Fault::disobeyed;
  if (!of_a_leg || leg < 0 || leg >= static_cast<std::int64_t>(leg_names.size())) return "";
  return leg_names[static_cast<std::size_t>(leg)];
}

std::string fault_in_words(Fault fault, const std::string& leg) {
  std::string text(to_text(fault));
  if (!leg.empty()) text += ", " + leg + (fault == Fault::restless ? " first" : "");
  return text;
}

std::string floor_in_words(const LoopCounters& counters,
                           const std::vector<std::string>& floor_names) {
  const std::int64_t sensor = counters.broken_floor;
  if (sensor < 0 || sensor >= static_cast<std::int64_t>(floor_names.size())) return "";
  return ", feedback alone: " + floor_names[static_cast<std::size_t>(sensor)] +
         " repeats one reading, or reads noise";
}

std::string fault_in_words(const LoopCounters& counters,
                           const std::vector<std::string>& leg_names) {
  return fault_in_words(counters.fault, leg_of_fault(counters, leg_names));
}

void Telemetry::publish_status(const LastRequest& request) {
  const LoopCounters& counters = loop_.counters();
  const State state = counters.state.load(std::memory_order_acquire);
  const Fault fault = counters.fault;
  controller_status_t status;
  status.run_id = link_.run_info().run_id;
  status.plant_instance = link_.run_info().plant_instance;
  status.instance = presence_.instance();
  status.sent_ns = monotonic_ns();
  status.started_ns = presence_.started_ns();
  status.pid = getpid();
  status.state = static_cast<std::int32_t>(state);
  status.fault = static_cast<std::int32_t>(fault);
  status.latched = counters.latched ? 1 : 0;
  status.text = std::string(to_text(state));
  if (state == State::fault) {
    status.text += ": " + fault_in_words(counters, link_.run_info().leg_names);
  }
  if (state == State::ramp_in || state == State::active) {
    status.text += floor_in_words(counters, link_.run_info().floor_names);
  }
  status.nonce = request.nonce;
  status.answer = request.answer;
  status.n_periods = counters.n_periods;
  status.n_late = counters.n_late;
  status.n_lost = counters.n_lost;
  status.n_duplicate = counters.n_duplicate;
  status.n_missing = counters.n_missing;
  status.n_saturated = counters.n_saturated;
  status.n_faults = counters.n_faults;
  status.n_rejoins = counters.n_rejoins;
  const IoState io = io_.state();
  status.n_bad_messages = io.n_bad + link_.n_malformed();
  status.n_commands_dropped = io.n_dropped;
  status.n_records_dropped = counters.n_records_dropped;
  status.n_page_faults = counters.n_page_faults;
  status.worst_wake_up_ns = counters.worst_wake_up_ns;
  status.worst_compute_ns = counters.worst_compute_ns;
  link_.publish(channels::status, status);
}

}  // namespace stillframe::controller

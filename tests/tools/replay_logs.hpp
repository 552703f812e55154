#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <lcm/lcm-cpp.hpp>
#include <string>
#include <vector>

#include "controller/answer.hpp"
#include "controller/telemetry.hpp"
#include "msgs/channels.hpp"
#include "stillframe_msgs/loop_records_t.hpp"
#include "stillframe_msgs/run_info_t.hpp"
#include "tests/controller/rig.hpp"

// Logs of a toy frame, made in memory so that a test can spoil single messages.
namespace stillframe::test {

struct LoggedMessage {
  std::string channel;
  std::vector<std::uint8_t> bytes;
};

using Log = std::vector<LoggedMessage>;

template <class Message>
void add(Log& log, const char* channel, const Message& message) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  log.push_back({channel, std::move(bytes)});
}

/// Changes the n-th message of a channel.
template <class Message>
void change(Log& log, const std::string& channel, int n, const std::function<void(Message&)>& how) {
  for (LoggedMessage& logged : log) {
    if (logged.channel != channel || n-- > 0) continue;
    Message message;
    message.decode(logged.bytes.data(), 0, static_cast<int>(logged.bytes.size()));
    how(message);
    logged.bytes.resize(static_cast<std::size_t>(message.getEncodedSize()));
    message.encode(logged.bytes.data(), 0, static_cast<int>(logged.bytes.size()));
    return;
  }
  ADD_FAILURE() << "no such message on " << channel;
}

inline void write_log(const std::filesystem::path& file, const Log& log) {
  lcm::LogFile out(file.string(), "w");
  std::int64_t n = 0;
  for (const LoggedMessage& logged : log) {
    std::vector<std::uint8_t> bytes = logged.bytes;
    lcm::LogEvent event{};
    event.eventnum = n;
    event.timestamp = 1000 * n++;
    event.channel = logged.channel;
    event.datalen = static_cast<std::int32_t>(bytes.size());
    event.data = bytes.data();
    out.writeEvent(&event);
  }
}

/// Gains of the toy with a force limit that is met now and then.
inline controller::Gains limited_gains() {
  controller::Gains gains = controller::toy::gains(5);
  gains.force_limit_n = 0.02;
  return gains;
}

/// A loop that meets its limit now and then, and does not live there.
inline controller::Gains wall_clock_gains() {
  controller::Gains gains = controller::toy::damped_gains(5);
  gains.force_limit_n = 12;
  return gains;
}

inline stillframe_msgs::run_info_t info_of(const controller::Gains& gains, std::int64_t run_id,
                                           const std::string& mode) {
  stillframe_msgs::run_info_t info{};
  info.run_id = run_id;
  info.format_version = 1;
  info.mode = mode;
  info.loop = "active";
  info.gains_text = to_yaml(gains);
  info.sample_rate_hz = gains.sample_rate_hz;
  info.delay_samples = 1;
  info.n_legs = static_cast<std::int32_t>(gains.n_legs());
  info.leg_names = gains.legs;
  return info;
}

/// A lock-step run of n samples: every measurement and its command.
inline Log lock_step_log(int n, std::int64_t run_id = 7, const std::string& loop = "active") {
  const controller::Gains gains = limited_gains();
  Log log;
  stillframe_msgs::run_info_t info = info_of(gains, run_id, "lock_step");
  info.loop = loop;
  add(log, channels::run_info, info);
  controller::Answer answer(law_from_gains(gains), gains.force_limit_n, loop == "active");
  stillframe_msgs::measurement_t measurement{};
  stillframe_msgs::command_t command{};
  answer.prepare(command);
  measurement.run_id = run_id;
  measurement.n_legs = info.n_legs;
  measurement.applied_force.assign(command.force.size(), 0);
  for (int k = 0; k < n; ++k) {
    measurement.seq = k;
    measurement.time_ns = 1'000'000LL * k;
    measurement.sigma.clear();
    for (std::size_t i = 0; i < command.force.size(); ++i) {
      measurement.sigma.push_back(0.03 * std::sin(0.05 * k * (1.0 + double(i))) +
                                  measurement.applied_force[i]);
    }
    add(log, channels::measurement, measurement);
    answer.answer(measurement, command);
    add(log, channels::command, command);
    measurement.applied_force = command.force;
  }
  return log;
}

/// A wall-clock loop on the toy frame that notes down what it tells.
class LoggedRig {
 public:
  explicit LoggedRig(const controller::Policy& policy = {}, std::int64_t instance = 31)
      : rig_(policy, true, wall_clock_gains()), instance_(instance) {
    batch_.run_id = run_id;
    batch_.instance = instance_;
  }

  controller::toy::Rig& rig() { return rig_; }

  void steps(int n, const controller::toy::Rig::Wire& wire = {}, bool awake = true) {
    for (int i = 0; i < n; ++i) {
      rig_.step(wire, awake);
      note();
    }
  }

  /// Everything that can happen to it: taking hold, losses, a sleep, requests, a latched fault.
  void story() {
    using controller::Request;
    steps(1800);
    int n = 0;
    steps(300, [&n](controller::Measurement&) { return ++n % 3 != 0; });
    steps(40, controller::toy::nothing);
    steps(700);
    steps(3, {}, false);
    steps(100);
    rig_.loop().request(Request::stop);
    steps(500);
    rig_.loop().request(Request::start);
    steps(800);
    steps(30, {}, false);  // suspended
    steps(3200);
    steps(1300, [](controller::Measurement& m) {
      m.sigma(1) = std::nan("");
      return true;
    });
    rig_.loop().request(Request::reset);
    steps(100);
    rig_.loop().request(Request::start);
    steps(1700);
  }

  /// What was told, records that wait for their batch included.
  Log log() {
    give();
    return log_;
  }

  std::string policy_text;  ///< as the controller has it in its checkpoints
  std::int64_t n_periods = 0, n_commands = 0;
  static constexpr std::int64_t run_id = 7;

 private:
  void note() {
    auto& loop = rig_.loop();
    while (const auto* checkpoint = loop.checkpoints().oldest()) {
      add(log_, channels::checkpoint, to_message(*checkpoint, run_id, instance_, policy_text));
      loop.checkpoints().pop();
    }
    while (const auto* record = loop.records().oldest()) {
      ++n_periods;
      if (record->sent) {
        ++n_commands;
        add(log_, channels::command, command_of(*record));
      }
      batch_.records.push_back(to_message(*record));
      loop.records().pop();
      if (batch_.records.size() == 32) give();
    }
  }

  stillframe_msgs::command_t command_of(const controller::LoopRecord& record) const {
    stillframe_msgs::command_t command{};
    command.run_id = run_id;
    command.seq = record.command.seq;
    command.time_ns = record.command.time_ns;
    command.force = {record.command.force.begin(), record.command.force.end()};
    command.n_legs = static_cast<std::int32_t>(command.force.size());
    command.saturated = record.command.saturated ? 1 : 0;
    return command;
  }

  void give() {
    batch_.n_records = static_cast<std::int32_t>(batch_.records.size());
    if (batch_.n_records > 0) add(log_, channels::loop, batch_);
    batch_.records.clear();
  }

  controller::toy::Rig rig_;
  std::int64_t instance_;
  stillframe_msgs::loop_records_t batch_{};
  Log log_;
};

}  // namespace stillframe::test

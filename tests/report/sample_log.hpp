#pragma once

#include <lcm/eventlog.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "msgs/channels.hpp"
#include "stillframe_msgs/command_t.hpp"
#include "stillframe_msgs/measurement_t.hpp"
#include "stillframe_msgs/run_info_t.hpp"
#include "stillframe_msgs/timing_t.hpp"

namespace stillframe::report {

/// Writes an LCM log message by message, one every millisecond by the logger's clock.
class LogWriter {
 public:
  explicit LogWriter(const std::filesystem::path& path)
      : log_(lcm_eventlog_create(path.c_str(), "w")) {}
  ~LogWriter() { lcm_eventlog_destroy(log_); }
  LogWriter(const LogWriter&) = delete;
  LogWriter& operator=(const LogWriter&) = delete;

  void write_bytes(const std::string& channel, std::vector<char> bytes) {
    std::string name = channel;
    lcm_eventlog_event_t event{.eventnum = 0,
                               .timestamp = time_us_ += 1000,
                               .channellen = static_cast<int32_t>(name.size()),
                               .datalen = static_cast<int32_t>(bytes.size()),
                               .channel = name.data(),
                               .data = bytes.data()};
    lcm_eventlog_write_event(log_, &event);
  }

  template <typename Message>
  void write(const std::string& channel, const Message& message) {
    std::vector<char> bytes(static_cast<std::size_t>(message.getEncodedSize()));
    message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
    write_bytes(channel, std::move(bytes));
  }

 private:
  lcm_eventlog_t* log_;
  std::int64_t time_us_ = 1'000'000;
};

// Messages of a run of two floor inputs, three legs and two frame outputs whose numbers say where
// they belong.

inline stillframe_msgs::run_info_t sample_info(std::int64_t run_id, std::int64_t n_samples) {
  stillframe_msgs::run_info_t info{};
  info.run_id = run_id;
  info.format_version = 1;
  info.program_version = "0.1.0";
  info.scene_name = "sample";
  info.scene_hash = "0123456789abcdef";
  info.mode = "lock_step";
  info.loop = "active";
  info.sample_rate_hz = 1000;
  info.delay_samples = 1;
  info.n_samples = n_samples;
  info.n_floor = 2;
  info.n_legs = 3;
  info.n_frame = 2;
  info.floor_names = {"x", "y"};
  info.leg_names = {"leg_1", "leg_2", "leg_3"};
  info.frame_names = {"frame_x", "frame_y"};
  return info;
}

inline stillframe_msgs::measurement_t sample_measurement(std::int64_t run_id, std::int64_t seq) {
  const auto k = static_cast<double>(seq);
  stillframe_msgs::measurement_t message{};
  message.run_id = run_id;
  message.seq = seq;
  message.time_ns = seq * 1'000'000;
  message.n_floor = 2;
  message.n_legs = 3;
  message.n_frame = 2;
  message.floor_acceleration = {k + 0.1, k + 0.2};
  message.sigma = {k + 1.1, k + 1.2, k + 1.3};
  message.applied_force = {k + 2.1, k + 2.2, k + 2.3};
  message.frame_acceleration = {k + 3.1, k + 3.2};
  return message;
}

inline stillframe_msgs::command_t sample_command(std::int64_t run_id, std::int64_t seq) {
  const auto k = static_cast<double>(seq);
  stillframe_msgs::command_t message{};
  message.run_id = run_id;
  message.seq = seq;
  message.time_ns = seq * 1'000'000;
  message.n_legs = 3;
  message.force = {-k - 0.1, -k - 0.2, -k - 0.3};
  message.saturated = seq % 4 == 3;
  return message;
}

/// A whole run without a fault: info, then measurement and command of each sample.
inline void write_run(LogWriter& log, std::int64_t run_id, std::int64_t n_samples) {
  log.write(channels::run_info, sample_info(run_id, n_samples));
  for (std::int64_t seq = 0; seq < n_samples; ++seq) {
    log.write(channels::measurement, sample_measurement(run_id, seq));
    log.write(channels::command, sample_command(run_id, seq));
  }
}

}  // namespace stillframe::report

#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "msgs/channels.hpp"
#include "stillframe_msgs/command_t.hpp"
#include "stillframe_msgs/controller_status_t.hpp"
#include "stillframe_msgs/loop_records_t.hpp"
#include "stillframe_msgs/measurement_t.hpp"
#include "stillframe_msgs/run_info_t.hpp"
#include "stillframe_msgs/run_state_t.hpp"
#include "stillframe_msgs/timing_t.hpp"

// Messages of a run of one floor input, two legs and two frame outputs, floor_x and lens_x, that
// are compared as x.
namespace stillframe::live::sample {

inline constexpr std::int64_t ms = 1'000'000, second = 1'000'000'000;
inline constexpr double rate_hz = 1000;

template <class Message>
std::string encoded(const Message& message) {
  std::string bytes(static_cast<std::size_t>(message.getEncodedSize()), '\0');
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

/// A sine whose amplitude, m/s^2, and frequency are the closed form of everything that is shown.
inline constexpr double floor_amplitude = 2e-3, lens_amplitude = 5e-4, sine_hz = 10;

inline double sine(double amplitude, std::int64_t seq) {
  return amplitude * std::sin(2 * std::numbers::pi * sine_hz * static_cast<double>(seq) / rate_hz);
}

inline stillframe_msgs::run_info_t info(std::int64_t run_id) {
  stillframe_msgs::run_info_t info{};
  info.run_id = run_id;
  info.format_version = 1;
  info.program_version = "0.1.0";
  info.scene_name = "A sample";
  info.scene_hash = "0123456789abcdef";
  info.scene_text = "title: A sample\ncompare:\n  x: {floor: floor_x, frame: lens_x}\n";
  info.gains_text = "stillframe_gains: 1\nforce_limit_n: 200\n";
  info.mode = "wall_clock";
  info.loop = "active";
  info.sample_rate_hz = rate_hz;
  info.delay_samples = 1;
  info.n_samples = 60001;
  info.n_floor = 1;
  info.n_legs = 2;
  info.n_frame = 2;
  info.floor_names = {"floor_1"};
  info.leg_names = {"leg_1", "leg_2"};
  info.frame_names = {"floor_x", "lens_x"};
  return info;
}

inline stillframe_msgs::measurement_t measurement(std::int64_t run_id, std::int64_t seq) {
  stillframe_msgs::measurement_t message{};
  message.run_id = run_id;
  message.seq = seq;
  message.time_ns = seq * ms;
  message.n_floor = 1;
  message.n_legs = message.n_frame = 2;
  message.floor_acceleration = {sine(floor_amplitude, seq)};
  message.sigma = {1, 2};
  message.applied_force = {3, 4};
  message.frame_acceleration = {sine(floor_amplitude, seq), sine(lens_amplitude, seq)};
  return message;
}

inline stillframe_msgs::command_t command(std::int64_t run_id, std::int64_t seq) {
  stillframe_msgs::command_t message{};
  message.run_id = run_id;
  message.seq = seq;
  message.time_ns = seq * ms;
  message.n_legs = 2;
  message.force = {seq % 2 == 0 ? 30. : -30., 50.};
  message.saturated = seq % 10 == 0;
  return message;
}

inline stillframe_msgs::run_state_t state(std::int64_t run_id, const std::string& source,
                                          std::int32_t state, const std::string& text = "") {
  stillframe_msgs::run_state_t message{};
  message.run_id = run_id;
  message.source = source;
  message.state = state;
  message.text = text;
  return message;
}

inline stillframe_msgs::controller_status_t status(std::int64_t run_id, std::int64_t instance = 1) {
  stillframe_msgs::controller_status_t message{};
  message.run_id = run_id;
  message.instance = instance;
  message.state = stillframe_msgs::controller_status_t::ACTIVE;
  message.text = "active";
  message.n_periods = 1001;
  message.n_late = 1002;
  message.n_lost = 1003;
  message.n_missing = 1004;
  message.n_saturated = 1005;
  message.n_faults = 1006;
  message.n_rejoins = 1007;
  message.n_commands_dropped = 500;
  message.n_records_dropped = 508;
  message.worst_wake_up_ns = 187'200;
  message.worst_compute_ns = 30'400;
  return message;
}

inline stillframe_msgs::loop_record_t record(std::int64_t deadline_ns, std::int64_t late_ns,
                                             std::int64_t compute_ns, std::int64_t n_elapsed = 1) {
  stillframe_msgs::loop_record_t record{};
  record.n_elapsed = n_elapsed;
  record.deadline_ns = deadline_ns;
  record.wake_up_ns = deadline_ns + late_ns;
  record.computed_ns = record.wake_up_ns + compute_ns;
  record.n_legs = 2;
  record.sigma = record.applied = record.force = {0, 0};
  return record;
}

inline stillframe_msgs::loop_records_t records(std::int64_t run_id,
                                               std::vector<stillframe_msgs::loop_record_t> list) {
  stillframe_msgs::loop_records_t message{};
  message.run_id = run_id;
  message.n_records = static_cast<std::int32_t>(list.size());
  message.records = std::move(list);
  return message;
}

inline stillframe_msgs::timing_t timing(std::int64_t run_id, const std::string& source) {
  stillframe_msgs::timing_t message{};
  message.run_id = run_id;
  message.source = source;
  message.n_periods = 60001;
  message.n_late = 3;
  message.n_lost = 4;
  message.worst_wake_up_ns = 5000;
  message.worst_compute_ns = 6000;
  return message;
}

}  // namespace stillframe::live::sample

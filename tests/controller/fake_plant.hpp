#pragma once

#include <cstdint>
#include <lcm/lcm-cpp.hpp>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "controller/gains.hpp"
#include "stillframe_msgs/clock_exchange_t.hpp"
#include "stillframe_msgs/command_t.hpp"
#include "stillframe_msgs/measurement_t.hpp"
#include "stillframe_msgs/run_info_t.hpp"
#include "stillframe_msgs/run_state_t.hpp"
#include "stillframe_msgs/timing_t.hpp"
#include "tests/controller/toy_plant.hpp"

namespace stillframe::controller::toy {

/// The run_info of a toy plant that agrees with the gains, with no floor and no frame outputs.
inline stillframe_msgs::run_info_t run_info(const Gains& gains, std::int64_t run_id,
                                            const std::string& mode, std::int64_t n_samples) {
  stillframe_msgs::run_info_t info{};
  info.run_id = run_id;
  info.plant_instance = 1000 + run_id;
  info.format_version = 1;
  info.scene_name = "toy";
  info.scene_hash = gains.scene_hash;
  info.mode = mode;
  info.loop = "active";
  info.sample_rate_hz = gains.sample_rate_hz;
  info.delay_samples = gains.delay_samples;
  info.n_samples = n_samples;
  info.n_legs = static_cast<std::int32_t>(gains.legs.size());
  info.leg_names = gains.legs;
  return info;
}

/// The toy plant as the controller meets it on LCM.
class FakePlant {
 public:
  explicit FakePlant(stillframe_msgs::run_info_t info);

  /// Repeats that it waits, and run_info, until the controller has answered READY or FAILED; its
  /// answer, or -1.
  int announce();
  /// Whether the controller has said something; waits until nothing has come for 20 ms, itself not
  /// either.
  bool is_answered();
  void publish_state(std::int32_t state, std::int64_t start_ns = 0, const std::string& text = "");
  void publish(const stillframe_msgs::measurement_t& measurement);
  void publish_raw(const std::string& channel, const void* data, size_t size);

  /// Publishes a measurement until a command of its seq comes, as the real plant does.
  std::optional<stillframe_msgs::command_t> exchange(
      const stillframe_msgs::measurement_t& measurement);
  /// Takes one message if there is one within the time.
  bool take(int timeout_ms);

  /// The measurement at the toy's present state, with seq and time of sample k.
  stillframe_msgs::measurement_t measure(std::int64_t k) const;
  /// Moves the toy over one sample with the forces held, and its floor's acceleration (m/s^2).
  void move(const std::vector<double>& force, double floor = 0);

  lcm::LCM& lcm() { return lcm_; }
  const stillframe_msgs::run_info_t& info() const { return info_; }

  std::int64_t ahead_ns = 0;  ///< of its clock, if that is another one

  std::vector<std::vector<std::uint8_t>> command_bytes;  ///< every command heard
  std::vector<stillframe_msgs::command_t> commands;      ///< the same, decoded
  std::vector<stillframe_msgs::run_state_t> states;      ///< of the controller
  std::optional<stillframe_msgs::timing_t> timing;       ///< of the controller

 private:
  void on_command(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void on_state(const lcm::ReceiveBuffer* buffer, const std::string& channel,
                const stillframe_msgs::run_state_t* message);
  void on_clock(const lcm::ReceiveBuffer* buffer, const std::string& channel,
                const stillframe_msgs::clock_exchange_t* message);
  void on_timing(const lcm::ReceiveBuffer* buffer, const std::string& channel,
                 const stillframe_msgs::timing_t* message);

  lcm::LCM lcm_;
  stillframe_msgs::run_info_t info_;
  std::vector<double> q_, v_, applied_;
};

}  // namespace stillframe::controller::toy

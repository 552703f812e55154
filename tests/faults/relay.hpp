#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <lcm/lcm-cpp.hpp>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "stillframe_msgs/control_request_t.hpp"
#include "stillframe_msgs/measurement_t.hpp"
#include "tests/faults/corruption.hpp"
#include "tests/faults/trace.hpp"
#include "tests/faults/wire.hpp"

namespace stillframe::faults {

/// What is done to the messages for a while.
struct Fault {
  Disturbance measurements, commands;
  Corruption corruption = Corruption::none;
  std::int32_t leg = 0;  ///< that is corrupted
};

/// Sums over all that was inflicted.
struct RelayCounts {
  WireCounts measurements, commands;
  std::int64_t n_corrupted = 0;
};

/// A bad wire between a plant and a controller on two LCM ports of one network, with a thread of
/// its own. Every channel has one direction, so that nothing echoes. It writes down what the frame
/// did, before anything is done to the messages, and what the controller says of itself.
class Relay {
 public:
  /// rate_hz: of the samples. Errors: InputError if LCM cannot be opened.
  Relay(const std::string& plant_url, const std::string& controller_url, double rate_hz);
  ~Relay();
  Relay(const Relay&) = delete;
  Relay& operator=(const Relay&) = delete;

  /// Inflicts a fault on the next n_samples measurements, and on the commands meanwhile.
  void inflict(const Fault& fault, std::uint64_t seed, std::int64_t n_samples);
  /// From now on the controller is the process of this id; what others say is not written down.
  void follow(std::int32_t pid);
  /// Sends a request to the controller.
  void request(const stillframe_msgs::control_request_t& request);

  /// Waits until a condition on the trace holds, which is looked at whenever a status comes and at
  /// each tenth sample; false if it does not within limit_s.
  bool wait(const std::function<bool(const Trace&)>& condition, double limit_s);
  /// Reads the trace.
  template <class Function>
  auto look(Function function) {
    const std::lock_guard lock(mutex_);
    return function(trace_);
  }
  RelayCounts counts();

 private:
  void run();
  void subscribe();
  void wait_for_messages();
  void send_due();
  void from_plant(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void from_controller(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void on_measurement(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void on_command(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void on_status(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void on_records(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void write_down(const stillframe_msgs::measurement_t& measurement, std::int64_t now_ns);
  void begin_or_end(std::int64_t now_ns);

  std::mutex mutex_;
  std::condition_variable changed_;
  Trace trace_;
  std::int32_t pid_ = 0;
  Wire measurements_, commands_;
  Corruptor corruptor_;
  Fault fault_;
  std::uint64_t seed_ = 0;
  std::int64_t samples_left_ = 0;  ///< of the fault
  bool pending_ = false;           ///< it begins with the next measurement

  std::atomic<bool> stop_ = false;
  std::unique_ptr<lcm::LCM> plant_, controller_;
  std::thread thread_;
};

}  // namespace stillframe::faults

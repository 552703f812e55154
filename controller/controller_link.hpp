#pragma once

#include <cstdint>
#include <lcm/lcm-cpp.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "controller/loop_record.hpp"
#include "controller/measurement_decoder.hpp"
#include "controller/policy.hpp"
#include "controller/requests.hpp"
#include "msgs/clock.hpp"
#include "msgs/direct_line.hpp"
#include "msgs/peer_clocks.hpp"
#include "stillframe_msgs/command_t.hpp"
#include "stillframe_msgs/control_request_t.hpp"
#include "stillframe_msgs/controller_status_t.hpp"
#include "stillframe_msgs/run_info_t.hpp"
#include "stillframe_msgs/run_state_t.hpp"
#include "stillframe_msgs/timing_t.hpp"

namespace stillframe::controller {

/// What came with one message off the wire.
struct Heard {
  bool message = false;  ///< anything at all
  bool run_info = false;
  bool run_state = false;     ///< of the plant
  bool measurement = false;   ///< of the run, with the sizes of the run
  bool other_run = false;     ///< run_info of a run that is not followed
  bool other_plant = false;   ///< run_info of another plant that has the number of this run
  bool request = false;       ///< for this run or for any; not yet admitted
  bool other_status = false;  ///< of another controller of this plant, said just now
};

/// The controller's end of LCM: decodes into messages that it keeps, encodes into a buffer that it
/// keeps. Construction and everything about run_info and run_state is set-up; take and the command
/// functions are hot: noexcept, and for measurements without allocation of their own.
class ControllerLink {
 public:
  /// url: an LCM provider, as in udpm://239.255.76.67:7667?ttl=0; policy: how its thread is served.
  /// Errors: InputError if LCM cannot be opened, with the commands that mend it.
  explicit ControllerLink(const std::string& url, const Policy& policy = {});

  /// Waits up to timeout_ms for one message, takes it and says what it was; a message of another
  /// run or one that does not decode is none. A signal ends the wait early.
  Heard take(int timeout_ms) noexcept;

  /// Fixes run and plant: from now on only its messages are heard, measurements among them. A
  /// run_info is heard at all only while its plant says where it is. In lock-step it comes to the
  /// direct line that its plant offers, and hears nothing else from the first message there on,
  /// until that line ends. Set-up.
  void follow(const stillframe_msgs::run_info_t& info);
  /// Lets go of the run, so that the next one may be followed. Set-up.
  void forget() noexcept { following_ = false; }
  bool is_direct() const noexcept { return direct_; }
  /// Speaks for a rig, which has no process of its own: from here on this run is followed, and said
  /// on the bus as a plant would. Set-up.
  void host(const stillframe_msgs::run_info_t& info);
  bool hosts() const noexcept { return hosts_; }
  /// Of a rig: publishes run_info, and that the run goes on since start_ns; how it ended; and what
  /// a record holds of samples and commands. Set-up.
  void announce(std::int64_t start_ns);
  void publish_end();
  void publish_samples(const LoopRecord& record);
  /// Leaves the measurements to somebody else. Set-up.
  void stop_measurements();

  const stillframe_msgs::run_info_t& run_info() const noexcept { return run_info_; }
  const stillframe_msgs::run_state_t& plant_state() const noexcept { return plant_state_; }
  /// When the run began that the plant which is followed says began at said_ns, on the own clock as
  /// that stands to its now: an instant on one clock, else half of a way there and back wide. None
  /// if its clock is not known. Set-up.
  std::optional<PeerClocks::Instant> start(std::int64_t said_ns);
  /// PeerClocks::doubt of that plant.
  void doubt_plant() noexcept { clocks_.doubt(plant_instance_); }
  /// Whether that plant reads another clock, and paces its samples by it.
  bool is_elsewhere() const noexcept;
  /// PeerClocks::unanswered.
  std::string unanswered() const { return clocks_.unanswered(); }
  const stillframe_msgs::measurement_t& measurement() const noexcept {
    return measurements_.message();
  }

  const stillframe_msgs::control_request_t& request() const noexcept { return request_; }
  /// Whether that is to be obeyed, now and never again. Set-up.
  bool admits_request();
  const stillframe_msgs::controller_status_t& other_status() const noexcept {
    return other_status_;
  }
  /// A number that no other controller has. Set-up.
  std::int64_t instance() const noexcept { return instance_; }

  /// The command message to be filled, and its way out: encodes and publishes it.
  stillframe_msgs::command_t& command() noexcept { return command_; }
  void publish_command() noexcept;
  /// Publishes the last command again, the same bytes.
  void repeat_command() noexcept;

  /// Publishes a run_state_t of source "controller" for a run. Set-up.
  void publish_state(std::int64_t run_id, std::int32_t state, const std::string& text);
  /// Publishes the timing_t of source "controller" for the run that is followed. Set-up.
  void publish_timing(stillframe_msgs::timing_t counters);

  /// Publishes any message. Set-up.
  template <class Message>
  void publish(const char* channel, const Message& message) {
    lcm_->publish(channel, &message);
  }

  std::int64_t last_heard_ns() const noexcept { return last_heard_ns_; }  ///< monotonic
  std::int64_t n_malformed() const noexcept { return n_malformed_; }

 private:
  void hear_lcm();
  void take_line(int timeout_ms);
  void on_run_info(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void on_run_state(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void on_measurement(const lcm::ReceiveBuffer* buffer, const std::string& channel);

  void on_request(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void on_clock(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void on_status(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void publish_plant_state(std::int32_t state, std::int64_t start_ns);
  void note_announced(const stillframe_msgs::run_state_t& state);
  bool is_announced(const stillframe_msgs::run_info_t& info);
  bool is_followed(std::int64_t run_id, std::int64_t plant_instance) const noexcept;

  const std::string url_;
  const Policy policy_;
  std::unique_ptr<lcm::LCM> lcm_;  ///< while direct_ it only publishes, and has no thread
  std::optional<DirectLine> line_;
  bool direct_ = false;  ///< the plant has spoken on the line
  bool hosts_ = false;
  lcm::Subscription* measurement_subscription_ = nullptr;
  std::int64_t instance_;
  bool following_ = false;
  std::int64_t run_id_ = 0, plant_instance_ = 0;
  struct Announced {
    std::int64_t run_id = 0, plant_instance = 0;
    std::int64_t sent_ns = 0;  ///< on its own clock
  };
  std::vector<Announced> announced_;  ///< plants, oldest first
  PeerClocks clocks_;
  Requests requests_;
  Heard heard_;
  stillframe_msgs::run_info_t run_info_;
  stillframe_msgs::run_state_t plant_state_;
  MeasurementDecoder measurements_;
  stillframe_msgs::control_request_t request_;
  stillframe_msgs::controller_status_t other_status_;
  stillframe_msgs::command_t command_;
  const std::string command_channel_;
  std::vector<std::uint8_t> command_bytes_;
  int n_command_bytes_ = 0;
  std::int64_t last_heard_ns_ = 0;
  std::int64_t n_malformed_ = 0;
};

}  // namespace stillframe::controller

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <lcm/lcm-cpp.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "msgs/direct_line.hpp"
#include "msgs/peer_clocks.hpp"
#include "plant_sim/command_track.hpp"
#include "plant_sim/log_pacer.hpp"
#include "plant_sim/plant.hpp"
#include "stillframe_msgs/command_t.hpp"
#include "stillframe_msgs/measurement_t.hpp"
#include "stillframe_msgs/run_info_t.hpp"
#include "stillframe_msgs/run_state_t.hpp"
#include "stillframe_msgs/timing_t.hpp"

namespace stillframe {

/// The plant's end of the bus for one run: it publishes measurements and the state of the run, and
/// keeps the newest command of the one controller that it obeys: the first that is heard, and
/// another only once that one has been silent. Construction is set-up.
class PlantLink {
 public:
  /// Errors: InputError if LCM cannot be opened.
  PlantLink(const std::string& url, stillframe_msgs::run_info_t info);

  const stillframe_msgs::run_info_t& info() const { return info_; }
  void publish_info();
  void publish_state(std::int32_t state, std::int64_t start_monotonic_ns, const std::string& text);
  void publish_timing(const stillframe_msgs::timing_t& timing);
  /// Publishes a measurement, and again the same bytes.
  void publish_measurement(std::int64_t k, const Reading& reading);
  void repeat_measurement();

  /// In lock-step, once a controller is ready: from here on measurements and states go to it by a
  /// direct line too, and what it says is heard from there alone, if it has come to the one that
  /// this plant offers; if that line ends, LCM is heard again. Set-up.
  void go_direct();
  bool is_direct() const { return line_.has_value(); }

  /// In lock-step: keeps the run from outrunning the logger that writes this file.
  void pace_by(const std::filesystem::path& log);
  /// Both answer false if the logger does not catch up.
  bool begin_pacing();
  bool wait_for_log() noexcept;

  /// Handles one message if one comes within timeout_ms.
  bool listen(int timeout_ms) noexcept;

  bool controller_ready() const { return !ready_.empty(); }
  /// Why the controller gave up; empty while it has not: the one that is obeyed; before any is, one
  /// after which none is left that was ready.
  const std::string& controller_failure() const { return controller_failure_; }

  /// Wall-clock: t_0 of the run on CLOCK_MONOTONIC and its period, ns. From here on a command must
  /// have been sent since its sample.
  void set_clock(std::int64_t start_ns, double period_ns);
  /// The controller that is obeyed has been silent: the next one that commands may take its place.
  /// It may speak over LCM, which is heard again.
  void free_seat() {
    seat_is_free_ = true;
    if (line_) end_line();
  }
  /// Why this plant has to go, another one having its number; empty while it has not.
  const std::string& rival() const { return rival_; }
  /// PeerClocks::unanswered.
  std::string unanswered() const { return clocks_.unanswered(); }

  /// Goes on to the newest command that belongs to sample k or one before; then the number of its
  /// sample, -1 before the first, and its forces (N).
  void take_commands(std::int64_t k) { commands_.advance_to(k); }
  std::int64_t command_seq() const { return commands_.seq(); }
  const Eigen::VectorXd& command_force() const { return commands_.force(); }
  /// Refuses commands of samples after k, which are yet to come by the clock: they belong to
  /// another run of the same number. A wall-clock run begins with refusing all.
  void refuse_after(std::int64_t k) { last_allowed_ = k; }
  /// How many commands were heard that were new.
  std::int64_t n_commands() const { return n_commands_; }
  /// Commands that were refused: of a wrong size, not finite, or of no sound time.
  std::int64_t n_malformed() const { return n_malformed_; }
  /// Commands of a controller on another clock, which is not known or not any more: refused, and
  /// nothing is wrong with them. They end with the first answer on SF_CLOCK.
  std::int64_t n_clock_unknown() const { return n_clock_unknown_; }
  std::int64_t n_duplicate() const { return n_duplicate_; }
  /// Commands of this run for another plant, or of a controller that is not obeyed.
  std::int64_t n_foreign() const { return n_foreign_; }

 private:
  void on_command(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void on_state(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  bool is_sound(const stillframe_msgs::command_t& command);
  enum class Sent { sound, unsound, unknown };
  Sent judge_time(const stillframe_msgs::command_t& command);
  void on_clock(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void judge_rival(const stillframe_msgs::run_state_t& other);
  template <class Message>
  void publish(const char* channel, const Message& message);
  void send(const char* channel, const std::vector<std::uint8_t>& bytes);
  void hear_lcm();
  void end_line() noexcept;

  const std::string url_;
  std::unique_ptr<lcm::LCM> lcm_;  ///< with a line it only publishes, and has no thread
  std::optional<LineOffer> offer_;
  std::optional<DirectLine> line_;
  std::optional<LogPacer> pacer_;
  stillframe_msgs::run_info_t info_;
  stillframe_msgs::measurement_t measurement_;
  stillframe_msgs::command_t command_;
  std::vector<std::uint8_t> bytes_;
  std::vector<std::uint8_t> measurement_bytes_;
  std::vector<std::int64_t> ready_;  ///< instances of controllers that are
  std::string controller_failure_;
  std::int64_t last_allowed_;
  std::int64_t n_commands_ = 0, n_malformed_ = 0, n_clock_unknown_ = 0;
  std::int64_t n_duplicate_ = 0, n_foreign_ = 0;
  std::int64_t obeyed_ = 0;   ///< instance of the last controller that was, 0: none yet
  bool seat_is_free_ = true;  ///< and another one may follow it
  std::int32_t state_ = stillframe_msgs::run_state_t::WAITING;
  std::int64_t start_ns_ = 0;
  double period_ns_ = 0;
  std::size_t command_size_ = 0;
  std::string rival_;
  CommandTrack commands_;
  PeerClocks clocks_;
};

}  // namespace stillframe

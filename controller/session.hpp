#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "controller/background.hpp"
#include "controller/controller_link.hpp"
#include "controller/gains.hpp"
#include "controller/handshake.hpp"
#include "controller/io.hpp"
#include "controller/latch.hpp"
#include "controller/loop.hpp"
#include "controller/loop_thread.hpp"
#include "controller/outcome.hpp"
#include "controller/policy.hpp"
#include "controller/presence.hpp"
#include "controller/request_queue.hpp"
#include "controller/telemetry.hpp"

namespace stillframe::controller {

/// What a session needs to know beside gains and policy.
struct SessionOptions {
  double timeout_s = 10;  ///< without a word from the plant, after which the session is over
  double phase = 0.5;     ///< of the deadlines in a sample
  bool any_run = true;    ///< another run may take the place of one that is silent
  std::filesystem::path flight_folder;
  std::string policy_text;                            ///< of the policy file, empty without one
  std::function<void(const std::string&)> say, warn;  ///< they never wait; from any thread
};

/// One wall-clock run of one plant or rig, wherever its samples come from: the loop on a thread of
/// its own, and beside it, on the calling thread, interlock, requests, status and telemetry, and
/// the watch for the end. It touches neither terminal nor disk: what it says and what it records
/// goes to threads that may hang. Set-up.
class Session {
 public:
  /// link follows the run, or hosts it; all arguments outlive the session. disk writes the flight
  /// records. Errors: as Supervisor.
  Session(Io& io, ControllerLink& link, const Gains& gains, const Policy& policy,
          const Presence& presence, Latch& latch, Background& disk, const SessionOptions& options,
          const Start& start);

  /// Runs to the end, and lets go of the frame before it answers.
  Outcome run();

  const std::string& reason() const { return reason_; }  ///< why the session was refused
  /// Why a run that should have been isolated never was; empty if it was, or was too short for it.
  std::string never_active() const;
  /// Adds what was counted and measured to what was before. After run.
  void add_to(stillframe_msgs::timing_t& counters, LoopTimes& times) const;
  const LoopCounters& counters() const { return loop_.counters(); }

 private:
  void listen();
  void serve_requests();
  std::string refusal(Request request) const;
  void tell(bool whatever);
  void tell_floor();
  void keep_latch();
  void give_flight();
  void look_for_end();
  void announce();
  void bound_samples();
  void end(Outcome outcome);
  bool is_over(LoopThread& thread);
  bool knows_the_loop() const;
  std::int64_t samples_ns(double n) const;

  Io& io_;
  ControllerLink& link_;
  const Policy& policy_;
  const Presence& presence_;
  Latch& latch_;
  Background& disk_;
  const SessionOptions& options_;
  std::int64_t start_ns_;
  std::int64_t plant_start_ns_;  ///< as is said on the bus, by the plant's clock
  double sample_rate_hz_;
  Loop loop_;
  Telemetry telemetry_;
  RequestQueue requests_;
  LastRequest last_request_;
  std::optional<Outcome> end_;
  std::string reason_;
  State told_state_ = State::idle;
  bool told_latched_, flight_given_ = false;
  std::int64_t told_floor_ = -1;  ///< LoopCounters::broken_floor
  std::int64_t told_ns_ = 0, told_faults_ = 0, alive_ns_, alive_count_ = 0;
  std::int64_t n_unheard_ = 0, announced_ns_ = 0, told_locks_ = 0, told_held_ = 0;
  bool told_late_ = false;
};

}  // namespace stillframe::controller

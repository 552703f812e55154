#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>

#include "controller/arming.hpp"
#include "controller/command_watch.hpp"
#include "controller/excitation.hpp"
#include "controller/floor_evidence.hpp"
#include "controller/floor_watch.hpp"
#include "controller/io.hpp"
#include "controller/law.hpp"
#include "controller/limits.hpp"
#include "controller/obedience.hpp"
#include "controller/pace.hpp"
#include "controller/policy.hpp"

namespace stillframe::controller {

/// Where the controller of a wall-clock run is; the values are those of controller_status_t.
enum class State : std::int32_t { idle, arming, ramp_in, active, fading, ramp_out, fault };

/// What it may be asked for; the values are those of control_request_t.
enum class Request : std::int32_t { none, start, stop, reset };

std::string_view to_text(State state) noexcept;

/// All that one period knows of the world. The supervisor is a function of these and of nothing
/// else, so that a record of them gives back every command to the bit.
struct Event {
  std::int64_t n_elapsed = 1;  ///< periods since the last event, skipped ones included
  const Measurement* measurement = nullptr;  ///< new and sound, or none
  Defect defect = Defect::missing;           ///< why there is none
  Request request = Request::none;
};

/// The state machine around the law: arming, smooth ramps, what is done when measurements fail, and
/// the limits of the actuators. With w = s(p) of smooth_step.hpp, F the command, u the law's force:
///   ramps and active:   F = w (u + e), p by T/ramp a period, e an excitation of an active loop;
///   no measurement:     F held, for at most hold_periods;
///   then, and in faults: F = F_0 s(q), F_0 the force at its beginning, q from 1 to 0 in fade_s;
///   of a loop that has run away F_0 is smoothed, and the step to it decays within samples.
/// What acts and was not commanded in a row up to now, at the start, after a sleep, or because
/// commands were not heard, is the amplifiers' to let go of: nothing is sent until they have.
/// Source: docs/safety.md. Construction is set-up; the rest is hot: noexcept, no allocation.
class Supervisor {
 public:
  /// active: false never leaves idle and commands zero force. Errors: std::invalid_argument of
  /// Law, Limits and Arming, Refusal where there is no force limit.
  Supervisor(const Gains& gains, const Policy& policy, bool active);

  /// Begins with a fault that was latched before, and so waits for a reset; leg: first_leg. Set-up.
  void begin_latched(Fault fault, Eigen::Index leg = -1) noexcept;
  /// Goes through one period; true if command (its force has m values already) is to be sent.
  bool step(const Event& event, Command& command) noexcept;

  Eigen::Index n_legs() const noexcept { return law_.n_legs(); }
  State state() const noexcept { return state_; }
  Fault fault() const noexcept { return fault_; }  ///< the last one
  /// The leg whose force first changed faster than it may before the fault restless, that did not
  /// do as it was told, or whose sensor was noisy; -1: none.
  Eigen::Index first_leg() const noexcept { return watch_.first(); }
  /// The sensor of the floor for which the feed-forward is out, or on its way; -1: none.
  Eigen::Index broken_floor() const noexcept { return floor_watch_.broken(); }
  bool latched() const noexcept { return latched_; }
  bool active() const noexcept { return active_; }
  /// What the last command has of it, m, N.
  const Eigen::VectorXd& excited() const noexcept { return excited_; }
  const Excitation& excitation() const noexcept { return excitation_; }
  std::int64_t n_faults() const noexcept { return n_faults_; }
  std::int64_t n_rejoins() const noexcept { return n_rejoins_; }
  std::int64_t n_saturated() const noexcept { return n_saturated_; }
  /// True while a force is commanded, or may be at any moment.
  bool driving() const noexcept { return engaged() || q_ > 0; }

  /// Everything that a later command depends on, as memory_size() doubles.
  std::size_t memory_size() const noexcept { return memory_size_; }
  void save(std::span<double> memory) const noexcept;
  void restore(std::span<const double> memory) noexcept;

 private:
  template <class Archive>
  void visit(Archive& archive);
  bool engaged() const noexcept;
  void take(Request request) noexcept;
  void count_missing(const Event& event) noexcept;
  void watch(const Event& event) noexcept;
  bool disobeyed(const Event& event) noexcept;
  void let_go(Fault fault, const Event& event) noexcept;
  void fade_from(const Eigen::VectorXd& force) noexcept;
  void fall_silent(std::int64_t n_elapsed) noexcept;
  void listen(const Event& event) noexcept;
  void latch(Fault fault) noexcept;
  void come_back(const Event& event) noexcept;
  void restart_arming() noexcept;
  void arm(const Event& event) noexcept;
  void hear_floor(const Event& event) noexcept;
  void run_law(const Event& event) noexcept;
  void excite(std::int64_t seq, double gain) noexcept;
  void move_gain(std::int64_t n_elapsed) noexcept;

  Law law_;
  Policy policy_;
  Limits limits_;
  Arming arming_;
  CommandWatch watch_;
  Obedience obedience_;
  Pace pace_;
  FloorEvidence floor_evidence_;
  FloorWatch floor_watch_;
  Excitation excitation_;
  double sample_time_;
  double forgets_;       ///< of missing_part_, in a period
  std::int64_t let_go_;  ///< periods in which amplifiers that hear nothing let go of a force
  bool active_;

  State state_ = State::idle;
  Fault fault_ = Fault::none;
  bool latched_ = false, wanted_ = false, met_ = false, law_ran_ = false;
  std::int64_t missing_ = 0;  ///< periods since the last measurement
  std::int64_t gap_ = 0;      ///< of them before the last measurement
  std::int64_t unheard_ = 0;  ///< samples, for which commands that were sent have not acted
  double missing_part_ = 0;   ///< mean over about a second
  Defect last_defect_ = Defect::none;
  std::int64_t quiet_;          ///< periods in which nothing is sent
  bool held_ = false;           ///< a force of this loop is the amplifiers' to let go of
  double rejoins_ = 0;          ///< of the last minute
  bool passing_fault_ = false;  ///< since the last arming
  double p_ = 0, q_ = 0;
  Eigen::VectorXd base_, step_, force_, u_, offset_, sigma_;  ///< m, N
  Eigen::VectorXd asked_, asked_before_, change_;  ///< m, N, by the law, before the last gate
  Eigen::VectorXd excited_, excited_before_;  ///< m, N, what is added to a command, and was before
  /// m, N: what gain and excitation change by themselves, and what may change
  Eigen::VectorXd ramp_, allowed_;
  std::int64_t seq_ = -1, law_seq_ = -1, floor_seq_ = -1;
  bool met_limit_ = false;      ///< of an actuator, and has not caught up since
  std::int64_t n_samples_ = 1;  ///< that the law has made up for now
  double time_ns_ = 0;
  std::int64_t n_faults_ = 0, n_rejoins_ = 0, n_saturated_ = 0;
  std::size_t memory_size_ = 0;
};

}  // namespace stillframe::controller

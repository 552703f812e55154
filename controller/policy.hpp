#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace stillframe::controller {

/// Why a period had no measurement to answer.
enum class Defect : std::int32_t { none, missing, late, not_finite, out_of_range };

/// Why the loop let go of the frame.
enum class Fault : std::int32_t {
  none,
  silence,         ///< no usable measurement for hold_periods and fade_s
  losses,          ///< too many periods without one
  suspended,       ///< the loop itself slept through more than hold_periods
  not_finite,      ///< measurements that are not finite, for as long as silence
  out_of_range,    ///< measurements beyond sigma_limit_n, for as long as silence
  restless,        ///< too many of about twenty commands were to change too fast
  law_not_finite,  ///< the law's force or state is not finite
  not_alive,       ///< arming: a sensor does not move
  offset,          ///< arming: a sensor's offset beyond offset_limit_n
  limited,         ///< too many commands of about a second were at the force limit
  noisy,           ///< arming: of a sensor's noise the loop would make more than the floor does
  unheard,         ///< measurements come, but the commands have not acted for longest_gap samples
  disobeyed,       ///< a force that is said to act is not one that was commanded
};

/// Faults that end by themselves once measurements come again; the others stay until a reset.
constexpr bool is_passing(Fault fault) noexcept {
  return fault == Fault::silence || fault == Fault::losses || fault == Fault::suspended ||
         fault == Fault::unheard;
}

std::string_view to_text(Defect defect) noexcept;
std::string_view to_text(Fault fault) noexcept;

/// What is added to the commands of an active loop, leg after leg; controller/excitation.hpp.
struct ExcitationPlan {
  enum class Kind { none, multisine, sweep, step };

  Kind kind = Kind::none;
  bool open_loop = false;         ///< the law's own force is left out
  std::optional<double> force_n;  ///< N, peak; none: 2 % of the force limit
  std::optional<double> from_hz;  ///< none: two periods in a window
  std::optional<double> to_hz;    ///< none: 0.42 of the sample rate
  double window_s = 2;            ///< s, after which it repeats itself
  std::int64_t windows = 5;       ///< of each leg, and as many of nothing before
  std::int64_t lines = 44;        ///< frequencies of a multisine
  std::string place = {};         ///< "policy.yaml:3:13"; empty: of no file
};

/// The numbers of the fault policy of wall-clock runs, docs/safety.md; a policy file states those
/// that differ from default_policy, which at 200 Hz and more is what stands here.
struct Policy {
  enum class Realtime { off, best_effort, enforce };

  bool start_at_once = true;   ///< arm as soon as measurements come; else wait for a request
  double arming_s = 0.5;       ///< s of measurements that the checks look at
  bool require_motion = true;  ///< every sensor must have moved meanwhile
  double offset_limit_n = 50;  ///< N, the largest offset that is removed
  double ramp_in_s = 1, ramp_out_s = 1;  ///< s

  std::int64_t hold_periods = 10;      ///< the last force is held so long
  double fade_s = 1;                   ///< s, then it fades to zero
  double missing_part = 0.75;          ///< of the periods of about the last second
  double late_periods = 1;             ///< a measurement older than this is late
  double sigma_limit_n = 1e5;          ///< N, beyond it a measurement is out of range
  std::int64_t rejoins_a_minute = 20;  ///< of passing faults; one more stays

  double limited_part = 0.25;           ///< of the commands of about a second, at the force limit
  double disobeyed_part = 0.05;         ///< of a leg's force, that more may act than was commanded
  std::optional<double> force_limit_n;  ///< N, of every leg; the lower of it and gains
  std::optional<double> rate_limit_n_per_s;  ///< N/s, of every leg
  /// N/s, of every leg, beside what the floor asks for; none: a tenth of the force limit in a
  /// second, or what a floor of 0.1 mm/s^2 asks for, if that is less
  std::optional<double> free_rate_n_per_s;
  std::optional<double> power_limit_w;               ///< W, of every leg
  std::optional<double> actuator_stiffness_n_per_m;  ///< N/m, with a power limit

  Realtime realtime = Realtime::best_effort;
  std::int64_t priority = 49;       ///< SCHED_FIFO, 2 to 98
  std::optional<std::int64_t> cpu;  ///< processor of the loop's thread
  double record_s = 10;             ///< s, length of the flight record
  std::int64_t record_files = 100;  ///< so many records are kept, the oldest goes
  double record_mb = 1000;          ///< MB, in all

  ExcitationPlan excitation;
};

/// Of the words off, best_effort and enforce.
Policy::Realtime realtime_named(std::string_view word) noexcept;

/// The policy of a loop without a policy file: slower loops take longer.
Policy default_policy(double sample_rate_hz);

/// Reads the policy file of a loop. Errors: InputError (missing file, unknown key, value that is
/// not allowed, or too short at this rate).
Policy read_policy(const std::filesystem::path& path, double sample_rate_hz);

/// Reads a policy from text; source_name stands for the file in messages. Errors: InputError.
Policy parse_policy(const std::string& text, const std::string& source_name, double sample_rate_hz);

}  // namespace stillframe::controller

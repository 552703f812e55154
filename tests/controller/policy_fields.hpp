#pragma once

#include <tuple>

#include "controller/policy.hpp"

namespace stillframe::controller {

/// All numbers of a policy, to be compared. A field that is added to Policy and not here does not
/// compile.
inline auto fields(const Policy& policy) {
  const auto& [start_at_once, arming_s, require_motion, offset_limit_n, ramp_in_s, ramp_out_s,
               hold_periods, fade_s, missing_part, late_periods, sigma_limit_n, rejoins_a_minute,
               limited_part, disobeyed_part, force_limit_n, rate_limit_n_per_s, free_rate_n_per_s,
               power_limit_w, actuator_stiffness_n_per_m, realtime, priority, cpu, record_s,
               record_files, record_mb, excitation] = policy;
  const auto& [kind, open_loop, force_n, from_hz, to_hz, window_s, windows, lines, place] =
      excitation;  // where it stands is none of them
  return std::make_tuple(
      start_at_once, arming_s, require_motion, offset_limit_n, ramp_in_s, ramp_out_s, hold_periods,
      fade_s, missing_part, late_periods, sigma_limit_n, rejoins_a_minute, limited_part,
      disobeyed_part, force_limit_n, rate_limit_n_per_s, free_rate_n_per_s, power_limit_w,
      actuator_stiffness_n_per_m, realtime, priority, cpu, record_s, record_files, record_mb, kind,
      open_loop, force_n, from_hz, to_hz, window_s, windows, lines);
}

}  // namespace stillframe::controller

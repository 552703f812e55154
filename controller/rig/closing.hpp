#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "controller/gains.hpp"
#include "controller/io.hpp"
#include "controller/policy.hpp"
#include "controller/rig/probe.hpp"

namespace stillframe::controller {

/// What a loop did while it was closed on a rig and excited.
struct ClosedRecording {
  /// From the first sample at which the loop was active; `command` has the excitation alone. Its
  /// windows are those through which the loop was active.
  Recording recording;
  Eigen::MatrixXd sent;          ///< n x m, N, whole commands; held where there was none
  std::vector<int> lines;        ///< whole periods in a window, that it was excited at
  Eigen::Index n_window = 0;     ///< samples
  Eigen::VectorXd frame_peak;    ///< q, m/s^2, from its mean while arming; of all the time
  double force_peak = 0;         ///< N, the largest command
  double added_force = 0;        ///< N, its largest excitation
  std::int64_t n_faults = 0;     ///< that passed
  std::string last_fault;        ///< of them, in words
  std::int64_t n_saturated = 0;  ///< commands that met a limit
};

/// Closes the loop of these gains on a rig by the whole supervisor: arms, ramps in, excites as the
/// policy says, ramps out, and switches the amplifiers off. n_floor, n_frame: accelerations that
/// the Io fills in. progress: of 0 to 1. Set-up, but for what goes to the Io. Errors: Refusal as
/// require_stable and require_stable_ramp, before anything is sent; std::runtime_error where the
/// loop does not become active, a fault is latched, no samples come, too many are lost, or `stop`
/// says so; the frame has been let go of by then.
ClosedRecording close_on_rig(Io& io, const Gains& gains, const Policy& policy, Eigen::Index n_floor,
                             Eigen::Index n_frame, const ProbeTime& time,
                             const std::function<void(double)>& progress,
                             const std::function<bool()>& stop);

}  // namespace stillframe::controller

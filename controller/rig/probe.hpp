#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "controller/gains.hpp"
#include "controller/io.hpp"
#include "controller/rig/scaled_io.hpp"

namespace stillframe::controller {

/// The time that a probe lives in; of tests one that does not wait.
struct ProbeTime {
  std::function<std::int64_t()> now_ns;
  std::function<void(std::int64_t)> sleep_until_ns;
};
ProbeTime real_time();

/// A force sensor went beyond most_n; the force has faded.
class TooFar : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// How a rig is probed: one leg after the other by a multisine, all others at rest.
struct ProbeSettings {
  double sample_rate_hz = 0;
  double force_n = 1;  ///< peak
  /// N: a reading of a force sensor further from its mean than this and ten times what it was at
  /// rest ends the probe.
  double most_n = 10;
  /// Samples of a window; lines are whole multiples of rate / n_window.
  std::int64_t n_window = 200;
  int n_windows = 5;                      ///< that are kept of each leg
  std::vector<int> lines;                 ///< whole numbers of periods in a window
  Eigen::Index n_floor = 0, n_frame = 0;  ///< accelerations that the Io fills in
};

/// N, what a leg is driven by while it is probed: what is asked for, or small_force of the limit.
/// Errors: InputError without a limit (source: whose it would be), or beyond it.
double probe_force(const std::optional<double>& asked, const Gains& gains,
                   const std::filesystem::path& source);

/// How the legs of these gains are probed by that force, on a rig with these channels.
ProbeSettings probe_settings(const Gains& gains, const Channels& channels, double force_n);

/// What the rig read at the lines of the probe while one leg was driven, or none.
struct Response {
  Eigen::VectorXcd command;       ///< lines, N, of the leg that is driven; zero of none
  Eigen::MatrixXcd sigma;         ///< lines x m, N
  Eigen::MatrixXcd applied;       ///< lines x m, N
  Eigen::VectorXd sigma_scatter;  ///< m, N, standard deviation of a line's mean, rms over lines
  Eigen::VectorXd sigma_mean;     ///< m, N
  Eigen::VectorXd sigma_peak;     ///< m, N, of the reading from its mean
};

struct Probe {
  Response rest;               ///< nothing driven
  std::vector<Response> legs;  ///< m
  double drift = 0;            ///< of the samples' clock, 1
  std::int64_t n_samples = 0, n_lost = 0;
};

/// A recording of a rig, m legs, q accelerations of the frame, p of the floor, one row a sample.
struct Recording {
  Eigen::MatrixXd command;         ///< n x m, N, in answer to the sample; held where there was none
  Eigen::MatrixXd sigma, applied;  ///< n x m, N; on a straight line where a sample was lost
  Eigen::MatrixXd frame, floor;    ///< n x q and n x p, m/s^2, likewise
  std::vector<Eigen::Index> windows;  ///< where each window begins of which hardly a sample is lost
  std::vector<Eigen::Index> driven;   ///< of each window, the leg; -1: none
  std::vector<bool> missing;          ///< n, whether the sample did not come
  double drift = 0;                   ///< of the samples' clock, 1
  std::int64_t n_samples = 0, n_lost = 0;
};

/// n rows of nothing, of m legs, and of the accelerations that a measurement has.
Recording empty_recording(Eigen::Index n, Eigen::Index m, const Measurement& measurement);
/// What was read, in its row.
void put(const Measurement& measurement, Eigen::Index row, Recording& recording);

/// Chooses the windows of a recording of which no more than a part of the samples is lost, and
/// fills in what is: from a row on, at_rest windows of n samples with nothing driven, then of each
/// of m legs one in which the drive rises, so many driven, and one in which it falls. there: of
/// each row, whether it was read. Set-up. Errors: std::runtime_error where fewer than two are left
/// of any.
void choose_windows(Recording& recording, const std::vector<bool>& there, Eigen::Index from,
                    Eigen::Index n, Eigen::Index at_rest, Eigen::Index windows, Eigen::Index m,
                    double most_missing);

/// Samples before the first window and behind the last.
inline constexpr Eigen::Index recording_margin = 40;

/// Records a rig, n_windows with each leg driven and twice as many at rest, by one multisine of all
/// lines over n_window samples. Nothing has to settle. Otherwise as probe_rig.
Recording record_rig(Io& io, Eigen::Index m, const ProbeSettings& settings, const ProbeTime& time,
                     const std::function<void(double)>& progress,
                     const std::function<bool()>& stop);

/// Probes a rig. Forces rise and fall within a window each, so that nothing is kicked. progress: of
/// 0 to 1. Set-up, but for what goes to the Io. Errors: std::runtime_error where no samples come,
/// too many are lost, a force is beyond most_n (TooFar), or `stop` says so; the force has faded by
/// then.
Probe probe_rig(Io& io, Eigen::Index m, const ProbeSettings& settings, const ProbeTime& time,
                const std::function<void(double)>& progress, const std::function<bool()>& stop);

}  // namespace stillframe::controller

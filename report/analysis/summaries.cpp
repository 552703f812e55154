#include "report/analysis/summaries.hpp"

#include <algorithm>
#include <cmath>

#include "core/numerics/two_pi.hpp"
#include "report/identification/confidence.hpp"
#include "report/verdict/motion_level.hpp"

namespace stillframe::report {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// The commands that a controller gave, by its own account.
std::optional<std::int64_t> commands_given(const LogAnalysis& log) {
  const LogScan& scan = log.scan;
  if (scan.info.mode != "wall_clock") {
    // In step every measurement is answered, but for those that the controller has lost.
    const std::int64_t lost = scan.controller_timing ? scan.controller_timing->n_lost : 0;
    return scan.measurements.n_received + scan.measurements.n_lost - lost;
  }
  if (log.n_periods == 0) return std::nullopt;
  const std::int64_t dropped = scan.last_status ? scan.last_status->n_commands_dropped : 0;
  return log.n_commanded - dropped;
}

TimingSummary::Quantiles quantiles_of(const DurationHistogram& histogram) {
  return {.p50_us = histogram.quantile_us(0.5),
          .p99_us = histogram.quantile_us(0.99),
          .p999_us = histogram.quantile_us(0.999)};
}

}  // namespace

RunSummary run_summary(const LogAnalysis& log) {
  const LogScan& scan = log.scan;
  const auto& info = scan.info;
  RunSummary run{.scene_name = info.scene_name,
                 .scene_hash = info.scene_hash,
                 .program_version = info.program_version,
                 .mode = info.mode,
                 .loop = info.loop,
                 .sample_rate_hz = info.sample_rate_hz,
                 .delay_samples = info.delay_samples,
                 .n_samples = scan.measurements.n_received,
                 .judged_from_s = static_cast<double>(log.judged_from) / info.sample_rate_hz,
                 .judged_to_s = static_cast<double>(log.judged_until) / info.sample_rate_hz,
                 .n_judged = log.n_judged,
                 .n_lost = scan.measurements.n_lost,
                 .n_duplicates = scan.measurements.n_duplicates,
                 .n_commands = scan.commands.n_received,
                 .n_saturated = scan.n_saturated,
                 .n_damaged = scan.n_damaged + scan.n_undecodable,
                 .unread_bytes = scan.unread_bytes,
                 .n_other_version = scan.n_other_version,
                 .n_foreign = 0,
                 .n_clock_steps = scan.n_clock_steps};
  for (const auto& [name, count] : scan.foreign) run.n_foreign += count;
  const double plant_time =
      static_cast<double>(scan.measurements.n_spanned()) / info.sample_rate_hz;
  const double wall_time = scan.plant_timing
                               ? 1e-9 * static_cast<double>(scan.plant_timing->wall_time_ns)
                               : scan.log_duration_s;
  if (wall_time > 0) run.real_time_factor = plant_time / wall_time;
  run.n_periods = log.n_periods;
  run.n_discarded = log.n_discarded;
  if (info.mode == "wall_clock") {
    run.n_unanswered = std::max<std::int64_t>(0, scan.commands.n_lost - log.n_discarded);
  }
  run.n_commands_given = commands_given(log);
  run.n_not_finite = scan.faults.n_not_finite;
  run.first_not_finite = scan.faults.first_not_finite;
  run.n_repeats = scan.faults.n_repeats;
  return run;
}

std::vector<TimingSummary> timing_summaries(const LogAnalysis& log) {
  std::vector<TimingSummary> lines;
  for (const auto* timing : {&log.scan.plant_timing, &log.scan.controller_timing}) {
    if (!*timing) continue;
    const auto& t = **timing;
    lines.push_back({.loop = log.scan.info.loop,
                     .source = t.source,
                     .n_periods = t.n_periods,
                     .n_late = t.n_late,
                     .n_lost = t.n_lost,
                     .n_duplicates = t.n_duplicate,
                     .n_listened = t.n_listened,
                     .worst_wake_up_us = 1e-3 * static_cast<double>(t.worst_wake_up_ns),
                     .worst_compute_us = 1e-3 * static_cast<double>(t.worst_compute_ns),
                     .wake_up = {},
                     .compute = {}});
    if (t.source == "controller" && log.wake_up.count() > 0) {
      lines.back().wake_up = quantiles_of(log.wake_up);
      lines.back().compute = quantiles_of(log.compute);
    }
  }
  return lines;
}

MotionLevel motion_level(const SignalAnalysis& signal) {
  if (signal.third_octaves.size() == 0) {
    MotionLevel level;
    level.peak_acceleration = signal.peak;
    level.whole_rms = signal.rms;
    return level;
  }
  MotionLevel level = motion_level(signal.power, signal.third_octaves, signal.peak);
  level.whole_rms = signal.rms;
  return level;
}

std::optional<double> range_rms(const SignalAnalysis& signal, double from_hz, double to_hz) {
  if (signal.power.density.size() == 0) return std::nullopt;
  return band_rms(signal.power, from_hz, to_hz);
}

void fill_levels(AskedMotion& motion, const SignalAnalysis* floor, const SignalAnalysis* passive,
                 const SignalAnalysis* active, const ForcesPart* forces) {
  const double from_hz = motion.asked.from_hz, to_hz = motion.asked.to_hz;
  const auto fill = [&](const SignalAnalysis* signal, std::optional<double>& level, double& jumps,
                        double& leak) {
    if (signal == nullptr) return;
    level = range_rms(*signal, from_hz, to_hz);
    jumps = jumps_in_band(signal->power, from_hz, to_hz);
    leak = leak_in_band(signal->power, from_hz, to_hz);
    motion.narrowest_hz = std::max(motion.narrowest_hz, narrowest_band_hz(signal->power));
  };
  fill(floor, motion.floor, motion.floor_jumps, motion.floor_leak);
  fill(passive, motion.passive, motion.passive_jumps, motion.passive_leak);
  fill(active, motion.active, motion.active_jumps, motion.active_leak);
  if (forces != nullptr && forces->undisturbed.density.size() > 0) {
    motion.active_by_forces = band_rms(forces->by_forces, from_hz, to_hz);
    motion.active_undisturbed = band_rms(forces->undisturbed, from_hz, to_hz);
  }
}

MotionSpectra motion_spectra(const SignalAnalysis& signal) {
  MotionSpectra spectra;
  if (signal.third_octaves.size() == 0) return spectra;
  spectra.velocity.assign(signal.third_octaves.begin(), signal.third_octaves.end());
  spectra.narrowest_hz = narrowest_band_hz(signal.power);
  for (const OctaveBand& band : third_octave_bands()) {
    spectra.jumps.push_back(jumps_in_band(signal.power, band.lower_hz, band.upper_hz) /
                            (two_pi * band.lower_hz));
    spectra.leak.push_back(leak_in_band(signal.power, band.lower_hz, band.upper_hz) /
                           (two_pi * band.lower_hz));
    spectra.cumulative_rms.push_back(band.upper_hz <= 0.5 * signal.power.sample_rate_hz
                                         ? band_rms(signal.power, 0, band.upper_hz)
                                         : std::nan(""));
  }
  return spectra;
}

std::vector<ShockSummary> shock_summaries(const LogAnalysis& log) {
  std::vector<ShockSummary> summaries;
  for (const AxisAnalysis& axis : log.axes) {
    for (const Shock& shock : axis.shocks) {
      summaries.push_back({.axis = axis.name,
                           .loop = log.scan.info.loop,
                           .time_s = shock.time_s,
                           .floor_level = shock.floor_level,
                           .frame_level = shock.frame_level,
                           .settling_s = shock.settling_s});
    }
  }
  return summaries;
}

std::vector<EffortSummary> effort_summaries(const LogAnalysis& log, std::optional<double> limit) {
  std::vector<EffortSummary> summaries;
  for (const LegAnalysis& leg : log.legs) {
    if (leg.applied_peak == 0 && leg.command_peak == 0) continue;
    summaries.push_back({.loop = log.scan.info.loop,
                         .leg = leg.name,
                         .applied_rms = leg.applied_rms,
                         .applied_peak = leg.applied_peak,
                         .command_peak = leg.command_peak,
                         .limit = limit});
  }
  return summaries;
}

std::vector<NoiseSummary> noise_summaries(const LogAnalysis& log) {
  std::vector<NoiseSummary> summaries;
  for (const AxisAnalysis& axis : log.axes) {
    NoiseSummary noise{.axis = axis.name,
                       .loop = log.scan.info.loop,
                       .rms_acceleration = {},
                       .share = {},
                       .missing = axis.unexplained_missing};
    const double whole = motion_level(axis.frame).rms_acceleration;
    if (axis.unexplained && axis.unexplained->density.size() > 0) {
      noise.rms_acceleration = band_rms(*axis.unexplained, lowest_level_hz, highest_level_hz);
      if (whole > 0) noise.share = *noise.rms_acceleration / whole;
    }
    summaries.push_back(std::move(noise));
  }
  return summaries;
}

std::vector<Transmissibility> transmissibilities(const LogAnalysis& log,
                                                 const FrequencyResponse& axis_matrix) {
  std::vector<Transmissibility> summaries;
  for (std::size_t a = 0; a < log.axes.size(); ++a) {
    const Index i = log.axis_signals.output[a];
    const VectorXd along = log.axis_signals.along.row(static_cast<Index>(a)).transpose();
    Transmissibility t{.axis = log.axes[a].name,
                       .loop = log.scan.info.loop,
                       .frequencies_hz = axis_matrix.frequencies_hz,
                       .value = {},
                       .lower = {},
                       .upper = {},
                       .coherence = {}};
    for (Index l = 0; l < axis_matrix.n_frequencies(); ++l) {
      const Interval band = magnitude_band(axis_matrix, l, i, along, 0.95);
      const auto& T = axis_matrix.T[static_cast<std::size_t>(l)];
      t.value.push_back(std::abs((T.row(i) * along).value()));
      t.lower.push_back(band.lower);
      t.upper.push_back(band.upper);
      t.coherence.push_back(axis_matrix.coherence(l, i));
    }
    summaries.push_back(std::move(t));
  }
  return summaries;
}

}  // namespace stillframe::report

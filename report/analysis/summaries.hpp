#pragma once

#include "report/analysis/log_analyser.hpp"
#include "report/verdict/verdict.hpp"

namespace stillframe::report {

// What the verdict says of the parts of an analysed log.

/// What ran, and how whole its log is.
RunSummary run_summary(const LogAnalysis& log);
/// What plant and controller published of their own deadlines, with quantiles of the periods that
/// the log holds.
std::vector<TimingSummary> timing_summaries(const LogAnalysis& log);
/// Zeros and no class for a signal without a spectrum.
MotionLevel motion_level(const SignalAnalysis& signal);
/// The rms acceleration from one frequency to another, m/s^2; none for a signal without a spectrum.
std::optional<double> range_rms(const SignalAnalysis& signal, double from_hz, double to_hz);

/// The same for every signal of what is asked of a direction, and how much of it the ends of the
/// records may be. floor, passive, active: null if there is none; forces: of the active frame, null
/// if there are none or they are not known.
void fill_levels(AskedMotion& motion, const SignalAnalysis* floor, const SignalAnalysis* passive,
                 const SignalAnalysis* active, const ForcesPart* forces);
MotionSpectra motion_spectra(const SignalAnalysis& signal);
std::vector<ShockSummary> shock_summaries(const LogAnalysis& log);
/// Of the legs that did anything. limit: N of every leg, if there is one.
std::vector<EffortSummary> effort_summaries(const LogAnalysis& log, std::optional<double> limit);
/// What the model, driven by the measured floor, leaves of the frame's motion, one a direction.
std::vector<NoiseSummary> noise_summaries(const LogAnalysis& log);
/// One a direction: what its frame makes of a floor that moves along its floor signal, with its
/// 95 % bands. axis_matrix: between log.axis_signals.
std::vector<Transmissibility> transmissibilities(const LogAnalysis& log,
                                                 const FrequencyResponse& axis_matrix);

}  // namespace stillframe::report

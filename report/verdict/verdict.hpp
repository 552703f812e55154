#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/mechanics/scene/acceptance.hpp"
#include "core/systems/frequency_range.hpp"
#include "report/verdict/judgement.hpp"

namespace stillframe::report {

struct PredictionError;
struct ReductionCheck;

/// A channel that rests where it should not.
struct RestingChannel {
  std::string name;
  std::string when = {};  ///< as "from 15 to 60 s"; empty: all the time

  std::string text() const { return when.empty() ? name : name + " (" + when + ")"; }
};

/// What ran, and how whole its log is.
struct RunSummary {
  std::string scene_name = {}, scene_hash = {}, program_version = {};
  std::string mode;  ///< lock_step, single_process or wall_clock
  std::string loop;  ///< active or passive
  double sample_rate_hz = 0;
  double delay_samples = 0;
  std::int64_t n_samples = 0;  ///< in the log
  /// By the clock a frame is passive until its loop has armed and ramped in, and once it has let
  /// go: from when to when motion is judged, s, and how many samples there are.
  double judged_from_s = 0, judged_to_s = 0;
  std::int64_t n_judged = 0;
  std::string never_held = {};  ///< why there is none that the loop held; empty: it did
  std::string let_go = {};      ///< why it held no longer; empty: it held to the end
  bool fault = false;           ///< by a fault of its controller, either
  std::int64_t n_lost = 0;      ///< measurements that the log should hold and does not
  std::int64_t n_duplicates = 0;
  std::int64_t n_commands = 0;
  /// What the controller gave by its own account; none: the log holds no such account.
  std::optional<std::int64_t> n_commands_given = {};
  std::int64_t n_saturated = 0;  ///< commands in which a force was limited
  std::int64_t n_damaged = 0, unread_bytes = 0;
  std::int64_t n_other_version = 0;  ///< messages of another version of our types
  std::int64_t n_foreign = 0;        ///< messages on channels that are not ours
  std::int64_t n_clock_steps = 0;    ///< of the logger's clock
  double real_time_factor = 0;       ///< plant time over wall time; 0 if neither clock tells
  /// Periods of a wall-clock controller in the log, and those of them whose measurement it rejected
  /// as late, not finite or out of range.
  std::int64_t n_periods = 0, n_discarded = 0;
  /// Of a wall-clock run: measurements behind the first command that no command of the log answers,
  /// those that were rejected left out.
  std::int64_t n_unanswered = 0;
  std::int64_t n_not_finite = 0;      ///< values in the log (SampleFaults)
  std::string first_not_finite = {};  ///< where
  std::int64_t n_repeats =
      0;  ///< measurements that are the one before to the bit on a moving floor
  std::string unreadable = {};  ///< why scene, gains or floor cannot be read; empty: they can
  /// What is measured and does not change though what moves it does, and forces that do not act
  /// though they are commanded.
  std::vector<RestingChannel> resting_channels = {}, resting_forces = {};
};

/// One process's own account of its deadlines.
struct TimingSummary {
  std::string loop;    ///< of the run
  std::string source;  ///< plant or controller
  std::int64_t n_periods = 0, n_late = 0, n_lost = 0, n_duplicates = 0, n_listened = 0;
  double worst_wake_up_us = 0, worst_compute_us = 0;
  /// Quantiles of the periods in the log, wall-clock controllers only: upper edges of bins, ten to
  /// a decade.
  struct Quantiles {
    double p50_us = 0, p99_us = 0, p999_us = 0;
  };
  std::optional<Quantiles> wake_up = {}, compute = {};
};

/// Measured against predicted frequency responses.
struct IdentificationSummary {
  int n_frequencies = 0;
  double lowest_hz = 0, highest_hz = 0;
  int n_open_compared = 0, n_closed_compared = 0;  ///< values of each loop (ComparisonRule)
  double allowed_db = 0;                           ///< beyond the bands
  double open_largest_db = 0, open_at_hz = 0;
  double closed_largest_db = 0, closed_at_hz = 0;
  double beyond_db = 0;  ///< furthest that a prediction of either lies outside the value's band
  double reduction_above_hz = 0;  ///< the reduction is judged above this
  int n_reduction_frequencies = 0, n_closed_below_open = 0;
  int n_reduction_unknown = 0;  ///< further ones where it is predicted and not known
  double reduction_largest_error_db = 0;
  bool forces_unknown = false;  ///< act besides the floor, and may be any difference

  int n_compared() const { return n_open_compared + n_closed_compared; }
  /// Passed: all predictions within their values' bands and what is allowed beyond, and the closed
  /// loop below the open one wherever it is judged. Not judged where that says nothing of a loop:
  /// no value of it is compared, or a reduction is predicted and known nowhere; or where it would
  /// fail, and forces may be why.
  Outcome outcome() const;
};

/// One signal's numbers in one direction.
struct MotionLevel {
  double rms_acceleration = 0;       ///< m/s^2, 1-80 Hz
  double peak_acceleration = 0;      ///< m/s^2, largest sample
  double whole_rms = 0;              ///< m/s^2, of all samples, whatever their frequency
  double largest_band_velocity = 0;  ///< m/s rms, largest one-third-octave band, 1-80 Hz
  double largest_band_hz = 0;        ///< nominal centre of that band
  std::string vibration_class;       ///< VC-A ... VC-G, or above VC-A
};
/// Spectra of one signal in one direction, a number for each of third_octave_bands().
struct MotionSpectra {
  std::vector<double> velocity;        ///< m/s rms in the band
  std::vector<double> cumulative_rms;  ///< m/s^2, from 0 to the band's upper edge
  /// m/s rms, how much of velocity may come of where the record begins and ends, and the root of
  /// how far its square may be wrong by what lies beside the band; empty: nothing.
  std::vector<double> jumps = {}, leak = {};
  double narrowest_hz = 0;  ///< of a band that the record resolves
};
/// What is asked of a direction, beside the rms accelerations in its range, m/s^2.
struct AskedMotion {
  AxisAcceptance asked;
  bool by_scene = false;     ///< the scene asks for it by name
  std::string why_not = {};  ///< why a ratio to the floor cannot be asked; empty: it can
  std::optional<double> floor = {}, passive = {}, active = {};
  /// m/s^2, how much of these may come of where the records begin and end.
  double floor_jumps = 0, passive_jumps = 0, active_jumps = 0;
  /// m/s^2, the roots of how far their squares may be wrong by what lies beside the range.
  double floor_leak = 0, passive_leak = 0, active_leak = 0;
  double narrowest_hz = 0;  ///< of a range that the records resolve
  /// m/s^2, what the model makes of the forces that act on the active frame besides the floor, and
  /// what is left of its motion without that; none: there are no such forces, or it is not known.
  std::optional<double> active_by_forces = {}, active_undisturbed = {};
};
/// Signals that were recorded on one and the same floor: an axis stands twice where the passive and
/// the active run had floors of their own.
struct AxisLevels {
  std::string axis;
  std::optional<MotionLevel> floor, passive, active;
  std::optional<MotionSpectra> floor_spectra = {}, passive_spectra = {}, active_spectra = {};
  std::vector<AskedMotion> asked = {};
  std::string resting = {};  ///< why nothing is read from its signals; empty: they are read
};

/// From floor to frame in one direction, identified.
struct Transmissibility {
  std::string axis, loop;
  std::vector<double> frequencies_hz, value, lower, upper, coherence;  ///< 95 % bands; |T|, 1
};

/// What one frequency response of a log came to, against both predictions.
struct ResponseSummary {
  std::string loop;
  std::string what;          ///< as in "6 inputs to 6 outputs"
  std::string method = {};   ///< multisine or broadband
  std::string missing = {};  ///< why nothing was identified or compared; else empty
  int n_frequencies = 0;
  int n_compared = 0;                                ///< singular values (ComparisonRule)
  double sampled_largest_db = 0, sampled_at_hz = 0;  ///< against what the sampled loop must show
  double beyond_db = 0;     ///< furthest that that lies outside the band of a value
  double tolerance_db = 0;  ///< what is allowed of it
  /// dB, so far or further outside their bands lies a tenth of the values that are compared.
  double broadly_beyond_db = 0;
  /// Directions in which the floor's nodes may move and no input measures it: the prediction does
  /// not have that motion. If it is as large as that of the inputs, it may shift one value so far,
  /// dB, and a tenth of them so far or further.
  std::int64_t n_unmeasured = 0;
  double unmeasured_largest_db = 0, unmeasured_broadly_db = 0;
  /// It tells what another response of the run tells: a value of the one is that of the other.
  bool repeats = false;
  double continuous_largest_db = 0, continuous_at_hz = 0;
  std::int64_t n_segments = 0, n_filled = 0, n_left_out = 0;  ///< samples but for the first
  double resolution_hz = 0;
};

/// One shock: the largest rms of a tenth of a second of floor and frame, m/s^2.
struct ShockSummary {
  std::string axis, loop;
  double time_s = 0, floor_level = 0, frame_level = 0;
  std::optional<double> settling_s;  ///< none: not before the next shock or the end
};

/// What of the frame's motion the floor does not explain, 1-80 Hz: the motion less what the model
/// of the loop that ran makes of the measured floor, sample by sample. Noise is at most that: what
/// the model is not right in, distortion and forces that were limited are in it too.
struct NoiseSummary {
  std::string axis, loop;
  std::optional<double> rms_acceleration;  ///< m/s^2; none: not known
  std::optional<double> share;             ///< of the frame's rms
  std::string missing = {};                ///< why it is not known
};

/// What one leg's actuator did.
struct EffortSummary {
  std::string loop, leg;
  double applied_rms = 0, applied_peak = 0, command_peak = 0;  ///< N
  std::optional<double> limit;                                 ///< N
};

/// Everything that a run directory states. Left-out parts do not appear.
struct Verdict {
  std::vector<RunSummary> runs;
  std::vector<TimingSummary> timing;
  std::optional<IdentificationSummary> identification;
  std::vector<AxisLevels> axes;
  std::vector<ResponseSummary> responses;
  std::vector<Transmissibility> transmissibility;
  std::vector<ShockSummary> shocks;
  std::vector<NoiseSummary> noise;
  std::vector<EffortSummary> effort;
  std::optional<double> isolates_above_hz;  ///< twice the highest target, if it is known
  FrequencyRange judged = {1, 80};          ///< of the motion, where the scene names none
  bool disturbed = false;                   ///< forces act on the frame besides the floor
  std::string forces_unknown = {};          ///< why it is not known what they do; empty: it is
  bool floors_apart = false;                ///< each floor input moves on its own
  std::vector<std::string> warnings;        ///< what to know before comparing, a sentence each
  Judgement judgement;                      ///< of all this, by judge()
};

/// Fills the summary of both loops of a multisine run.
IdentificationSummary summarise(const PredictionError& open, const PredictionError& closed,
                                const ReductionCheck& reduction,
                                const std::vector<double>& frequencies_hz,
                                double reduction_above_hz);

/// The verdict as JSON, keys as docs/json/verdict.schema.json has them. Numbers read back to the
/// same bits (up to 17 significant digits), a number that is not finite is null.
std::string to_json(const Verdict& verdict);

/// The verdict as a page of text with aligned tables, units in the headers.
std::string to_text(const Verdict& verdict);

/// Writes to_json() to a file. Errors: those of WholeFile.
void write_json(const Verdict& verdict, const std::filesystem::path& path);

}  // namespace stillframe::report

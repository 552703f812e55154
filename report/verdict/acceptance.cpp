#include "report/verdict/acceptance.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "core/errors/formatted.hpp"
#include "report/log/sample_check.hpp"
#include "report/spectra/spectra.hpp"
#include "report/spectra/vibration_criteria.hpp"
#include "report/verdict/motion_level.hpp"

namespace stillframe::report {

namespace {

/// A ratio this many times what is allowed fails a run that is too short to pass.
constexpr double beyond_doubt = 10;

std::string percent(double share) { return formatted("%.3g %%", 100 * share); }

/// As the first word of a sentence.
std::string capital(std::string text) {
  text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
  return text;
}

std::string most_of(double share) { return share > 0 ? "at most " + percent(share) : "none"; }

/// With as many digits as tell both ends apart.
std::string hz_range(const AxisAcceptance& asked) {
  for (int digits = 4; digits < 17; ++digits) {
    const std::string from = formatted("%.*g", digits, asked.from_hz);
    const std::string to = formatted("%.*g", digits, asked.to_hz);
    if (from != to) return "from " + from + " to " + to + " Hz";
  }
  return formatted("from %.17g to %.17g Hz", asked.from_hz, asked.to_hz);
}

const RunSummary* active_run(const Verdict& verdict) {
  for (const RunSummary& run : verdict.runs) {
    if (run.loop == "active") return &run;
  }
  return nullptr;
}

class Judge {
 public:
  Judge(const Verdict& verdict, const SceneAcceptance& accept)
      : verdict_(verdict), accept_(accept), active_(active_run(verdict)) {}

  std::vector<Check> checks(std::vector<Check> prediction) {
    for (const RunSummary& run : verdict_.runs) record_of(run);
    if (active_ != nullptr) hold_of(*active_);
    if (active_ != nullptr) effort_of(*active_);
    motion(std::any_of(prediction.begin(), prediction.end(),
                       [](const Check& check) { return check.is_proof; }));
    for (Check& check : prediction) add(std::move(check));
    return std::move(checks_);
  }

 private:
  void add(Check check) { checks_.push_back(std::move(check)); }

  void record_of(const RunSummary& run) {
    const std::string of = "the " + run.loop + " run";
    const bool whole = run.n_damaged == 0 && run.unread_bytes == 0;
    add({.subject = Subject::record,
         .what = "log of " + of,
         .asked = "whole",
         .found = whole ? "whole"
                        : std::to_string(run.n_damaged) + " damaged places, " +
                              std::to_string(run.unread_bytes) + " bytes unread at its end",
         .outcome = whole ? Outcome::passed : Outcome::failed,
         .reason = whole ? "The log of " + of + " is whole."
                         : "The log of " + of + " is damaged in " + std::to_string(run.n_damaged) +
                               " places, and " + std::to_string(run.unread_bytes) +
                               " bytes at its end cannot be read."});
    if (!run.unreadable.empty()) {
      add({.subject = Subject::record,
           .what = "scene, gains and floor in the log of " + of,
           .asked = "readable",
           .found = "not readable",
           .outcome = Outcome::failed,
           .reason = "What the log of " + of +
                     " says of scene, gains or floor cannot be read: " + run.unreadable + "."});
    }
    add_share({.what = "measurements that the log of " + of + " lacks",
               .n = run.n_lost,
               .of = run.n_samples + run.n_lost,
               .of_what = "measurements",
               .subject = Subject::record},
              accept_.lost_share, default_log_loss_share);
    if (&run == active_) commands_of(run);
    if (run.n_not_finite > 0) {
      const std::string many = std::to_string(run.n_not_finite);
      add({.subject = Subject::record,
           .what = "values that are not finite in the log of " + of,
           .asked = "none",
           .found = many,
           .outcome = Outcome::failed,
           .reason = "Values in the log of " + of + " that are not finite, or beyond " +
                     formatted("%g", largest_value) + " (N, m/s^2): " + many + ", the first at " +
                     run.first_not_finite + "."});
    }
    // Before what rests: there all does.
    if (run.n_repeats > 0) {
      add_share({.what = "measurements of " + of + " that repeat the one before in every channel",
                 .n = run.n_repeats,
                 .of = run.n_samples,
                 .of_what = "measurements",
                 .subject = Subject::record},
                accept_.lost_share, default_log_loss_share);
    }
    resting_of(run);
  }

  /// A sensor without a cable reads what a perfect frame does.
  void resting_of(const RunSummary& run) {
    const auto joined = [](const std::vector<RestingChannel>& channels) {
      std::string text;
      for (const auto& channel : channels) text += (text.empty() ? "" : ", ") + channel.text();
      return text;
    };
    if (!run.resting_channels.empty()) {
      const std::string names = joined(run.resting_channels);
      add({.subject = Subject::record,
           .what = "measurements in the log of the " + run.loop + " run that never change",
           .asked = "none",
           .found = names,
           .outcome = Outcome::not_judged,
           .reason = "In the log of the " + run.loop + " run " + names +
                     (run.resting_channels.size() == 1 ? " never changes" : " never change") +
                     " by a bit though what moves the frame does, as of a sensor that is dead or "
                     "coarser than the motion: nothing passes by it.",
           .is_needed = true});
    }
    if (!run.resting_forces.empty()) {
      const std::string names = joined(run.resting_forces);
      add({.subject = Subject::record,
           .what = "forces in the log of the " + run.loop + " run that never act",
           .asked = "none",
           .found = names,
           .outcome = Outcome::failed,
           .reason = "In the log of the " + run.loop + " run the applied force of " + names +
                     " never changes by a bit though the commands do: they do not act, or what "
                     "acts is not measured."});
    }
  }

  void commands_of(const RunSummary& run) {
    const std::string what = "commands that the log of the active run lacks";
    if (!run.n_commands_given) {
      unknown(Subject::record, what, accept_.lost_share, default_log_loss_share,
              "the log holds no record of what the controller sent");
      return;
    }
    add_share({.what = what,
               .n = std::max<std::int64_t>(0, *run.n_commands_given - run.n_commands),
               .of = std::max(*run.n_commands_given, run.n_commands),
               .of_what = "commands",
               .subject = Subject::record},
              accept_.lost_share, default_log_loss_share);
  }

  /// A share of which the log does not tell.
  void unknown(Subject subject, const std::string& what, std::optional<double> by_scene,
               double otherwise, const std::string& why) {
    add({.subject = subject,
         .what = what,
         .asked = most_of(by_scene.value_or(otherwise)),
         .found = "",
         .outcome = Outcome::not_judged,
         .reason = capital(what) + ": " + why + ".",
         .by_scene = by_scene.has_value()});
  }

  struct Share {
    std::string what;
    std::int64_t n = 0, of = 0;
    const char* of_what = "";
    Subject subject = Subject::effort;
  };
  void add_share(const Share& share, std::optional<double> by_scene, double otherwise) {
    const double allowed = by_scene.value_or(otherwise);
    const double found =
        share.of > 0 ? static_cast<double>(share.n) / static_cast<double>(share.of) : std::nan("");
    const std::string most = most_of(allowed);
    const std::string many = std::to_string(share.n) + " of " + std::to_string(share.of);
    const std::string what = capital(share.what);
    add({.subject = share.subject,
         .what = share.what,
         .asked = most,
         .found = many + (share.of > 0 ? ", " + percent(found) : ""),
         .outcome = at_most(found, allowed),
         .reason = share.of > 0
                       ? what + ": " + many + " (" + percent(found) + "), allowed: " + most + "."
                       : what + ": the log holds no " + share.of_what + ".",
         .by_scene = by_scene.has_value()});
  }

  /// A frame that its loop never held shows nothing of it, and one that it let go of in a fault is
  /// as good as held only until then.
  void hold_of(const RunSummary& run) {
    if (!run.let_go.empty()) {
      const std::string until = formatted("%.4g s", run.judged_to_s);
      add({.subject = Subject::effort,
           .what = "hold of the loop on the frame",
           .asked = "until the end, or a stop",
           .found = "until " + until,
           .outcome = run.fault ? Outcome::failed : Outcome::passed,
           .reason = "The loop held the frame until " + until + ", then " + run.let_go + "."});
    }
    if (run.never_held.empty()) return;
    add({.subject = Subject::effort,
         .what = "hold of the loop on the frame",
         .asked = "with its whole command",
         .found = "never",
         .outcome = run.fault ? Outcome::failed : Outcome::not_judged,
         .reason = "The loop never held the frame with its whole command: " + run.never_held + ".",
         .is_needed = true});
  }

  void effort_of(const RunSummary& run) {
    add_share({.what = "commands with a limited force",
               .n = run.n_saturated,
               .of = std::max(run.n_commands, run.n_commands_given.value_or(0)),
               .of_what = "commands"},
              accept_.limited_share, default_limited_share);
    unanswered(run);
    if (run.n_periods == 0) {
      if (accept_.discarded_share) {
        add({.subject = Subject::effort,
             .what = "periods whose measurement the controller rejected",
             .asked = "at most " + percent(*accept_.discarded_share),
             .found = "0",
             .outcome = run.mode == "wall_clock" ? Outcome::not_judged : Outcome::passed,
             .reason = run.mode == "wall_clock"
                           ? "The log holds no record of what the controller rejected."
                           : "In step every measurement is answered.",
             .by_scene = true});
      }
      return;
    }
    add_share({.what = "periods whose measurement the controller rejected",
               .n = run.n_discarded,
               .of = run.n_periods,
               .of_what = "periods"},
              accept_.discarded_share, default_discarded_share);
  }

  void unanswered(const RunSummary& run) {
    const std::string what = "measurements that the controller never answered";
    const auto timing =
        std::find_if(verdict_.timing.begin(), verdict_.timing.end(),
                     [&](const auto& t) { return t.loop == run.loop && t.source == "controller"; });
    if (timing == verdict_.timing.end()) {
      unknown(Subject::effort, what, accept_.lost_share, default_unanswered_share,
              "the log holds no account of the controller's");
      return;
    }
    // Its own account, and the log's of all the controllers that the run had.
    add_share({.what = what,
               .n = std::max(timing->n_lost, run.n_unanswered),
               .of = run.n_samples + run.n_lost,
               .of_what = "measurements"},
              accept_.lost_share, default_unanswered_share);
  }

  /// otherwise: something else than motion is judged.
  void motion(bool otherwise) {
    const auto open = [&](const std::string& why, bool by_scene) {
      add({.subject = Subject::motion,
           .what = "motion of the frame",
           .asked = "as the scene says",
           .found = "",
           .outcome = Outcome::not_judged,
           .reason = why,
           .by_scene = by_scene});
    };
    if (active_ == nullptr) {
      open("There is no run of the active loop.", !accept_.axes.empty());
      return;
    }
    if (!active_->never_held.empty()) {
      open("The loop never held the frame that moved.", !accept_.axes.empty());
      return;
    }
    for (const AxisLevels& axis : verdict_.axes) {
      if (!axis.active) continue;
      if (!axis.resting.empty()) {
        const bool by_scene = std::any_of(axis.asked.begin(), axis.asked.end(),
                                          [](const AskedMotion& asked) { return asked.by_scene; });
        open("Axis " + axis.axis + ": " + axis.resting + ".", by_scene);
        continue;
      }
      for (const AskedMotion& asked : axis.asked) motion_of(axis, asked);
    }
    for (const AxisAcceptance& asked : accept_.axes) {
      const bool there = std::any_of(verdict_.axes.begin(), verdict_.axes.end(), [&](auto& axis) {
        return axis.axis == asked.axis && axis.active;
      });
      if (!there) {
        open("Axis " + asked.axis + ": nothing is compared there on this floor.", true);
      }
    }
    const bool any = std::any_of(checks_.begin(), checks_.end(), [](const Check& check) {
      return check.subject == Subject::motion;
    });
    if (!any && !otherwise) {
      open("No direction is compared: the scene names none, or each floor input moves on its own.",
           false);
    }
  }

  void motion_of(const AxisLevels& axis, const AskedMotion& motion) {
    const AxisAcceptance& a = motion.asked;
    const auto active = level_of(motion.active, motion.active_jumps, motion.active_leak);
    const auto passive = level_of(motion.passive, motion.passive_jumps, motion.passive_leak);
    if (a.vibration_class) class_of(axis, motion);
    if (!motion.why_not.empty() && (a.rms_of_floor || a.band_of_floor)) {
      add({.subject = Subject::motion,
           .what = "axis " + axis.axis + ", active against floor",
           .asked = "no more",
           .found = "",
           .outcome = Outcome::not_judged,
           .reason = "Axis " + axis.axis + ": " + motion.why_not + ".",
           .by_scene = motion.by_scene});
    } else if (a.rms_of_floor) {
      const Against against{&axis, &motion, "floor", "rms"};
      const auto floor = level_of(motion.floor, motion.floor_jumps, motion.floor_leak);
      const bool resolved = !(a.to_hz - a.from_hz < motion.narrowest_hz);
      if (active && floor && resolved && !floor_moves(axis, motion)) {
        add(open_ratio(against, *a.rms_of_floor, "the floor hardly moves " + hz_range(a)));
      } else {
        rms(against, active, floor, *a.rms_of_floor, without_forces(motion));
      }
    }
    if (a.rms_of_passive) {
      const Against against{&axis, &motion, "passive frame", "rms"};
      if (!rests(against, active, passive, *a.rms_of_passive)) {
        rms(against, active, passive, *a.rms_of_passive);
      }
    }
    if (a.band_of_floor && motion.why_not.empty()) {
      bands({&axis, &motion, "floor", "band"}, axis.floor_spectra, *a.band_of_floor);
    }
    if (a.band_of_passive) {
      const Against against{&axis, &motion, "passive frame", "band"};
      if (!rests(against, active, passive, *a.band_of_passive)) {
        bands(against, axis.passive_spectra, *a.band_of_passive);
      }
    }
  }

  /// Of the active frame, m/s^2, what at least is not the doing of forces besides the floor: what
  /// they may have done is no more than the model makes of them, and the doubt of that. None if
  /// there are none; a scene that asks by name asks of all that acts.
  std::optional<double> without_forces(const AskedMotion& motion) const {
    if (!verdict_.disturbed || motion.by_scene) return std::nullopt;
    const auto rest = level_of(motion.active_undisturbed, motion.active_jumps, motion.active_leak);
    if (!rest || !motion.active_by_forces) return 0;
    return rest->least() - doubt_of_forces * *motion.active_by_forces;
  }

  /// What is no number is not said to rest.
  static bool floor_moves(const AxisLevels& axis, const AskedMotion& motion) {
    return axis.floor && motion.floor &&
           !(*motion.floor <= 0 ||
             *motion.floor < least_floor_share * axis.floor->rms_acceleration);
  }

  /// Why averages of a range say too little, or nothing.
  std::string too_short(double from_hz) const {
    const double needed_s = least_periods / std::min(from_hz, lowest_judged_hz);
    const double there_s = active_->sample_rate_hz > 0
                               ? static_cast<double>(active_->n_judged) / active_->sample_rate_hz
                               : 0;
    if (there_s >= needed_s) return "";
    const std::string held = active_->judged_from_s > 0 ? " in which the loop held the frame" : "";
    return formatted("the run of %.3g s", there_s) + held +
           formatted(" is too short for levels, which need %.3g s", needed_s);
  }

  /// A level, and what of it may be something else than motion in its range.
  struct Level {
    double value = 0;
    double jumps = 0;  ///< where the record begins and ends
    double leak =
        0;  ///< the root of how far the square of the value may be wrong by what is beside
    double least() const {
      const double sure = value - std::min(jumps, value);
      return std::sqrt(std::max(0.0, sure - leak)) * std::sqrt(sure + leak);
    }
    double most() const { return std::hypot(value + jumps, leak); }
    /// In words, what most of the doubt comes of.
    std::string doubt() const {
      return (2 * value + jumps) * jumps >= leak * leak ? "where the records begin and end"
                                                        : "what moves beside the range";
    }
  };
  static std::optional<Level> level_of(std::optional<double> value, double jumps, double leak) {
    return value ? std::optional(Level{*value, jumps, leak}) : std::nullopt;
  }

  struct Against {
    const AxisLevels* axis;
    const AskedMotion* motion;
    const char* reference;
    const char* measure;  ///< rms, or band
  };
  /// What a ratio may be.
  struct Span {
    double found = 0, least = 0, most = 0;
    std::string doubt = {};                  ///< what the difference comes of
    std::optional<double> undisturbed = {};  ///< at least, without forces on the frame
  };
  static Span span_of(const Level& active, const Level& reference) {
    return {.found = active.value / reference.value,
            .least = active.least() / reference.most(),
            .most = active.most() / reference.least(),
            .doubt = (active.most() * reference.value > reference.most() * active.value ? active
                                                                                        : reference)
                         .doubt()};
  }

  Check open_ratio(const Against& against, double allowed, const std::string& why) const {
    return {.subject = Subject::motion,
            .what = "axis " + against.axis->axis + ", active to " + against.reference + ", " +
                    against.measure + " " + hz_range(against.motion->asked),
            .asked = formatted("at most %.4g", allowed),
            .found = "",
            .outcome = Outcome::not_judged,
            .reason = "Axis " + against.axis->axis + ": " + why + ".",
            .by_scene = against.motion->by_scene};
  }

  /// without_forces: m/s^2, of the active frame, at least.
  void rms(const Against& against, const std::optional<Level>& active,
           const std::optional<Level>& reference, double allowed,
           std::optional<double> without_forces = {}) {
    const AxisAcceptance& a = against.motion->asked;
    const std::string of = against.reference, range = hz_range(a);
    const auto open = [&](const std::string& why) { add(open_ratio(against, allowed, why)); };
    if (!active || !reference) {
      open("there is no motion of the " + of + " on the same floor to compare with");
    } else if (a.to_hz - a.from_hz < against.motion->narrowest_hz) {
      open("the range " + range + " is narrower than what the record resolves, " +
           formatted("%.3g Hz", against.motion->narrowest_hz));
    } else if (moves_too_little(*against.motion)) {
      open("it moves less than " + percent(least_axis_share) +
           " of what the largest axis does, which says nothing of the loop");
    } else {
      Span span = span_of(*active, *reference);
      if (without_forces) span.undisturbed = *without_forces / reference->most();
      ratio(against, span, *reference, allowed);
    }
  }

  void ratio(const Against& against, const Span& span, const Level& reference, double allowed) {
    const AxisAcceptance& a = against.motion->asked;
    const std::string of = against.reference, range = hz_range(a),
                      is = formatted("%.4g", span.found);
    const std::string too_short_for = too_short(a.from_hz);
    std::string open;
    bool is_needed = false;
    if (!too_short_for.empty() && span.found <= beyond_doubt * allowed) {
      open = too_short_for;
    } else if (reference.least() <= 0) {
      open = "the " + of + " hardly moves " + range + ": " + reference.doubt() +
             " may be all that is there";
    } else if (span.found <= allowed && span.most > allowed) {
      open =
          span.doubt +
          formatted(" may be so much of the range that the ratio, %.4g, is known up to %.4g only",
                    span.found, span.most);
    } else if (span.found > allowed && span.least <= allowed) {
      open = is + " times as much as the " + of + ", but " + span.doubt + " may be the difference";
    } else if (span.found > allowed && span.undisturbed && *span.undisturbed <= allowed) {
      open = is + " times as much as the " + of +
             ", but forces act on the frame besides the floor and may be the difference";
      if (!verdict_.forces_unknown.empty()) {
        open += " (what they do is not known: " + verdict_.forces_unknown + ")";
        is_needed = true;
      }
    }
    Check check = open_ratio(against, allowed, open);
    check.found = is;
    check.is_needed = is_needed;
    if (open.empty()) {
      check.outcome = at_most(span.found, allowed);
      check.reason = "Axis " + against.axis->axis + ": the active frame moves " + is +
                     " times as much as the " + of + " (" +
                     (std::string(against.measure) == "rms" ? "rms" : "worst third-octave band") +
                     " " + range + "), allowed is " + formatted("%.4g", allowed) + ".";
      // By the floor they are excused above.
      if (check.outcome == Outcome::failed && verdict_.disturbed && of == "passive frame") {
        check.reason.back() = ';';
        check.reason += " forces act on both besides the floor, and a softer frame gives way more.";
      }
    }
    add(std::move(check));
  }

  /// What a scene asks for by name it asks of any motion.
  bool moves_too_little(const AskedMotion& motion) const {
    return !motion.by_scene && report::moves_too_little(verdict_.axes, motion);
  }

  /// What a frame does that rests without its loop is its loop's doing.
  bool rests(const Against& against, const std::optional<Level>& active,
             const std::optional<Level>& passive, double allowed) {
    if (!active || !passive || !(passive->value <= rounding_acceleration)) return false;
    const std::string range = hz_range(against.motion->asked);
    Check check = open_ratio(against, allowed,
                             "neither frame moves " + range + " so that an instrument could tell");
    if (!(active->least() <= least_acceleration)) {
      if (moves_too_little(*against.motion)) return false;
      check.outcome = Outcome::failed;
      check.found = formatted("%.3g m/s^2, passive 0", active->value);
      check.reason =
          "Axis " + against.axis->axis + ": the passive frame rests, and the active one moves by " +
          formatted("%.3g m/s^2 rms ", active->value) + range + ", which only its own loop can do.";
    }
    add(std::move(check));
    return true;
  }

  void bands(const Against& against, const std::optional<MotionSpectra>& reference,
             double allowed) {
    const AskedMotion& motion = *against.motion;
    const auto &floor = against.axis->floor_spectra, &active = against.axis->active_spectra;
    const std::string of = against.reference, range = hz_range(motion.asked);
    const auto open = [&](const std::string& why) { add(open_ratio(against, allowed, why)); };
    if (!reference || !active || !floor) {
      return open("there is no motion of the " + of + " on the same floor to compare with");
    }
    double floor_largest = 0;
    for (const double v : floor->velocity) floor_largest = std::max(floor_largest, v);
    std::optional<Span> worst;
    bool any = false, hidden = false;
    std::string coarse;
    const auto centres = third_octave_bands();
    for (std::size_t i = 0; i < std::min({centres.size(), active->velocity.size(),
                                          reference->velocity.size(), floor->velocity.size()});
         ++i) {
      const OctaveBand& band = centres[i];
      if (band.nominal_hz < motion.asked.from_hz || band.nominal_hz > motion.asked.to_hz ||
          band.upper_hz > 0.5 * active_->sample_rate_hz) {
        continue;
      }
      any = true;
      // What is no number is not left out.
      if (floor->velocity[i] < least_floor_share * floor_largest || reference->velocity[i] == 0) {
        continue;
      }
      if (hides(*floor, i) || hides(*reference, i)) {
        hidden = true;
        if (coarse.empty() && band.upper_hz - band.lower_hz < reference->narrowest_hz) {
          coarse = formatted("the record does not resolve the third-octave band of %g Hz",
                             band.nominal_hz);
        }
        continue;
      }
      const Span span = span_of(level_in(*active, i), level_in(*reference, i));
      if (!worst) worst = span;
      if (!(span.found <= worst->found)) worst->found = span.found;
      if (span.most > worst->most) {
        worst->most = span.most;
        worst->doubt = span.doubt;
      }
      worst->least = std::max(worst->least, span.least);
      if (std::isnan(span.found)) break;
    }
    if (!any) return open("no third-octave band has its centre " + range);
    if (!coarse.empty() && !(worst && worst->least > allowed)) return open(coarse);
    if (!worst) {
      return open(
          "the " + of + " hardly moves in any third-octave band " + range +
          (hidden ? ", but for what its record's ends and its motion beside the band may be" : ""));
    }
    ratio(against, *worst, {.value = 1}, allowed);
  }

  static Level level_in(const MotionSpectra& spectra, std::size_t band) {
    Level level{.value = spectra.velocity[band]};
    if (band < spectra.jumps.size()) level.jumps = spectra.jumps[band];
    if (band < spectra.leak.size()) level.leak = spectra.leak[band];
    return level;
  }

  /// Whether a third of a band or more may come of where the record begins and ends, or nearly all
  /// of what is beside it.
  static bool hides(const MotionSpectra& spectra, std::size_t band) {
    const Level level = level_in(spectra, band);
    return 3 * level.jumps >= level.value || level.leak >= 0.9 * level.value;
  }

  void class_of(const AxisLevels& axis, const AskedMotion& motion) {
    const std::string asked = *motion.asked.vibration_class, met = axis.active->vibration_class;
    Check check{.subject = Subject::motion,
                .what = "axis " + axis.axis + ", vibration class, active",
                .asked = asked,
                .found = met,
                .outcome = class_rank(met) >= class_rank(asked) ? Outcome::passed : Outcome::failed,
                .reason = "Axis " + axis.axis + ": the active frame meets " + met + ", asked is " +
                          asked + ".",
                .by_scene = motion.by_scene};
    const std::string open = too_short(lowest_judged_hz);
    const auto not_judged = [&](const std::string& why) {
      check.outcome = Outcome::not_judged;
      check.reason = "Axis " + axis.axis + ": " + why + ".";
    };
    if (met == "not known") {
      const auto& v = axis.active_spectra->velocity;
      if (exceeds(Eigen::Map<const Eigen::VectorXd>(v.data(), std::ssize(v)), asked)) {
        check.reason = "Axis " + axis.axis + ": the active frame is above " + asked +
                       ", which is asked, in bands below half the sample rate.";
      } else {
        not_judged("bands of " + asked + " reach beyond half the sample rate");
      }
    }
    if (met.empty() || !open.empty()) {
      not_judged(open.empty() ? "there is no spectrum to take a class from" : open);
    } else if (axis.active_spectra && !axis.active_spectra->leak.empty() &&
               exceeds(of_bands(*axis.active_spectra, &Level::least), asked) !=
                   exceeds(of_bands(*axis.active_spectra, &Level::most), asked)) {
      not_judged("the active frame is at the limits of " + asked +
                 ", which is asked, and where its record begins and ends, or what it does not "
                 "resolve of the edges of a band, decides");
    }
    add(std::move(check));
  }

  static Eigen::VectorXd of_bands(const MotionSpectra& spectra, double (Level::*value)() const) {
    return Eigen::VectorXd::NullaryExpr(std::ssize(spectra.velocity), [&](Eigen::Index i) {
      return (level_in(spectra, static_cast<std::size_t>(i)).*value)();
    });
  }

  static constexpr double lowest_judged_hz = 1;
  const Verdict& verdict_;
  const SceneAcceptance& accept_;
  const RunSummary* active_;
  std::vector<Check> checks_;
};

}  // namespace

namespace {

void mark_apart(std::vector<AskedMotion>& list, const Verdict& verdict) {
  if (!verdict.floors_apart) return;
  for (AskedMotion& motion : list) motion.why_not = "each floor input moves on its own";
}

}  // namespace

std::vector<AskedMotion> asked_of(const SceneAcceptance& accept, const std::string& axis,
                                  const Verdict& verdict) {
  std::vector<AskedMotion> list;
  for (const AxisAcceptance& asked : accept.axes) {
    if (asked.axis == axis) list.push_back({.asked = asked, .by_scene = true});
  }
  if (!list.empty()) {
    mark_apart(list, verdict);
    return list;
  }
  double to_hz = verdict.judged.highest_hz;
  if (!verdict.runs.empty()) to_hz = std::min(to_hz, verdict.runs.front().sample_rate_hz / 2);
  AskedMotion passive{
      .asked = {
          .axis = axis, .from_hz = verdict.judged.lowest_hz, .to_hz = to_hz, .rms_of_passive = 1}};
  AskedMotion floor{.asked = {.axis = axis, .to_hz = to_hz, .rms_of_floor = 1}};
  if (!verdict.isolates_above_hz) {
    floor.why_not = "what the loop is to isolate is not known, its target is in no log";
  } else if (!(*verdict.isolates_above_hz < to_hz)) {
    floor.why_not =
        formatted("the loop is to isolate above %.4g Hz only", *verdict.isolates_above_hz);
  } else {
    floor.asked.from_hz = *verdict.isolates_above_hz;
  }
  if (to_hz > passive.asked.from_hz) list.push_back(std::move(passive));
  list.push_back(std::move(floor));
  mark_apart(list, verdict);
  return list;
}

Judgement judge(const Verdict& verdict, const SceneAcceptance& accept,
                std::vector<Check> prediction) {
  Judgement judgement = conclude(Judge(verdict, accept).checks(std::move(prediction)));
  const std::string worse = worse_by_class(verdict.axes);
  // By default no check of its own (decision 21), but no pass keeps it to itself.
  if (judgement.outcome == Outcome::passed && !worse.empty()) {
    judgement.reason += " By vibration class the frame is worse than its floor in " + worse + ".";
  }
  return judgement;
}

}  // namespace stillframe::report

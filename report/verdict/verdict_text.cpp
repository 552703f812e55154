#include <algorithm>
#include <cmath>

#include "core/errors/formatted.hpp"
#include "report/said_once.hpp"
#include "report/table.hpp"
#include "report/verdict/verdict.hpp"

namespace stillframe::report {

namespace {

std::string count(std::int64_t n) { return std::to_string(n); }

/// Its lines below a table.
std::string indented(const std::string& before, const SaidOnce& said) {
  std::string text;
  for (const std::string& line : said.lines()) text += "  " + before + line + "\n";
  return text;
}

std::string runs_text(const std::vector<RunSummary>& runs) {
  Table table({"loop", "mode", "rate Hz", "delay", "samples", "lost", "repeated", "commands",
               "saturated", "real time x"},
              2);
  std::string notes;
  for (const RunSummary& run : runs) {
    table.add({run.loop, run.mode, formatted("%g", run.sample_rate_hz),
               formatted("%g", run.delay_samples), count(run.n_samples), count(run.n_lost),
               count(run.n_duplicates), count(run.n_commands), count(run.n_saturated),
               run.real_time_factor > 0 ? formatted("%.2f", run.real_time_factor) : "unknown"});
    if (run.n_judged > 0 && run.n_judged < run.n_samples) {
      notes += "  the " + run.loop + " run is judged from " + formatted("%.4g", run.judged_from_s) +
               " s to " + formatted("%.4g", run.judged_to_s) + " s, " +
               (run.loop == "active" ? "when the loop held the frame" : "as the active one") +
               (run.let_go.empty() ? "" : "; then " + run.let_go) + "\n";
    }
    if (run.n_damaged > 0 || run.unread_bytes > 0) {
      notes += "  the log of the " + run.loop + " run is damaged: " + count(run.n_damaged) +
               " unreadable messages, " + count(run.unread_bytes) + " bytes at its end\n";
    }
    if (run.n_other_version > 0) {
      notes += "  " + count(run.n_other_version) + " messages of the " + run.loop +
               " run are of another version of this program\n";
    }
    if (run.n_clock_steps > 0) {
      notes += "  the logger's clock stepped " + count(run.n_clock_steps) + " times in the " +
               run.loop + " run\n";
    }
  }
  const RunSummary& first = runs.front();
  return "Scene " + first.scene_name + " (" + first.scene_hash + "), stillframe " +
         first.program_version + "\n" + table.print() + notes;
}

const char* in_short(Outcome outcome) {
  if (outcome == Outcome::not_judged) return "not judged";
  return outcome == Outcome::passed ? "pass" : "FAIL";
}

std::string identification_text(const IdentificationSummary& id) {
  Table table({"measured against the sampled-data prediction", "largest dB", "at Hz"}, 1);
  const auto add = [&table](const char* loop, int n, double largest_db, double at_hz) {
    table.add(
        {loop, n > 0 ? formatted("%.4f", largest_db) : "-", n > 0 ? formatted("%g", at_hz) : ""});
  };
  add("singular values, open loop", id.n_open_compared, id.open_largest_db, id.open_at_hz);
  add("singular values, closed loop", id.n_closed_compared, id.closed_largest_db, id.closed_at_hz);
  table.add(
      {formatted("reduction by the loop, above %.4g Hz", id.reduction_above_hz),
       id.n_reduction_frequencies > 0 ? formatted("%.4f", id.reduction_largest_error_db) : "-",
       ""});
  return formatted(
             "Identification: %d frequencies, %g to %g Hz, %d values compared, at most %.4f dB "
             "beyond their bands (allowed: %.4g dB): %s\n",
             id.n_frequencies, id.lowest_hz, id.highest_hz, id.n_compared(), id.beyond_db,
             id.allowed_db, in_short(id.outcome())) +
         table.print() +
         formatted(
             "  closed loop below open loop at %d of the %d frequencies above %.4g Hz where it is "
             "to be",
             id.n_closed_below_open, id.n_reduction_frequencies, id.reduction_above_hz) +
         (id.n_reduction_unknown > 0 ? formatted(", not known at %d more", id.n_reduction_unknown)
                                     : "") +
         "\n";
}

/// Four significant digits without an exponent where that is readable.
std::string level(double value) {
  return value != 0 && (std::abs(value) < 1e-3 || std::abs(value) >= 1e5)
             ? formatted("%.3e", value)
             : formatted("%.4g", value);
}

std::string ratio(const std::optional<MotionLevel>& signal,
                  const std::optional<MotionLevel>& reference, double MotionLevel::*value) {
  if (!signal || !reference || !((*reference).*value > 0)) return "-";
  return formatted("%.4f", (*signal).*value / ((*reference).*value));
}

std::string axes_text(const std::vector<AxisLevels>& axes) {
  Table table({"axis", "signal", "rms mm/s^2", "of floor", "of passive", "band um/s", "of floor",
               "of passive", "at Hz", "class"},
              2);
  for (const AxisLevels& axis : axes) {
    const std::pair<const char*, const std::optional<MotionLevel>&> signals[] = {
        {"floor", axis.floor}, {"passive", axis.passive}, {"active", axis.active}};
    for (const auto& [name, signal] : signals) {
      if (!signal) continue;
      const auto rms = &MotionLevel::rms_acceleration;
      const auto band = &MotionLevel::largest_band_velocity;
      const bool is_floor = &signal == &axis.floor, is_active = &signal == &axis.active;
      table.add({axis.axis, name, level(1e3 * signal->rms_acceleration),
                 is_floor ? "" : ratio(signal, axis.floor, rms),
                 is_active ? ratio(signal, axis.passive, rms) : "",
                 level(1e6 * signal->largest_band_velocity),
                 is_floor ? "" : ratio(signal, axis.floor, band),
                 is_active ? ratio(signal, axis.passive, band) : "",
                 formatted("%g", signal->largest_band_hz), signal->vibration_class});
    }
  }
  return "Acceleration, 1-80 Hz, and the largest one-third-octave rms velocity\n" + table.print();
}

std::string timing_text(const std::vector<TimingSummary>& timing) {
  Table table({"loop", "process", "periods", "late", "lost", "repeated", "worst wake-up us",
               "worst compute us"},
              2);
  for (const TimingSummary& t : timing) {
    table.add({t.loop, t.source, count(t.n_periods), count(t.n_late), count(t.n_lost),
               count(t.n_duplicates), formatted("%.1f", t.worst_wake_up_us),
               formatted("%.1f", t.worst_compute_us)});
  }
  std::string text = "Timing\n" + table.print();
  for (const TimingSummary& t : timing) {
    if (!t.wake_up || !t.compute) continue;
    text += formatted(
        "  %s %s: wake-up %.3g us median, %.3g us p99, %.3g us p99.9; compute %.3g, %.3g, "
        "%.3g us (upper edges of bins, ten to a decade)\n",
        t.loop.c_str(), t.source.c_str(), t.wake_up->p50_us, t.wake_up->p99_us, t.wake_up->p999_us,
        t.compute->p50_us, t.compute->p99_us, t.compute->p999_us);
  }
  return text;
}

std::string responses_text(const std::vector<ResponseSummary>& responses) {
  Table table({"loop", "response", "method", "frequencies", "values compared", "sampled dB",
               "at Hz", "beyond its band", "continuous dB", "at Hz"},
              3);
  std::string notes;
  SaidOnce missing;
  for (const ResponseSummary& r : responses) {
    if (!r.missing.empty()) {
      missing.add(r.loop + ", " + r.what, r.missing);
      if (r.n_frequencies == 0) continue;
    }
    if (r.n_filled > 0) {
      notes += "  " + r.loop + ", " + r.what + ": " + count(r.n_filled) +
               " lost samples filled in, " + count(r.n_left_out) + " samples in no segment\n";
    }
    const bool compared = r.n_compared > 0;
    table.add({r.loop, r.what, r.method, count(r.n_frequencies), count(r.n_compared),
               compared ? formatted("%.4f", r.sampled_largest_db) : "-",
               compared ? formatted("%.4g", r.sampled_at_hz) : "",
               compared ? formatted("%.4f", r.beyond_db) : "",
               compared ? formatted("%.4f", r.continuous_largest_db) : "-",
               compared ? formatted("%.4g", r.continuous_at_hz) : ""});
  }
  return "Identified singular values that are known to 1 dB, against the predictions\n" +
         table.print() + indented("", missing) + notes;
}

std::string shocks_text(const std::vector<ShockSummary>& shocks) {
  constexpr std::size_t most = 12;
  Table table({"axis", "loop", "at s", "floor mm/s^2", "frame mm/s^2", "settled after s"}, 2);
  for (std::size_t i = 0; i < std::min(shocks.size(), most); ++i) {
    const ShockSummary& shock = shocks[i];
    table.add({shock.axis, shock.loop, formatted("%.1f", shock.time_s),
               level(1e3 * shock.floor_level), level(1e3 * shock.frame_level),
               shock.settling_s ? formatted("%.1f", *shock.settling_s) : "never"});
  }
  return "Shocks, rms over 0.1 s\n" + table.print() +
         (shocks.size() > most
              ? "  and " + count(static_cast<std::int64_t>(shocks.size() - most)) + " more\n"
              : "");
}

std::string noise_text(const std::vector<NoiseSummary>& noise) {
  Table table({"axis", "loop", "rms mm/s^2", "of the frame's"}, 2);
  std::string notes;
  for (const NoiseSummary& n : noise) {
    table.add({n.axis, n.loop, n.rms_acceleration ? level(1e3 * *n.rms_acceleration) : "not known",
               n.share ? formatted("%.5f", *n.share) : "-"});
    const std::string note = "  " + n.loop + ": " + n.missing + "\n";
    if (!n.missing.empty() && notes.find(note) == std::string::npos) notes += note;
  }
  return "Noise at most: motion of the frame that the model does not make of the floor, 1-80 Hz\n" +
         table.print() + notes;
}

std::string effort_text(const std::vector<EffortSummary>& effort) {
  Table table({"leg", "loop", "rms N", "peak N", "largest command N", "of its limit"}, 2);
  for (const EffortSummary& e : effort) {
    table.add({e.leg, e.loop, level(e.applied_rms), level(e.applied_peak), level(e.command_peak),
               e.limit ? formatted("%.3f", e.command_peak / *e.limit) : "no limit"});
  }
  return "Actuators\n" + table.print();
}

std::string checks_text(const std::vector<Check>& checks) {
  Table table({"check", "asked", "found", "outcome"}, 4);
  SaidOnce open;
  for (const Check& check : checks) {
    table.add({check.what, check.asked, check.found, std::string(to_text(check.outcome))});
    if (check.outcome == Outcome::not_judged) open.add(check.reason);
  }
  return "What was asked, and what was found\n" + table.print() + indented("not judged: ", open);
}

}  // namespace

std::string to_text(const Verdict& verdict) {
  std::string page;
  if (!verdict.runs.empty()) page += runs_text(verdict.runs) + "\n";
  if (verdict.identification) page += identification_text(*verdict.identification) + "\n";
  if (!verdict.axes.empty()) page += axes_text(verdict.axes) + "\n";
  if (!verdict.responses.empty()) page += responses_text(verdict.responses) + "\n";
  if (!verdict.noise.empty()) page += noise_text(verdict.noise) + "\n";
  if (!verdict.shocks.empty()) page += shocks_text(verdict.shocks) + "\n";
  if (!verdict.effort.empty()) page += effort_text(verdict.effort) + "\n";
  if (!verdict.timing.empty()) page += timing_text(verdict.timing) + "\n";
  const Judgement& judgement = verdict.judgement;
  if (!judgement.checks.empty()) page += checks_text(judgement.checks) + "\n";
  for (const std::string& warning : verdict.warnings) page += "Warning: " + warning + "\n";
  return page + "Verdict: " + std::string(to_text(judgement.outcome)) + ". " + judgement.reason +
         "\n";
}

}  // namespace stillframe::report

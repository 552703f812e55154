#include "judge/page_tables_of.hpp"

#include <algorithm>
#include <cmath>
#include <ctime>

#include "core/errors/formatted.hpp"
#include "report/page/html.hpp"
#include "report/said_once.hpp"
#include "report/table.hpp"
#include "report/verdict/motion_level.hpp"

namespace stillframe::judge {

using page::number_text;
using page::Severity;

namespace {

std::string count(std::int64_t n) { return std::to_string(n); }

std::string mode_in_words(const std::string& mode) {
  if (mode == "lock_step") return "lock step";
  if (mode == "wall_clock") return "wall clock";
  if (mode == "single_process") return "single process";
  return mode;
}

/// The direction that is isolated worst, and those that a class says are worse, in a sentence.
std::string headline(const report::Verdict& verdict) {
  const report::AxisLevels* worst = nullptr;
  for (const report::AxisLevels& axis : verdict.axes) {
    if (!axis.active || !axis.floor || !(axis.floor->rms_acceleration > 0)) continue;
    const auto ratio = [](const report::AxisLevels& a) {
      return a.active->rms_acceleration / a.floor->rms_acceleration;
    };
    if (worst == nullptr || !(ratio(axis) <= ratio(*worst))) worst = &axis;
  }
  if (worst == nullptr) return "";
  const double ratio = worst->floor->rms_acceleration / worst->active->rms_acceleration;
  const std::string worse = report::worse_by_class(verdict.axes);
  std::string text = "With the loop closed the frame shakes ";
  if (ratio >= 1) {
    text += "at least " + number_text(ratio, 2) +
            " times less than the floor (rms of 1 to 80 Hz; the worst direction is " + worst->axis +
            ", which meets " + worst->active->vibration_class + ")";
  } else {
    text += "more than the floor in direction " + worst->axis + ": " + number_text(1 / ratio, 2) +
            " times (rms of 1 to 80 Hz; it meets " + worst->active->vibration_class + ")";
  }
  if (!worse.empty()) {
    text +=
        std::string(ratio >= 1 ? ", but" : ", and") + " by vibration class it is worse in " + worse;
  }
  return text + ".";
}

/// The one reason, then what else did not pass.
std::vector<std::string> reasons_of(const report::Judgement& judgement) {
  std::vector<std::string> reasons{judgement.reason};
  constexpr std::size_t most = 12;
  report::SaidOnce others;
  for (const report::Check& check : judgement.checks) {
    if (check.outcome == report::Outcome::passed || judgement.reason.starts_with(check.reason)) {
      continue;
    }
    others.add(check.reason);
  }
  for (std::string& line : others.lines()) {
    if (reasons.size() < most) reasons.push_back(std::move(line));
  }
  return reasons;
}

/// unidentified: responses of the log, and why there are none.
void warn_of_log(const RunAnalysis& run, std::vector<page::Warning>& warnings,
                 report::SaidOnce& unidentified) {
  const report::LogScan& scan = run.data.scan;
  const std::string log = run.log.filename().string() + ": ";
  const auto warn = [&](Severity severity, const std::string& text) {
    warnings.push_back({severity, log + text});
  };
  if (scan.n_damaged > 0 || scan.unread_bytes > 0) {
    warn(Severity::severe, "the log is damaged in " + count(scan.n_damaged) + " places and " +
                               count(scan.unread_bytes) +
                               " bytes at its end cannot be read; what was readable is here.");
  }
  if (scan.measurements.n_lost > 0) {
    warn(Severity::severe, count(scan.measurements.n_lost) + " of " +
                               count(scan.measurements.n_lost + scan.measurements.n_received) +
                               " measurements are not in the log.");
  }
  if (scan.n_other_version > 0) {
    warn(Severity::warning, count(scan.n_other_version) +
                                " messages are of another version of their type and were left "
                                "out.");
  }
  const std::int64_t garbled = scan.n_undecodable - scan.n_other_version;
  if (garbled > 0) {
    warn(Severity::warning, count(garbled) + " messages could not be decoded.");
  }
  if (scan.n_too_late > 0) {
    warn(Severity::warning,
         count(scan.n_too_late) + " messages came too late to be put in their place.");
  }
  if (scan.n_clock_steps > 0) {
    warn(Severity::note, "the logger's clock stepped " + count(scan.n_clock_steps) + " times, by " +
                             formatted("%.3g", scan.largest_clock_step_s) + " s at most.");
  }
  if (scan.n_saturated > 0) {
    warn(Severity::warning, "forces were limited in " + count(scan.n_saturated) + " of " +
                                count(scan.commands.n_received) + " commands.");
  }
  if (!run.run.design) {
    warn(Severity::warning, "no prediction: " + run.run.unreadable);
  }
  // The inputs of the legs move together on most floors: then the axes tell all there is.
  const bool axes = run.axes && run.axes->measured.response;
  for (const auto* response : {&run.matrix, &run.axes}) {
    if (!*response || (response == &run.matrix && axes)) continue;
    const auto& measured = (*response)->measured;
    const std::string what =
        formatted("the response of %zu outputs to %zu inputs", measured.signals.outputs.size(),
                  measured.signals.inputs.size());
    if (!measured.missing.empty()) {
      unidentified.add(run.log.filename().string() + ", " + what, measured.missing);
    } else if (!(*response)->unpredicted.empty() && run.run.design) {
      warn(Severity::note, what + " has no prediction: " + (*response)->unpredicted + ".");
    }
    if (measured.n_filled > 0) {
      warn(Severity::note,
           "for " + what + ", " + count(measured.n_filled) + " lost samples were filled in.");
    }
  }
}

std::optional<page::Level> level_of(const std::optional<report::MotionLevel>& level) {
  if (!level) return std::nullopt;
  return page::Level{.rms_acceleration = level->rms_acceleration,
                     .peak_acceleration = level->peak_acceleration,
                     .band_velocity = level->largest_band_velocity,
                     .band_hz = level->largest_band_hz,
                     .vibration_class = level->vibration_class};
}

/// mm/s^2 of m/s^2.
std::string milli(double value) { return number_text(1e3 * value, 4); }

page::Table check_table(const std::vector<report::Check>& checks) {
  page::Table table{
      "What was asked, and what was found", {"check", "asked", "found", "outcome"}, {}};
  for (const report::Check& check : checks) {
    table.rows.push_back({check.what, check.asked, check.found.empty() ? "\u2013" : check.found,
                          std::string(report::to_text(check.outcome))});
  }
  return table;
}

page::Table response_table(const std::vector<report::ResponseSummary>& responses) {
  page::Table table{
      "Identified frequency responses: singular values that are known to 1 dB against both "
      "predictions",
      {"loop", "response", "method", "frequencies", "values compared", "largest error, sampled dB",
       "at Hz", "beyond its band, dB", "largest error, continuous dB", "at Hz", "resolution Hz"},
      {}};
  for (const report::ResponseSummary& r : responses) {
    const bool compared = r.n_compared > 0;
    table.rows.push_back({r.loop, r.what, r.method, count(r.n_frequencies), count(r.n_compared),
                          compared ? number_text(r.sampled_largest_db, 3) : "\u2013",
                          compared ? number_text(r.sampled_at_hz, 4) : "\u2013",
                          compared ? number_text(r.beyond_db, 3) : "\u2013",
                          compared ? number_text(r.continuous_largest_db, 3) : "\u2013",
                          compared ? number_text(r.continuous_at_hz, 4) : "\u2013",
                          number_text(r.resolution_hz, 2)});
  }
  return table;
}

page::Table shock_table(const std::vector<report::ShockSummary>& shocks) {
  page::Table table{
      "Shocks: largest rms of a tenth of a second, and the time until the frame is "
      "quiet again (below 4 times its rms before, or 5 % of its largest)",
      {"axis", "loop", "at s", "floor mm/s\u00b2", "frame mm/s\u00b2", "settled after s"},
      {}};
  constexpr std::size_t most = 50;
  for (std::size_t i = 0; i < std::min(shocks.size(), most); ++i) {
    const report::ShockSummary& s = shocks[i];
    table.rows.push_back({s.axis, s.loop, formatted("%.1f", s.time_s), milli(s.floor_level),
                          milli(s.frame_level),
                          s.settling_s ? formatted("%.1f", *s.settling_s) : "never"});
  }
  if (shocks.size() > most) {
    table.rows.push_back({"and " + std::to_string(shocks.size() - most) + " more"});
    table.rows.back().resize(table.columns.size());
  }
  return table;
}

page::Table noise_table(const std::vector<report::NoiseSummary>& noise) {
  page::Table table{
      "Noise at most: motion of the frame that the model does not make of the measured floor, rms "
      "of 1 to 80 Hz (with what the model is not right in, distortion and limited forces)",
      {"axis", "loop", "rms mm/s\u00b2", "share of the frame's rms"},
      {}};
  for (const report::NoiseSummary& n : noise) {
    table.rows.push_back(
        {n.axis, n.loop,
         n.rms_acceleration ? milli(*n.rms_acceleration) : "not known: " + n.missing,
         n.share ? number_text(100 * *n.share, 3) + " %" : "\u2013"});
  }
  return table;
}

page::Table effort_table(const std::vector<report::EffortSummary>& effort) {
  page::Table table{
      "", {"leg", "loop", "rms N", "peak N", "largest command N", "share of its limit"}, {}};
  for (const report::EffortSummary& e : effort) {
    table.rows.push_back(
        {e.leg, e.loop, number_text(e.applied_rms, 4), number_text(e.applied_peak, 4),
         number_text(e.command_peak, 4),
         e.limit ? number_text(100 * e.command_peak / *e.limit, 3) + " %" : "no limit"});
  }
  return table;
}

page::Table timing_table(const std::vector<report::TimingSummary>& timing) {
  page::Table table{"",
                    {"loop", "process", "periods", "late", "lost", "repeated",
                     "worst wake-up \u00b5s", "worst compute \u00b5s"},
                    {}};
  for (const report::TimingSummary& t : timing) {
    table.rows.push_back({t.loop, t.source, count(t.n_periods), count(t.n_late), count(t.n_lost),
                          count(t.n_duplicates), number_text(t.worst_wake_up_us, 4),
                          number_text(t.worst_compute_us, 4)});
  }
  return table;
}

page::Table quantile_table(const std::vector<report::TimingSummary>& timing) {
  page::Table table{
      "Periods of the controller in the log, \u00b5s (upper edges of bins, ten to a "
      "decade)",
      {"loop", "quantity", "median", "99 %", "99.9 %"},
      {}};
  for (const report::TimingSummary& t : timing) {
    const auto add = [&](const char* what, const auto& quantiles) {
      if (!quantiles) return;
      table.rows.push_back({t.loop, what, number_text(quantiles->p50_us, 3),
                            number_text(quantiles->p99_us, 3), number_text(quantiles->p999_us, 3)});
    };
    add("wake-up", t.wake_up);
    add("compute", t.compute);
  }
  return table;
}

}  // namespace

std::string date_of(std::int64_t us) {
  if (us <= 0) return "";
  const std::time_t seconds = us / 1'000'000;
  std::tm day{};
  gmtime_r(&seconds, &day);
  char text[64];
  const std::size_t n = std::strftime(text, sizeof text, " %B %Y, %H:%M UTC", &day);
  return std::to_string(day.tm_mday) + std::string(text, n);
}

page::Head head_of(const RunAnalyses& runs, const report::Verdict& verdict) {
  const report::LogScan& scan = runs.any().data.scan;
  page::Head head;
  head.title = scan.info.scene_name;
  head.program_version = scan.info.program_version;
  head.scene_name = scan.info.scene_name;
  head.scene_hash = scan.info.scene_hash;
  head.mode = mode_in_words(scan.info.mode);
  head.date = date_of(scan.first_us);
  for (const auto* run : {&runs.passive, &runs.active}) {
    if (*run) head.loops.push_back((*run)->data.scan.info.loop);
  }
  head.sample_rate_hz = scan.info.sample_rate_hz;
  head.duration_s = static_cast<double>(scan.measurements.n_spanned()) / scan.info.sample_rate_hz;
  head.delay_samples = scan.info.delay_samples;
  add_judgement(verdict, head);
  return head;
}

void add_judgement(const report::Verdict& verdict, page::Head& head) {
  head.outcome = verdict.judgement.outcome;
  head.reasons = reasons_of(verdict.judgement);
  const std::string line = headline(verdict);
  if (!line.empty()) head.headlines.push_back(line);
}

std::vector<page::Warning> warnings_of(const RunAnalyses& runs, const report::Verdict& verdict) {
  std::vector<page::Warning> warnings;
  report::SaidOnce unidentified;
  for (const std::string& text : verdict.warnings) warnings.push_back({Severity::warning, text});
  for (const auto* run : {&runs.passive, &runs.active}) {
    if (*run) warn_of_log(**run, warnings, unidentified);
  }
  for (const std::string& line : unidentified.lines()) {
    warnings.push_back({Severity::note, "Not identified: " + line + "."});
  }
  for (const report::TimingSummary& t : verdict.timing) {
    if (t.n_late == 0 && t.n_lost == 0) continue;
    warnings.push_back({Severity::warning, "The " + t.source + " of the " + t.loop +
                                               " run was late in " + count(t.n_late) +
                                               " and lost " + count(t.n_lost) + " of " +
                                               count(t.n_periods) + " periods."});
  }
  return warnings;
}

std::vector<page::AxisResult> results_of(const report::Verdict& verdict) {
  std::vector<page::AxisResult> results;
  for (const report::AxisLevels& axis : verdict.axes) {
    results.push_back(
        {axis.axis, level_of(axis.floor), level_of(axis.passive), level_of(axis.active)});
  }
  return results;
}

void add_tables(const report::Verdict& verdict, page::PageData& page) {
  if (!verdict.judgement.checks.empty()) page.checks = {check_table(verdict.judgement.checks)};
  if (!verdict.shocks.empty()) page.shock = {shock_table(verdict.shocks)};
  if (!verdict.noise.empty()) page.noise = {noise_table(verdict.noise)};
  if (!verdict.effort.empty()) page.effort = {effort_table(verdict.effort)};
  if (!verdict.timing.empty()) {
    page.timing = {timing_table(verdict.timing)};
    page::Table quantiles = quantile_table(verdict.timing);
    if (!quantiles.rows.empty()) page.timing.push_back(std::move(quantiles));
  }
  if (!verdict.responses.empty()) page.log = {response_table(verdict.responses)};
}

void add_log_tables(const RunAnalyses& runs, page::PageData& page) {
  page::Table table{"How whole the logs are",
                    {"log", "samples", "judged, s", "lost", "gaps", "repeated", "out of order",
                     "commands", "damaged places", "unread bytes", "other channels"},
                    {}};
  for (const auto* run : {&runs.passive, &runs.active}) {
    if (!*run) continue;
    const report::LogScan& scan = (*run)->data.scan;
    const double rate_hz = scan.info.sample_rate_hz;
    std::string foreign;
    for (const auto& [name, n] : scan.foreign) {
      foreign +=
          (foreign.empty() ? "" : ", ") + (name.empty() ? "others" : name) + " (" + count(n) + ")";
    }
    table.rows.push_back(
        {(*run)->log.filename().string(), count(scan.measurements.n_received),
         (*run)->data.n_judged > 0
             ? formatted("%.4g", static_cast<double>((*run)->data.judged_from) / rate_hz) +
                   formatted(" to %.4g", static_cast<double>((*run)->data.judged_until) / rate_hz)
             : "none",
         count(scan.measurements.n_lost),
         count(static_cast<std::int64_t>(scan.measurements.gaps.size())),
         count(scan.measurements.n_duplicates), count(scan.measurements.n_out_of_order),
         count(scan.commands.n_received), count(scan.n_damaged), count(scan.unread_bytes),
         foreign.empty() ? "none" : foreign});
  }
  page.log.push_back(std::move(table));
}

std::vector<page::MatrixTable> gain_tables(const controller::Gains& gains) {
  if (gains.law) {
    const NamedLaw& law = gains.law->matrices;
    std::vector<std::string> states;
    for (Eigen::Index i = 0; i < law.A.rows(); ++i) states.push_back("x" + std::to_string(i + 1));
    std::vector<page::MatrixTable> tables{
        {.name = "A", .unit = "", .rows = states, .columns = states, .values = law.A},
        {.name = "B", .unit = "", .rows = states, .columns = law.inputs, .values = law.B},
        {.name = "C", .unit = "", .rows = law.outputs, .columns = states, .values = law.C},
        {.name = "D", .unit = "", .rows = law.outputs, .columns = law.inputs, .values = law.D}};
    std::erase_if(tables, [](const page::MatrixTable& table) { return table.values.size() == 0; });
    return tables;
  }
  return {
      {.name = "K_P", .unit = "", .rows = gains.legs, .columns = gains.legs, .values = gains.K_P},
      {.name = "K_I",
       .unit = "1/s",
       .rows = gains.legs,
       .columns = gains.legs,
       .values = gains.K_I}};
}

}  // namespace stillframe::judge

#include <cmath>

#include "report/table.hpp"
#include "report/verdict/verdict.hpp"

namespace stillframe::report {

namespace {

std::string count(std::int64_t n) { return std::to_string(n); }

std::string runs_text(const std::vector<RunSummary>& runs) {
  Table table({"loop", "mode", "rate Hz", "delay", "samples", "lost", "repeated", "commands",
               "saturated", "real time x"},
              2);
  std::string notes;
  for (const RunSummary& run : runs) {
    table.add({run.loop, run.mode, cell("%g", run.sample_rate_hz), cell("%g", run.delay_samples),
               count(run.n_samples), count(run.n_lost), count(run.n_duplicates),
               count(run.n_commands), count(run.n_saturated),
               run.real_time_factor > 0 ? cell("%.2f", run.real_time_factor) : "unknown"});
    if (run.n_damaged > 0 || run.unread_bytes > 0) {
      notes += "  the log of the " + run.loop + " run is damaged: " + count(run.n_damaged) +
               " unreadable messages, " + count(run.unread_bytes) + " bytes at its end\n";
    }
  }
  const RunSummary& first = runs.front();
  return "Scene " + first.scene_name + " (" + first.scene_hash + "), stillframe " +
         first.program_version + "\n" + table.print() + notes;
}

std::string identification_text(const IdentificationSummary& id) {
  Table table({"measured against the sampled-data prediction", "largest dB", "at Hz", "allowed dB"},
              1);
  const std::string allowed = cell("%.3f", id.allowed_db);
  table.add({"singular values, open loop", cell("%.4f", id.open_largest_db),
             cell("%g", id.open_at_hz), allowed});
  table.add({"singular values, closed loop", cell("%.4f", id.closed_largest_db),
             cell("%g", id.closed_at_hz), allowed});
  table.add({cell("reduction by the loop, above %.4g Hz", id.reduction_above_hz),
             cell("%.4f", id.reduction_largest_error_db), "", allowed});
  return cell("Identification: %d frequencies, %g to %g Hz, values above %g dB: %s\n",
              id.n_frequencies, id.lowest_hz, id.highest_hz, id.floor_db,
              id.pass() ? "pass" : "FAIL") +
         table.print() +
         cell("  closed loop below open loop at %d of %d frequencies above %.4g Hz\n",
              id.n_closed_below_open, id.n_reduction_frequencies, id.reduction_above_hz);
}

/// Four significant digits without an exponent where that is readable.
std::string level(double value) {
  return value != 0 && (std::abs(value) < 1e-3 || std::abs(value) >= 1e5) ? cell("%.3e", value)
                                                                          : cell("%.4g", value);
}

std::string ratio(const std::optional<MotionLevel>& signal,
                  const std::optional<MotionLevel>& reference, double MotionLevel::*value) {
  if (!signal || !reference || !((*reference).*value > 0)) return "-";
  return cell("%.4f", (*signal).*value / ((*reference).*value));
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
                 cell("%g", signal->largest_band_hz), signal->vibration_class});
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
               count(t.n_duplicates), cell("%.1f", t.worst_wake_up_us),
               cell("%.1f", t.worst_compute_us)});
  }
  return "Timing\n" + table.print();
}

}  // namespace

std::string to_text(const Verdict& verdict) {
  std::string page;
  if (!verdict.runs.empty()) page += runs_text(verdict.runs) + "\n";
  if (verdict.identification) page += identification_text(*verdict.identification) + "\n";
  if (!verdict.axes.empty()) page += axes_text(verdict.axes) + "\n";
  if (!verdict.timing.empty()) page += timing_text(verdict.timing) + "\n";
  return page + "Verdict: " + (verdict.pass() ? "pass" : "FAIL") + "\n";
}

}  // namespace stillframe::report

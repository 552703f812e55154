#include "report/verdict/verdict.hpp"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/yaml/input_error.hpp"
#include "report/identification/comparison.hpp"
#include "report/log/run_log.hpp"
#include "report/spectra/spectra.hpp"
#include "report/spectra/vibration_criteria.hpp"

namespace stillframe::report {

using nlohmann::ordered_json;

bool IdentificationSummary::pass() const {
  return n_frequencies > 0 && open_largest_db <= allowed_db && closed_largest_db <= allowed_db &&
         reduction_largest_error_db <= allowed_db && n_closed_below_open == n_reduction_frequencies;
}

bool Verdict::pass() const {
  const bool whole = std::all_of(runs.begin(), runs.end(), [](const RunSummary& run) {
    return run.n_lost == 0 && run.n_damaged == 0 && run.unread_bytes == 0;
  });
  return whole && !runs.empty() && (!identification || identification->pass());
}

RunSummary summarise(const RunLog& log) {
  const auto& info = log.info;
  RunSummary run{.scene_name = info.scene_name,
                 .scene_hash = info.scene_hash,
                 .program_version = info.program_version,
                 .mode = info.mode,
                 .loop = info.loop,
                 .sample_rate_hz = info.sample_rate_hz,
                 .delay_samples = info.delay_samples,
                 .n_samples = log.measurements.n_received,
                 .n_lost = log.measurements.n_lost,
                 .n_duplicates = log.measurements.n_duplicates,
                 .n_commands = log.commands.n_received,
                 .n_saturated = log.n_saturated,
                 .n_damaged = log.n_damaged,
                 .unread_bytes = log.unread_bytes};
  const double plant_time =
      static_cast<double>(log.seq.back() - log.seq.front()) / info.sample_rate_hz;
  const double wall_time = log.plant_timing
                               ? 1e-9 * static_cast<double>(log.plant_timing->wall_time_ns)
                               : log.log_duration_s;
  if (wall_time > 0) run.real_time_factor = plant_time / wall_time;
  return run;
}

std::vector<TimingSummary> timing_of(const RunLog& log) {
  std::vector<TimingSummary> lines;
  for (const auto* timing : {&log.plant_timing, &log.controller_timing}) {
    if (!*timing) continue;
    const auto& t = **timing;
    lines.push_back({.loop = log.info.loop,
                     .source = t.source,
                     .n_periods = t.n_periods,
                     .n_late = t.n_late,
                     .n_lost = t.n_lost,
                     .n_duplicates = t.n_duplicate,
                     .n_listened = t.n_listened,
                     .worst_wake_up_us = 1e-3 * static_cast<double>(t.worst_wake_up_ns),
                     .worst_compute_us = 1e-3 * static_cast<double>(t.worst_compute_ns)});
  }
  return lines;
}

IdentificationSummary summarise(const PredictionError& open, const PredictionError& closed,
                                const ReductionCheck& reduction,
                                const std::vector<double>& frequencies_hz,
                                double reduction_above_hz, double floor_db, double allowed_db) {
  const auto [lowest, highest] = std::minmax_element(frequencies_hz.begin(), frequencies_hz.end());
  const bool any = !frequencies_hz.empty();
  return {.n_frequencies = static_cast<int>(frequencies_hz.size()),
          .lowest_hz = any ? *lowest : 0,
          .highest_hz = any ? *highest : 0,
          .floor_db = floor_db,
          .allowed_db = allowed_db,
          .open_largest_db = open.largest_db,
          .open_at_hz = open.at_frequency_hz,
          .closed_largest_db = closed.largest_db,
          .closed_at_hz = closed.at_frequency_hz,
          .reduction_above_hz = reduction_above_hz,
          .n_reduction_frequencies = static_cast<int>(reduction.n_frequencies),
          .n_closed_below_open = static_cast<int>(reduction.n_below),
          .reduction_largest_error_db = reduction.largest_error_db};
}

MotionLevel motion_level(const Eigen::VectorXd& acceleration, double sample_rate_hz) {
  const Psd psd = welch(acceleration, sample_rate_hz,
                        default_segment_length(acceleration.size(), sample_rate_hz));
  const Eigen::VectorXd velocity = third_octave_velocity(psd);
  Eigen::Index band = 0;
  const double largest = velocity.maxCoeff(&band);
  return {.rms_acceleration = band_rms(psd, 1, 80),
          .largest_band_velocity = largest,
          .largest_band_hz = third_octave_bands()[static_cast<std::size_t>(band)].nominal_hz,
          .vibration_class = vibration_class(velocity)};
}

namespace {

ordered_json json_of(const RunSummary& run) {
  return {{"scene_name", run.scene_name},
          {"scene_hash", run.scene_hash},
          {"program_version", run.program_version},
          {"mode", run.mode},
          {"loop", run.loop},
          {"sample_rate_hz", run.sample_rate_hz},
          {"delay_samples", run.delay_samples},
          {"n_samples", run.n_samples},
          {"n_lost", run.n_lost},
          {"n_duplicates", run.n_duplicates},
          {"n_commands", run.n_commands},
          {"n_saturated", run.n_saturated},
          {"n_damaged", run.n_damaged},
          {"unread_bytes", run.unread_bytes},
          {"real_time_factor",
           run.real_time_factor > 0 ? ordered_json(run.real_time_factor) : ordered_json(nullptr)}};
}

ordered_json json_of(const TimingSummary& timing) {
  return {{"loop", timing.loop},
          {"source", timing.source},
          {"n_periods", timing.n_periods},
          {"n_late", timing.n_late},
          {"n_lost", timing.n_lost},
          {"n_duplicates", timing.n_duplicates},
          {"n_listened", timing.n_listened},
          {"worst_wake_up_us", timing.worst_wake_up_us},
          {"worst_compute_us", timing.worst_compute_us}};
}

ordered_json json_of(const IdentificationSummary& id) {
  return {{"pass", id.pass()},
          {"n_frequencies", id.n_frequencies},
          {"lowest_hz", id.lowest_hz},
          {"highest_hz", id.highest_hz},
          {"floor_db", id.floor_db},
          {"allowed_db", id.allowed_db},
          {"open_largest_db", id.open_largest_db},
          {"open_at_hz", id.open_at_hz},
          {"closed_largest_db", id.closed_largest_db},
          {"closed_at_hz", id.closed_at_hz},
          {"reduction_above_hz", id.reduction_above_hz},
          {"n_reduction_frequencies", id.n_reduction_frequencies},
          {"n_closed_below_open", id.n_closed_below_open},
          {"reduction_largest_error_db", id.reduction_largest_error_db}};
}

ordered_json json_of(const MotionLevel& level) {
  return {{"rms_acceleration", level.rms_acceleration},
          {"largest_band_velocity", level.largest_band_velocity},
          {"largest_band_hz", level.largest_band_hz},
          {"vibration_class", level.vibration_class}};
}

ordered_json ratio_of(const MotionLevel& level, const MotionLevel& reference) {
  return {{"rms_acceleration", level.rms_acceleration / reference.rms_acceleration},
          {"largest_band_velocity", level.largest_band_velocity / reference.largest_band_velocity}};
}

ordered_json json_of(const AxisLevels& levels) {
  ordered_json json = {{"axis", levels.axis}};
  if (levels.floor) json["floor"] = json_of(*levels.floor);
  if (levels.passive) json["passive"] = json_of(*levels.passive);
  if (levels.active) json["active"] = json_of(*levels.active);
  if (levels.active && levels.passive) {
    json["ratio_active_to_passive"] = ratio_of(*levels.active, *levels.passive);
  }
  if (levels.active && levels.floor)
    json["ratio_active_to_floor"] = ratio_of(*levels.active, *levels.floor);
  return json;
}

template <typename Item>
ordered_json json_list(const std::vector<Item>& items) {
  ordered_json list = ordered_json::array();
  for (const Item& item : items) list.push_back(json_of(item));
  return list;
}

}  // namespace

std::string to_json(const Verdict& verdict) {
  ordered_json json = {{"format", 1}, {"pass", verdict.pass()}};
  json["runs"] = json_list(verdict.runs);
  json["timing"] = json_list(verdict.timing);
  if (verdict.identification) json["identification"] = json_of(*verdict.identification);
  json["axes"] = json_list(verdict.axes);
  // Names come from logs, so bytes that are no UTF-8 are replaced rather than thrown over.
  return json.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

void write_json(const Verdict& verdict, const std::filesystem::path& path) {
  std::ofstream file(path, std::ios::binary);
  file << to_json(verdict);
  file.close();
  if (!file) throw InputError(path.string() + ": the verdict cannot be written there");
}

}  // namespace stillframe::report

#include "report/verdict/verdict.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/files/whole_file.hpp"
#include "core/numerics/worst.hpp"
#include "report/identification/comparison.hpp"
#include "report/spectra/spectra.hpp"

namespace stillframe::report {

using nlohmann::ordered_json;

Outcome IdentificationSummary::outcome() const {
  if (n_frequencies == 0 || n_compared() == 0) return Outcome::not_judged;
  if (!(beyond_db <= allowed_db) || n_closed_below_open != n_reduction_frequencies) {
    return forces_unknown ? Outcome::not_judged : Outcome::failed;
  }
  const bool unknown = n_reduction_frequencies == 0 && n_reduction_unknown > 0;
  return n_open_compared > 0 && n_closed_compared > 0 && !unknown ? Outcome::passed
                                                                  : Outcome::not_judged;
}

IdentificationSummary summarise(const PredictionError& open, const PredictionError& closed,
                                const ReductionCheck& reduction,
                                const std::vector<double>& frequencies_hz,
                                double reduction_above_hz) {
  const auto [lowest, highest] = std::minmax_element(frequencies_hz.begin(), frequencies_hz.end());
  const bool any = !frequencies_hz.empty();
  return {.n_frequencies = static_cast<int>(frequencies_hz.size()),
          .lowest_hz = any ? *lowest : 0,
          .highest_hz = any ? *highest : 0,
          .n_open_compared = static_cast<int>(open.n_compared),
          .n_closed_compared = static_cast<int>(closed.n_compared),
          .allowed_db = open.tolerance_db,
          .open_largest_db = open.largest_db,
          .open_at_hz = open.at_frequency_hz,
          .closed_largest_db = closed.largest_db,
          .closed_at_hz = closed.at_frequency_hz,
          .beyond_db = worst_of(open.beyond_db, closed.beyond_db),
          .reduction_above_hz = reduction_above_hz,
          .n_reduction_frequencies = static_cast<int>(reduction.n_frequencies),
          .n_closed_below_open = static_cast<int>(reduction.n_below),
          .n_reduction_unknown = static_cast<int>(reduction.n_unknown),
          .reduction_largest_error_db = reduction.largest_error_db};
}

namespace {

/// A number, or null.
ordered_json json_of(const std::optional<double>& value) {
  return value ? ordered_json(*value) : ordered_json(nullptr);
}

const char* name_of(Subject subject) {
  switch (subject) {
    case Subject::record:
      return "record";
    case Subject::effort:
      return "effort";
    case Subject::motion:
      return "motion";
    case Subject::prediction:
      return "prediction";
  }
  return "";
}

ordered_json json_of(const Check& check) {
  return {{"subject", name_of(check.subject)},
          {"what", check.what},
          {"asked", check.asked},
          {"found", check.found},
          {"outcome", to_text(check.outcome)},
          {"reason", check.reason},
          {"by_scene", check.by_scene}};
}

ordered_json json_of(const AskedMotion& motion) {
  return {{"from_hz", motion.asked.from_hz},
          {"to_hz", motion.asked.to_hz},
          {"floor_rms_m_s2", json_of(motion.floor)},
          {"passive_rms_m_s2", json_of(motion.passive)},
          {"active_rms_m_s2", json_of(motion.active)},
          {"floor_jumps_m_s2", motion.floor_jumps},
          {"passive_jumps_m_s2", motion.passive_jumps},
          {"active_jumps_m_s2", motion.active_jumps},
          {"floor_leak_m_s2", motion.floor_leak},
          {"passive_leak_m_s2", motion.passive_leak},
          {"active_leak_m_s2", motion.active_leak},
          {"narrowest_hz", motion.narrowest_hz},
          {"active_by_forces_m_s2", json_of(motion.active_by_forces)},
          {"active_undisturbed_m_s2", json_of(motion.active_undisturbed)}};
}

std::vector<std::string> texts_of(const std::vector<RestingChannel>& channels) {
  std::vector<std::string> texts;
  for (const RestingChannel& channel : channels) texts.push_back(channel.text());
  return texts;
}

ordered_json json_of(const RunSummary& run) {
  return {{"scene", run.scene_name},
          {"scene_hash", run.scene_hash},
          {"program_version", run.program_version},
          {"mode", run.mode},
          {"loop", run.loop},
          {"sample_rate_hz", run.sample_rate_hz},
          {"delay_samples", run.delay_samples},
          {"n_samples", run.n_samples},
          {"judged_from_s", run.n_judged > 0 ? ordered_json(run.judged_from_s) : nullptr},
          {"judged_to_s", run.n_judged > 0 ? ordered_json(run.judged_to_s) : nullptr},
          {"n_judged", run.n_judged},
          {"never_held", run.never_held},
          {"let_go", run.let_go},
          {"n_lost", run.n_lost},
          {"n_duplicate", run.n_duplicates},
          {"n_commands", run.n_commands},
          {"n_commands_given",
           run.n_commands_given ? ordered_json(*run.n_commands_given) : ordered_json(nullptr)},
          {"n_not_finite", run.n_not_finite},
          {"n_repeats", run.n_repeats},
          {"n_saturated", run.n_saturated},
          {"n_damaged", run.n_damaged},
          {"unread_bytes", run.unread_bytes},
          {"n_other_version", run.n_other_version},
          {"n_foreign", run.n_foreign},
          {"n_clock_steps", run.n_clock_steps},
          {"real_time_factor",
           run.real_time_factor > 0 ? ordered_json(run.real_time_factor) : ordered_json(nullptr)},
          {"n_periods", run.n_periods},
          {"n_discarded", run.n_discarded},
          {"unreadable", run.unreadable},
          {"resting_channels", texts_of(run.resting_channels)},
          {"resting_forces", texts_of(run.resting_forces)}};
}

ordered_json json_of(const TimingSummary::Quantiles& quantiles) {
  return {
      {"p50_us", quantiles.p50_us}, {"p99_us", quantiles.p99_us}, {"p999_us", quantiles.p999_us}};
}

ordered_json json_of(const TimingSummary& timing) {
  ordered_json json = {{"loop", timing.loop},
                       {"source", timing.source},
                       {"n_periods", timing.n_periods},
                       {"n_late", timing.n_late},
                       {"n_lost", timing.n_lost},
                       {"n_duplicate", timing.n_duplicates},
                       {"n_listened", timing.n_listened},
                       {"worst_wake_up_us", timing.worst_wake_up_us},
                       {"worst_compute_us", timing.worst_compute_us}};
  if (timing.wake_up) json["wake_up"] = json_of(*timing.wake_up);
  if (timing.compute) json["compute"] = json_of(*timing.compute);
  return json;
}

ordered_json json_of(const IdentificationSummary& id) {
  const Outcome outcome = id.outcome();
  return {{"pass", outcome == Outcome::not_judged ? ordered_json(nullptr)
                                                  : ordered_json(outcome == Outcome::passed)},
          {"n_frequencies", id.n_frequencies},
          {"lowest_hz", id.lowest_hz},
          {"highest_hz", id.highest_hz},
          {"n_compared", id.n_compared()},
          {"n_open_compared", id.n_open_compared},
          {"n_closed_compared", id.n_closed_compared},
          {"allowed_db", id.allowed_db},
          {"open_largest_db", id.open_largest_db},
          {"open_at_hz", id.open_at_hz},
          {"closed_largest_db", id.closed_largest_db},
          {"closed_at_hz", id.closed_at_hz},
          {"beyond_db", id.beyond_db},
          {"reduction_above_hz", id.reduction_above_hz},
          {"n_reduction_frequencies", id.n_reduction_frequencies},
          {"n_closed_below_open", id.n_closed_below_open},
          {"n_reduction_unknown", id.n_reduction_unknown},
          {"reduction_largest_error_db", id.reduction_largest_error_db}};
}

ordered_json json_of(const MotionLevel& level, const std::optional<MotionSpectra>& spectra) {
  ordered_json json = {
      {"rms_m_s2", level.rms_acceleration},       {"peak_m_s2", level.peak_acceleration},
      {"whole_rms_m_s2", level.whole_rms},        {"largest_band_m_s", level.largest_band_velocity},
      {"largest_band_hz", level.largest_band_hz}, {"vibration_class", level.vibration_class}};
  if (spectra) {
    json["third_octaves_m_s"] = spectra->velocity;
    json["cumulative_rms_m_s2"] = spectra->cumulative_rms;
  }
  return json;
}

ordered_json json_of(const ResponseSummary& response) {
  return {{"loop", response.loop},
          {"what", response.what},
          {"method", response.method},
          {"missing", response.missing},
          {"n_frequencies", response.n_frequencies},
          {"n_compared", response.n_compared},
          {"sampled_largest_db", response.sampled_largest_db},
          {"sampled_at_hz", response.sampled_at_hz},
          {"beyond_db", response.beyond_db},
          {"broadly_beyond_db", response.broadly_beyond_db},
          {"tolerance_db", response.tolerance_db},
          {"continuous_largest_db", response.continuous_largest_db},
          {"continuous_at_hz", response.continuous_at_hz},
          {"n_segments", response.n_segments},
          {"n_filled", response.n_filled},
          {"n_left_out", response.n_left_out},
          {"resolution_hz", response.resolution_hz}};
}

ordered_json json_of(const Transmissibility& t) {
  return {{"axis", t.axis},          {"loop", t.loop},   {"frequencies_hz", t.frequencies_hz},
          {"value", t.value},        {"lower", t.lower}, {"upper", t.upper},
          {"coherence", t.coherence}};
}

ordered_json json_of(const ShockSummary& shock) {
  return {{"axis", shock.axis},
          {"loop", shock.loop},
          {"time_s", shock.time_s},
          {"floor_level_m_s2", shock.floor_level},
          {"frame_level_m_s2", shock.frame_level},
          {"settling_s", json_of(shock.settling_s)}};
}

ordered_json json_of(const NoiseSummary& noise) {
  return {{"axis", noise.axis},
          {"loop", noise.loop},
          {"rms_m_s2", json_of(noise.rms_acceleration)},
          {"share", json_of(noise.share)},
          {"missing", noise.missing}};
}

ordered_json json_of(const EffortSummary& effort) {
  return {{"loop", effort.loop},
          {"leg", effort.leg},
          {"applied_rms_n", effort.applied_rms},
          {"applied_peak_n", effort.applied_peak},
          {"command_peak_n", effort.command_peak},
          {"force_limit_n", json_of(effort.limit)}};
}

ordered_json ratio_of(const MotionLevel& level, const MotionLevel& reference) {
  return {{"rms", level.rms_acceleration / reference.rms_acceleration},
          {"largest_band", level.largest_band_velocity / reference.largest_band_velocity}};
}

ordered_json json_of(const AxisLevels& levels) {
  ordered_json json = {{"axis", levels.axis}};
  if (levels.floor) json["floor"] = json_of(*levels.floor, levels.floor_spectra);
  if (levels.passive) json["passive"] = json_of(*levels.passive, levels.passive_spectra);
  if (levels.active) json["active"] = json_of(*levels.active, levels.active_spectra);
  if (levels.active && levels.passive) {
    json["ratio_active_to_passive"] = ratio_of(*levels.active, *levels.passive);
  }
  if (levels.active && levels.floor)
    json["ratio_active_to_floor"] = ratio_of(*levels.active, *levels.floor);
  json["ranges"] = ordered_json::array();
  for (const AskedMotion& motion : levels.asked) json["ranges"].push_back(json_of(motion));
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
  ordered_json json = {{"format", 3},
                       {"outcome", to_text(verdict.judgement.outcome)},
                       {"reason", verdict.judgement.reason},
                       {"checks", json_list(verdict.judgement.checks)},
                       {"warnings", verdict.warnings},
                       {"isolates_above_hz", json_of(verdict.isolates_above_hz)},
                       {"disturbed", verdict.disturbed}};
  json["runs"] = json_list(verdict.runs);
  json["timing"] = json_list(verdict.timing);
  if (verdict.identification) json["identification"] = json_of(*verdict.identification);
  json["axes"] = json_list(verdict.axes);
  json["bands_hz"] = ordered_json::array();
  for (const OctaveBand& band : third_octave_bands()) {
    json["bands_hz"].push_back(band.nominal_hz);
  }
  json["responses"] = json_list(verdict.responses);
  json["transmissibility"] = json_list(verdict.transmissibility);
  json["shocks"] = json_list(verdict.shocks);
  json["noise"] = json_list(verdict.noise);
  json["effort"] = json_list(verdict.effort);
  // Names come from logs, so bytes that are no UTF-8 are replaced rather than thrown over.
  return json.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

void write_json(const Verdict& verdict, const std::filesystem::path& path) {
  write_whole_file(path, to_json(verdict));
}

}  // namespace stillframe::report

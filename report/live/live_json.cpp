#include "report/live/live_json.hpp"

#include <nlohmann/json.hpp>

#include "report/spectra/spectra.hpp"
#include "report/spectra/vibration_criteria.hpp"

namespace stillframe::live {

namespace {

using Json = nlohmann::ordered_json;

/// Nothing is null.
template <class T>
Json or_null(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

std::string source_word(RunNames::Source source) {
  switch (source) {
    case RunNames::Source::run_info:
      return "run_info";
    case RunNames::Source::scene:
      return "scene";
    case RunNames::Source::none:
      break;
  }
  return "numbers";
}

Json json_of(const RunView& run) {
  return {{"run_id", std::to_string(run.run_id)},  // numbers of JavaScript and jq hold 53 bits
          {"names", source_word(run.names)},
          {"scene", run.scene},
          {"mode", run.mode},
          {"loop", run.loop},
          {"sample_rate_hz", run.sample_rate_hz > 0 ? Json(run.sample_rate_hz) : Json(nullptr)},
          {"state", run.state},
          {"seq", run.seq},
          {"time_s", run.time_s},
          {"duration_s", or_null(run.duration_s)},
          {"quiet_s", run.quiet_s}};
}

Json json_of(const ControllerView& controller) {
  return {{"state", controller.state},
          {"text", controller.text},
          {"fault", controller.fault},
          {"latched", controller.latched},
          {"n_controllers", controller.n_controllers},
          {"quiet_s", controller.quiet_s},
          {"n_periods", controller.n_periods},
          {"n_late", controller.n_late},
          {"n_lost", controller.n_lost},
          {"n_missing", controller.n_missing},
          {"n_saturated", controller.n_saturated},
          {"n_faults", controller.n_faults},
          {"n_rejoins", controller.n_rejoins},
          {"n_dropped", controller.n_dropped},
          {"worst_wake_up_us", controller.worst_wake_up_us},
          {"worst_compute_us", controller.worst_compute_us},
          {"recent_wake_up_us", or_null(controller.recent_wake_up_us)},
          {"recent_compute_us", or_null(controller.recent_compute_us)}};
}

Json json_of(const SignalView& signal) {
  return {{"name", signal.name},
          {"rms_m_s2", signal.level.rms_acceleration},
          {"peak_m_s2", signal.level.peak_acceleration},
          {"largest_band_m_s", signal.level.largest_band_velocity},
          {"largest_band_hz", signal.level.largest_band_hz},
          {"vibration_class", signal.level.vibration_class},
          {"third_octaves_m_s",
           std::vector<double>(signal.band_velocity.begin(), signal.band_velocity.end())}};
}

Json json_of(const AxisView& axis) {
  return {{"axis", axis.axis},
          {"floor", axis.floor ? json_of(*axis.floor) : Json(nullptr)},
          {"frame", json_of(axis.frame)}};
}

Json json_of(const LegView& leg) {
  return {
      {"leg", leg.leg}, {"rms_n", leg.rms}, {"peak_n", leg.peak}, {"share", or_null(leg.share)}};
}

Json json_of(const ChannelView& channel) {
  return {{"channel", channel.name},
          {"per_s", channel.per_s},
          {"n_messages", channel.n},
          {"quiet_s", channel.quiet_s},
          {"n_broken", channel.n_broken},
          {"n_other_version", channel.n_other_version},
          {"n_wrong_size", channel.n_wrong_size},
          {"n_other_run", channel.n_other_run}};
}

Json json_of(const EndView& timing) {
  return {{"source", timing.source},
          {"n_periods", timing.n_periods},
          {"n_late", timing.n_late},
          {"n_lost", timing.n_lost},
          {"worst_wake_up_us", timing.worst_wake_up_us},
          {"worst_compute_us", timing.worst_compute_us}};
}

Json json_of(const HistoryView::Axis& axis) {
  return {{"axis", axis.axis}, {"floor_rms_m_s2", axis.floor}, {"frame_rms_m_s2", axis.frame}};
}

template <class Item>
Json list_of(const std::vector<Item>& items) {
  Json list = Json::array();
  for (const Item& item : items) list.push_back(json_of(item));
  return list;
}

Json json_of(const HistoryView& history) {
  Json bands = Json::array(), criteria = Json::array();
  for (const auto& band : report::third_octave_bands()) bands.push_back(band.nominal_hz);
  for (const auto& criterion : report::vibration_criteria()) {
    Json limits = Json::array();
    for (const auto& band : report::third_octave_bands()) {
      limits.push_back(criterion.applies(band.centre_hz) ? Json(criterion.limit(band.centre_hz))
                                                         : Json(nullptr));
    }
    criteria.push_back({{"name", criterion.name}, {"velocity_m_s", limits}});
  }
  return {{"time_s", history.time_s}, {"axes", list_of(history.axes)},
          {"force_n", history.force}, {"wake_up_us", history.wake_up_us},
          {"bands_hz", bands},        {"criteria", criteria}};
}

}  // namespace

std::string to_json(const LiveView& view, bool with_history) {
  Json json = {{"format", 2},
               {"watched_s", view.watched_s},
               {"notes", view.notes},
               {"run", view.run ? json_of(*view.run) : Json(nullptr)},
               {"controller", view.controller ? json_of(*view.controller) : Json(nullptr)},
               {"window_s", view.window_s},
               {"compared", view.compared},
               {"axes", list_of(view.axes)},
               {"force_limit_n", or_null(view.force_limit_n)},
               {"legs", list_of(view.legs)},
               {"n_missed", view.n_missed},
               {"channels", list_of(view.channels)},
               {"timing", list_of(view.timing)}};
  if (with_history) json["history"] = json_of(view.history);
  // Names come from the bus, so bytes that are no UTF-8 are replaced rather than thrown over.
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace stillframe::live

#include "report/live/live_view.hpp"

#include <algorithm>
#include <cmath>

#include "controller/policy.hpp"
#include "controller/supervisor.hpp"
#include "report/live/wrapping.hpp"
#include "report/spectra/fourier.hpp"
#include "report/spectra/spectra.hpp"
#include "report/verdict/motion_level.hpp"

namespace stillframe::live {

using Eigen::Index;
using Eigen::VectorXd;
using stillframe_msgs::run_state_t;

namespace {

// Below this nothing can be said of a band at 1 Hz.
constexpr double shortest_window_s = 1;
constexpr std::int64_t recent_seconds = 10;

double seconds(std::int64_t from_ns, std::int64_t to_ns) {
  return 1e-9 * static_cast<double>(to_ns - from_ns);
}

ChannelView view_of(const std::string& name, const ChannelTraffic& traffic, std::int64_t now_ns) {
  return {.name = name,
          .per_s = traffic.rate.per_s(now_ns),
          .n = traffic.rate.n(),
          .quiet_s = seconds(traffic.rate.last_ns(), now_ns),
          .n_broken = traffic.n_broken,
          .n_other_version = traffic.n_other_version,
          .n_wrong_size = traffic.n_wrong_size,
          .n_other_run = traffic.n_other_run};
}

std::string words_of(const run_state_t& state) {
  switch (state.state) {
    case run_state_t::WAITING:
      return "waiting";
    case run_state_t::READY:
      return "ready";
    case run_state_t::RUNNING:
      return "running";
    case run_state_t::ENDED:
      return "ended";
    case run_state_t::FAILED:
      return "failed" + (state.text.empty() ? "" : ": " + state.text);
  }
  return "unknown";
}

RunView view_of(const WatchedRun& run, std::int64_t now_ns) {
  RunView view;
  view.run_id = run.run_id;
  view.names = run.names.source;
  if (run.info) {
    view.scene = run.info->scene_name;
    view.mode = run.info->mode;
    view.loop = run.info->loop;
    view.sample_rate_hz = run.info->sample_rate_hz;
    if (run.info->n_samples > 0 && view.sample_rate_hz > 0) {
      view.duration_s = static_cast<double>(run.info->n_samples) / view.sample_rate_hz;
    }
  }
  if (run.plant_state) view.state = words_of(*run.plant_state);
  if (run.samples) {
    view.sample_rate_hz = run.samples->sample_rate_hz();
    view.seq = run.samples->seq();
    view.time_s = run.samples->time_s();
  }
  view.quiet_s = seconds(run.measured_ns < 0 ? run.first_heard_ns : run.measured_ns, now_ns);
  return view;
}

std::optional<ControllerView> controller_of(const WatchedRun& run, std::int64_t now_ns) {
  const ControllerVoice* newest = nullptr;
  int n_speaking = 0;
  for (const auto& [instance, voice] : run.controllers) {
    n_speaking += seconds(voice.heard_ns, now_ns) < 1 ? 1 : 0;
    if (newest == nullptr || voice.heard_ns > newest->heard_ns) newest = &voice;
  }
  if (newest == nullptr) return std::nullopt;
  const auto& status = newest->status;
  ControllerView view;
  view.state = controller::to_text(static_cast<controller::State>(status.state));
  if (view.state.empty()) view.state = "unknown";
  view.fault = controller::to_text(static_cast<controller::Fault>(status.fault));
  view.text = status.text;
  view.latched = status.latched != 0;
  view.n_controllers = std::max(n_speaking, 1);
  view.quiet_s = seconds(newest->heard_ns, now_ns);
  view.n_periods = status.n_periods;
  view.n_late = status.n_late;
  view.n_lost = status.n_lost;
  view.n_missing = status.n_missing;
  view.n_saturated = status.n_saturated;
  view.n_faults = status.n_faults;
  view.n_rejoins = status.n_rejoins;
  view.n_dropped = wrapping_sum(status.n_commands_dropped, status.n_records_dropped);
  view.worst_wake_up_us = 1e-3 * static_cast<double>(status.worst_wake_up_ns);
  view.worst_compute_us = 1e-3 * static_cast<double>(status.worst_compute_ns);
  if (const auto recent = run.wake_ups.since(recent_seconds, now_ns)) {
    view.recent_wake_up_us = 1e-3 * static_cast<double>(recent->wake_up_ns);
    view.recent_compute_us = 1e-3 * static_cast<double>(recent->compute_ns);
  }
  return view;
}

SignalView signal_of(const std::string& name, const VectorXd& acceleration, double rate_hz) {
  const report::Psd psd = report::welch(acceleration, rate_hz, acceleration.size());
  SignalView view{.name = name, .level = {}, .band_velocity = report::third_octave_velocity(psd)};
  view.level = report::motion_level(psd, view.band_velocity, acceleration.cwiseAbs().maxCoeff());
  return view;
}

/// Which columns of the accelerations are shown: the scene's comparisons, or all of them.
struct Column {
  std::string axis, floor_name, frame_name;
  Index floor = -1, frame = 0;
};

// A scene may have thousands of outputs; these are for a person to look at.
constexpr std::size_t most_columns = 64;

std::vector<Column> columns_of(const WatchedRun& run) {
  const RunNames& names = run.names;
  const auto n_floor = static_cast<Index>(names.floor.size());
  const auto index = [&](const std::string& name) -> Index {
    const auto found = std::find(names.frame.begin(), names.frame.end(), name);
    return found == names.frame.end() ? -1 : n_floor + (found - names.frame.begin());
  };
  std::vector<Column> columns;
  for (const AxisNames& axis : names.axes) {
    const Index floor = index(axis.floor), frame = index(axis.frame);
    if (floor >= 0 && frame >= 0 && columns.size() < most_columns) {
      columns.push_back({axis.axis, axis.floor, axis.frame, floor, frame});
    }
  }
  if (!columns.empty()) return columns;
  const Index n_all = n_floor + static_cast<Index>(names.frame.size());
  for (Index i = 0; i < std::min<Index>(n_all, most_columns); ++i) {
    const std::string& name = i < n_floor ? names.floor[static_cast<std::size_t>(i)]
                                          : names.frame[static_cast<std::size_t>(i - n_floor)];
    columns.push_back({name, "", name, -1, i});
  }
  return columns;
}

void add_levels(const RunSamples& samples, const std::vector<Column>& columns, LiveView& view) {
  const RollingWindow& motion = samples.motion();
  const double rate = samples.sample_rate_hz();
  if (rate <= 0 || static_cast<double>(motion.size()) < shortest_window_s * rate) return;
  const Index n = report::fast_length(motion.size());
  if (n < 2) return;
  view.window_s = static_cast<double>(n) / rate;
  for (const Column& column : columns) {
    AxisView axis{.axis = column.axis,
                  .floor = {},
                  .frame = signal_of(column.frame_name, motion.newest(column.frame, n), rate)};
    if (column.floor >= 0) {
      axis.floor = signal_of(column.floor_name, motion.newest(column.floor, n), rate);
    }
    view.axes.push_back(std::move(axis));
  }
}

void add_legs(const WatchedRun& run, LiveView& view) {
  const RollingWindow& force = run.samples->force();
  if (force.size() == 0) return;
  view.force_limit_n = run.names.force_limit_n;
  for (std::size_t i = 0; i < run.names.legs.size(); ++i) {
    const VectorXd f = force.newest(static_cast<Index>(i), force.size());
    LegView leg{.leg = run.names.legs[i],
                .rms = std::sqrt(f.squaredNorm() / static_cast<double>(f.size())),
                .peak = f.cwiseAbs().maxCoeff(),
                .share = {}};
    if (view.force_limit_n) leg.share = leg.peak / *view.force_limit_n;
    view.legs.push_back(std::move(leg));
  }
}

void add_history(const WatchedRun& run, const std::vector<Column>& columns, std::int64_t now_ns,
                 HistoryView& history) {
  const auto rms = [](const Bucket& bucket, Index column) {
    const double sum = bucket.sum_squares[static_cast<std::size_t>(column)];
    return bucket.n > 0 ? std::sqrt(sum / static_cast<double>(bucket.n)) : std::nan("");
  };
  for (const Column& column : columns) history.axes.push_back({column.axis, {}, {}});
  // The newest bucket is not over yet: a few samples of a slow motion would look like a jump.
  const auto& buckets = run.samples->history();
  for (std::size_t b = 0; b + 1 < buckets.size(); ++b) {
    const Bucket& bucket = buckets[b];
    history.time_s.push_back(static_cast<double>(bucket.number + 1) * RunSamples::bucket_s);
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (columns[i].floor >= 0) history.axes[i].floor.push_back(rms(bucket, columns[i].floor));
      history.axes[i].frame.push_back(rms(bucket, columns[i].frame));
    }
    const auto& force = bucket.largest_force;
    history.force.push_back(force.empty() ? 0 : *std::max_element(force.begin(), force.end()));
  }
  if (!run.wake_ups.any()) return;
  for (std::int64_t s = WakeUps::n_seconds - 1; s >= 0; --s) {
    const auto worst = run.wake_ups.ago(s, now_ns);
    history.wake_up_us.push_back(worst ? 1e-3 * static_cast<double>(worst->wake_up_ns)
                                       : std::nan(""));
  }
}

EndView end_of(const stillframe_msgs::timing_t& timing) {
  return {.source = timing.source,
          .n_periods = timing.n_periods,
          .n_late = timing.n_late,
          .n_lost = timing.n_lost,
          .worst_wake_up_us = 1e-3 * static_cast<double>(timing.worst_wake_up_ns),
          .worst_compute_us = 1e-3 * static_cast<double>(timing.worst_compute_ns)};
}

}  // namespace

LiveView look(const BusWatcher& watcher, const std::string& url, std::int64_t now_ns) {
  LiveView view;
  view.watched_s = seconds(watcher.began_ns(), now_ns);
  for (const auto& [name, traffic] : watcher.channels()) {
    view.channels.push_back(view_of(name, traffic, now_ns));
  }
  if (watcher.run()) {
    const WatchedRun& run = *watcher.run();
    view.run = view_of(run, now_ns);
    view.controller = controller_of(run, now_ns);
    for (const auto* timing : {&run.plant_timing, &run.controller_timing}) {
      if (*timing) view.timing.push_back(end_of(**timing));
    }
    if (run.samples) {
      view.n_missed = run.samples->n_missed();
      const std::vector<Column> columns = columns_of(run);
      view.compared = !columns.empty() && columns.front().floor >= 0;
      add_levels(*run.samples, columns, view);
      add_legs(run, view);
      add_history(run, columns, now_ns, view.history);
    }
  }
  view.notes = notes_on(watcher, view, url, now_ns);
  return view;
}

}  // namespace stillframe::live

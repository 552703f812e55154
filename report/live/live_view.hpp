#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "report/live/bus_watcher.hpp"
#include "report/verdict/verdict.hpp"

// What is to be seen of a bus at one instant, in the order in which it is shown.
namespace stillframe::live {

struct ChannelView {
  std::string name;
  double per_s = 0;    ///< messages a second, of the last two
  std::int64_t n = 0;  ///< messages since the watch began
  double quiet_s = 0;  ///< since the newest
  std::int64_t n_broken = 0, n_other_version = 0, n_wrong_size = 0, n_other_run = 0;
};

struct RunView {
  std::int64_t run_id = 0;
  RunNames::Source names = RunNames::Source::none;
  std::string scene, mode, loop;  ///< empty: not known, run_info was not heard
  double sample_rate_hz = 0;      ///< 0: not known yet
  std::string state;              ///< of the plant in words; empty: it has not been heard to say
  std::int64_t seq = -1;          ///< of the newest measurement; -1: none came
  double time_s = 0;              ///< of plant time
  std::optional<double> duration_s;
  double quiet_s = 0;  ///< since the newest measurement
};

/// What a controller says of itself, and what its records tell of the last ten seconds.
struct ControllerView {
  std::string state, fault, text;
  bool latched = false;
  int n_controllers = 1;
  double quiet_s = 0;
  std::int64_t n_periods = 0, n_late = 0, n_lost = 0, n_missing = 0, n_saturated = 0, n_faults = 0,
               n_rejoins = 0, n_dropped = 0;
  double worst_wake_up_us = 0, worst_compute_us = 0;           ///< since it began
  std::optional<double> recent_wake_up_us, recent_compute_us;  ///< the worst of the last 10 s
};

/// What a process that has ended said of its own timing.
struct EndView {
  std::string source;  ///< plant or controller
  std::int64_t n_periods = 0, n_late = 0, n_lost = 0;
  double worst_wake_up_us = 0, worst_compute_us = 0;
};

/// One acceleration over the window.
struct SignalView {
  std::string name;
  report::MotionLevel level;
  Eigen::VectorXd band_velocity;  ///< m/s rms in report::third_octave_bands()
};

/// Two signals that are compared; without names of axes a signal alone is in `frame`.
struct AxisView {
  std::string axis;
  std::optional<SignalView> floor;
  SignalView frame;
};

struct LegView {
  std::string leg;
  double rms = 0, peak = 0;     ///< N, of the commands in the window
  std::optional<double> share;  ///< of the limit, by the peak
};

/// The last minute in buckets of RunSamples::bucket_s of plant time, oldest first.
struct HistoryView {
  struct Axis {
    std::string axis;
    std::vector<double> floor, frame;  ///< m/s^2 rms at all frequencies; floor may be empty
  };
  std::vector<double> time_s;  ///< of each bucket's end
  std::vector<Axis> axes;
  std::vector<double> force;       ///< N, the largest of all legs
  std::vector<double> wake_up_us;  ///< worst of each second up to now, oldest first
};

struct LiveView {
  double watched_s = 0;
  std::optional<RunView> run;
  std::optional<ControllerView> controller;
  std::int64_t n_missed = 0;  ///< measurements that never came here
  double window_s = 0;        ///< of plant time that the levels are over; 0: no levels yet
  bool compared = false;      ///< the axes are those of the scene
  std::vector<AxisView> axes;
  std::optional<double> force_limit_n;
  std::vector<LegView> legs;
  std::vector<ChannelView> channels;
  std::vector<EndView> timing;  ///< of processes that have ended
  HistoryView history;
  std::vector<std::string> notes;  ///< what a person should know first, in words
};

/// Works out what there is to see at now_ns. url stands for the bus in the notes.
LiveView look(const BusWatcher& watcher, const std::string& url, std::int64_t now_ns);

/// The part of look() that says what a person should know.
std::vector<std::string> notes_on(const BusWatcher& watcher, const LiveView& view,
                                  const std::string& url, std::int64_t now_ns);

}  // namespace stillframe::live

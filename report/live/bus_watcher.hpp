#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "report/live/rate_meter.hpp"
#include "report/live/run_names.hpp"
#include "report/live/run_samples.hpp"
#include "report/live/wake_ups.hpp"
#include "stillframe_msgs/command_t.hpp"
#include "stillframe_msgs/controller_status_t.hpp"
#include "stillframe_msgs/loop_records_t.hpp"
#include "stillframe_msgs/measurement_t.hpp"
#include "stillframe_msgs/run_info_t.hpp"
#include "stillframe_msgs/run_state_t.hpp"
#include "stillframe_msgs/timing_t.hpp"

namespace stillframe::live {

/// What came on one channel, and what of it was of no use.
struct ChannelTraffic {
  RateMeter rate;
  std::int64_t n_broken = 0;         ///< not whole messages of the channel's type
  std::int64_t n_other_version = 0;  ///< of a type with another fingerprint
  std::int64_t n_wrong_size = 0;     ///< whole, but not of the sizes of the run
  std::int64_t n_other_run = 0;      ///< of runs that are not watched
};

/// What one controller process said last.
struct ControllerVoice {
  stillframe_msgs::controller_status_t status;
  std::int64_t heard_ns = 0;
};

/// All that is known of the run that is watched.
struct WatchedRun {
  std::int64_t run_id = 0;
  std::int64_t first_heard_ns = 0, heard_ns = 0;  ///< the first and the newest message of it
  std::optional<stillframe_msgs::run_info_t> info;
  RunNames names;
  std::optional<RunSamples> samples;  ///< from the first measurement on
  std::optional<std::int64_t> plant;  ///< the instance whose measurements these are
  std::int64_t n_measured = 0;        ///< by it, as far as they were heard
  std::int64_t n_before = 0;      ///< by plants of the same run before it, which are shown no more
  std::int64_t n_of_another = 0;  ///< measurements of another plant in a row
  std::optional<stillframe_msgs::run_info_t> other_info;  ///< the newest of another plant
  std::int64_t measured_ns = -1;  ///< when the newest measurement came, -1: none yet
  std::int64_t wrong_sizes = 0;   ///< measurements of another size in a row
  std::map<std::int64_t, ControllerVoice> controllers;  ///< by instance
  std::optional<stillframe_msgs::run_state_t> plant_state, controller_state;
  std::optional<stillframe_msgs::timing_t> plant_timing, controller_timing;
  WakeUps wake_ups;

  bool over() const;  ///< the plant has said that it ended or failed
};

/// What to watch.
struct WatchSettings {
  std::optional<std::int64_t> run_id;  ///< without it the newest run that is heard
  std::optional<RunNames> names;       ///< of a scene, for runs whose run_info was not heard
};

/// Makes out of the messages of a bus what is going on there, from whenever it is attached. One
/// run is watched; another one takes its place when it announces itself, or when it is heard while
/// the first is over or has been quiet for a second. Times are on CLOCK_MONOTONIC. Set-up, but
/// take() never throws.
class BusWatcher {
 public:
  BusWatcher(WatchSettings settings, std::int64_t now_ns);

  /// Takes one message of any channel.
  void take(std::string_view channel, std::string_view bytes, std::int64_t now_ns) noexcept;

  std::int64_t began_ns() const { return began_ns_; }
  const std::map<std::string, ChannelTraffic, std::less<>>& channels() const { return channels_; }
  const std::optional<WatchedRun>& run() const { return run_; }
  /// The newest run beside the one that is watched, and when it was heard; 0: none yet.
  std::int64_t other_run() const { return other_run_; }
  std::int64_t other_run_ns() const { return other_run_ns_; }

 private:
  template <class Message, class Handler>
  void read(ChannelTraffic& traffic, std::string_view bytes, Handler handler);
  enum class Speaker { plant, other };
  bool watches(ChannelTraffic& traffic, std::int64_t run_id, std::int64_t now_ns, Speaker speaker);
  bool is_news(std::int64_t run_id);
  void begin(std::int64_t run_id, std::int64_t now_ns);
  bool is_of_another_plant(const stillframe_msgs::measurement_t& message, std::int64_t now_ns);
  void follow(std::int64_t plant_instance, std::int64_t now_ns);
  void make_samples(int n_floor, int n_legs, int n_frame);
  ChannelTraffic& traffic_of(std::string_view channel);

  void take(ChannelTraffic& traffic, const stillframe_msgs::measurement_t&, std::int64_t now_ns);
  void take(ChannelTraffic& traffic, const stillframe_msgs::command_t&, std::int64_t now_ns);
  void take(ChannelTraffic& traffic, const stillframe_msgs::run_info_t&, std::int64_t now_ns);
  void take(ChannelTraffic& traffic, const stillframe_msgs::run_state_t&, std::int64_t now_ns);
  void take(ChannelTraffic& traffic, const stillframe_msgs::timing_t&, std::int64_t now_ns);
  void take(ChannelTraffic& traffic, const stillframe_msgs::controller_status_t&,
            std::int64_t now_ns);
  void take(ChannelTraffic& traffic, const stillframe_msgs::loop_records_t&, std::int64_t now_ns);

  WatchSettings settings_;
  std::int64_t began_ns_;
  std::map<std::string, ChannelTraffic, std::less<>> channels_;
  std::optional<WatchedRun> run_;
  std::int64_t other_run_ = 0, other_run_ns_ = -1;
  std::vector<std::int64_t> known_runs_;  ///< the newest that were heard
};

}  // namespace stillframe::live

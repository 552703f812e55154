#include "report/log/log_scan.hpp"

#include <algorithm>
#include <set>

#include "core/errors/input_error.hpp"
#include "core/files/utf8.hpp"
#include "msgs/channels.hpp"
#include "report/log/event_file.hpp"
#include "report/log/logger_clock.hpp"
#include "report/log/run_search.hpp"
#include "report/log/scan_commands.hpp"
#include "report/log/seq_clock.hpp"
#include "stillframe_msgs/control_request_t.hpp"
#include "stillframe_msgs/excitation_t.hpp"
#include "stillframe_msgs/loop_checkpoint_t.hpp"
#include "stillframe_msgs/loop_records_t.hpp"
#include "stillframe_msgs/run_state_t.hpp"

namespace stillframe::report {

using namespace stillframe_msgs;

namespace {

constexpr std::size_t most_foreign_names = 100, most_runs = 1000;

/// Messages that cannot be of this run although they say so. A few of them are damage; one in ten
/// is a contradiction, and the log must not be believed.
class Contradictions {
 public:
  void add(const std::string& text) {
    if (count_++ == 0) first_ = text;
  }
  void judge(std::int64_t n_received, const std::string& place) const {
    if (10 * count_ > n_received) throw InputError(place + ": " + first_);
  }

 private:
  std::int64_t count_ = 0;
  std::string first_;
};

/// What is wrong with the sizes of a message, or nothing.
std::string misfit(const char* field, std::size_t found, std::int32_t wanted, std::int64_t seq) {
  if (found == static_cast<std::size_t>(wanted)) return {};
  return std::string(field) + ": found " + std::to_string(found) + " values at seq " +
         std::to_string(seq) + ", run_info says " + std::to_string(wanted);
}

std::string misfit(const measurement_t& m, const run_info_t& info) {
  for (const std::string& text :
       {misfit("floor_acceleration", m.floor_acceleration.size(), info.n_floor, m.seq),
        misfit("sigma", m.sigma.size(), info.n_legs, m.seq),
        misfit("frame_acceleration", m.frame_acceleration.size(), info.n_frame, m.seq)}) {
    if (!text.empty()) return text;
  }
  return {};
}

std::string misfit(const command_t& m, const run_info_t& info) {
  return misfit("force", m.force.size(), info.n_legs, m.seq);
}

const char* channel_of(const measurement_t&) { return channels::measurement; }
const char* channel_of(const command_t&) { return channels::command; }

/// What is read of a log.
struct Choice {
  run_info_t info;
  std::vector<PlantPart> plants = {};
  std::size_t plant = 0;
};

/// Which messages of a run are of the plant that was chosen. Some types do not say whose they are:
/// they come from its time, told by the measurements and statuses between which they stand.
class PlantFilter {
 public:
  explicit PlantFilter(const Choice& choice)
      : any_(choice.plants.empty()), alone_(choice.plants.size() < 2) {
    if (any_) return;
    chosen_ = choice.plants[choice.plant].instance;
    for (const PlantPart& plant : choice.plants) known_.push_back(plant.instance);
    now_ = known_.front();
  }

  bool takes(const measurement_t& message) {
    hear(message.plant_instance);
    return any_ || message.plant_instance == chosen_;
  }
  /// Of a controller: one of a single plant may leave out whom it is for.
  template <typename Message>
  bool takes(const Message& message) {
    return any_ || message.plant_instance == chosen_ || (alone_ && message.plant_instance == 0);
  }
  bool takes(const controller_status_t& message) {
    hear(message.plant_instance);
    return takes<controller_status_t>(message);
  }
  bool is_now() const { return alone_ || now_ == chosen_; }
  bool is_alone() const { return alone_; }

 private:
  void hear(std::int64_t instance) {
    if (std::find(known_.begin(), known_.end(), instance) != known_.end()) now_ = instance;
  }

  bool any_, alone_;
  std::vector<std::int64_t> known_;
  std::int64_t chosen_ = 0, now_ = 0;
};

class Scanner {
 public:
  Scanner(Choice choice, const ScanSettings& settings, LogVisitor& visitor,
          SampleWindow::CommandSink commands)
      : visitor_(visitor),
        choose_any_(!settings.run_id),
        plant_(choice),
        window_(choice.info, settings, visitor, std::move(commands)),
        measurements_(choice.info.sample_rate_hz),
        commands_(choice.info.sample_rate_hz) {
    scan_.info = std::move(choice.info);
    scan_.plants = std::move(choice.plants);
    scan_.plant = choice.plant;
  }

  void take(const LogEvent& event) {
    if (run_has_begun_) clock_.add(event.timestamp_us);
    if (event.channel == channels::measurement) {
      with<measurement_t>(event, [&](measurement_t&& m) { take_measurement(event, std::move(m)); });
    } else if (event.channel == channels::command) {
      with<command_t>(event, [&](command_t&& m) {
        if (is_ours(m.run_id) && plant_.takes(m)) admit(std::move(m), commands_);
      });
    } else if (event.channel == channels::loop) {
      with<loop_records_t>(event, [&](loop_records_t&& m) { take_records(m); });
    } else {
      take_rare(event);
    }
  }

  LogScan finish(const LogDamage& damage, const std::string& place) {
    measurements_.finish([&](measurement_t&& m) { put(m); }, [&](measurement_t& m) { reject(m); });
    commands_.finish([&](command_t&& m) { put(m); }, [&](command_t& m) { reject(m); });
    window_.finish();
    require_one_run(place);
    scan_.measurements = window_.measurements();
    scan_.commands = window_.commands();
    scan_.n_saturated = window_.n_saturated();
    scan_.faults = window_.faults();
    scan_.first_us = clock_.first_us();
    scan_.n_clock_steps = clock_.n_steps();
    scan_.largest_clock_step_s = clock_.largest_step_s();
    scan_.n_damaged = damage.n_damaged + n_bad_names_;
    scan_.unread_bytes = damage.unread_bytes;
    contradictions_.judge(scan_.measurements.n_received + scan_.commands.n_received, place);
    if (scan_.measurements.n_received == 0) {
      throw InputError(place + ": no " + channels::measurement + " message of run " +
                       std::to_string(scan_.info.run_id) + " that can be read");
    }
    return std::move(scan_);
  }

 private:
  template <typename Message, typename Take>
  void with(const LogEvent& event, Take&& take) {
    Message message;
    if (decode(event.payload, message)) {
      take(std::move(message));
    } else {
      ++scan_.n_undecodable;
      if (fit<Message>(event.payload) == Fit::other_version) ++scan_.n_other_version;
    }
  }

  bool is_ours(std::int64_t run_id) const { return run_id == scan_.info.run_id; }

  void take_measurement(const LogEvent& event, measurement_t&& m) {
    if (!is_ours(m.run_id)) {
      if (other_measured_.size() < most_runs) other_measured_.insert(m.run_id);
      return;
    }
    if (!plant_.takes(m)) return;
    if (!run_has_begun_) clock_.add(event.timestamp_us);
    run_has_begun_ = true;
    scan_.log_duration_s = clock_.passed_s();
    admit(std::move(m), measurements_);
  }

  template <typename Message>
  void admit(Message&& message, Admission<Message>& admission) {
    const std::string wrong = misfit(message, scan_.info);
    if (!wrong.empty()) {
      contradictions_.add(wrong);
      ++scan_.n_undecodable;
      return;
    }
    admission.add(
        std::move(message), [&](Message&& m) { put(m); }, [&](Message& m) { reject(m); });
  }

  template <typename Message>
  void put(const Message& message) {
    using Place = SampleWindow::Place;
    const Place place = message.seq < 0 ? Place::conflicting : window_.put(message);
    if (place == Place::too_late) ++scan_.n_too_late;
    if (place == Place::conflicting) reject(message);
  }

  template <typename Message>
  void reject(const Message& message) {
    ++scan_.n_undecodable;
    if (!window_.contradicts(message)) return;
    contradictions_.add(std::string(channel_of(message)) + ": two different messages with seq " +
                        std::to_string(message.seq) + ", they cannot be of one run");
  }

  void take_records(const loop_records_t& message) {
    if (!is_ours(message.run_id) || !plant_.is_now()) return;
    for (const loop_record_t& record : message.records) visitor_.period(record);
  }

  void take_rare(const LogEvent& event) {
    if (event.channel == channels::run_info) {
      with<run_info_t>(event, [&](run_info_t&& m) {
        if (!is_ours(m.run_id) && other_runs_.size() < most_runs) other_runs_.insert(m.run_id);
      });
    } else if (event.channel == channels::timing) {
      with<timing_t>(event, [&](timing_t&& m) { take_timing(std::move(m)); });
    } else if (event.channel == channels::status) {
      with<controller_status_t>(event, [&](controller_status_t&& m) { take_status(std::move(m)); });
    } else if (event.channel == channels::run_state) {
      with<run_state_t>(event, [](run_state_t&&) {});
    } else if (event.channel == channels::request) {
      with<control_request_t>(event, [](control_request_t&&) {});
    } else if (event.channel == channels::checkpoint) {
      with<loop_checkpoint_t>(event, [](loop_checkpoint_t&&) {});
    } else if (event.channel == channels::excitation) {
      with<excitation_t>(event, [&](excitation_t&& m) {
        if (is_ours(m.run_id) && plant_.is_now()) window_.put(m);
      });
    } else if (event.channel != channels::logger_check) {
      take_foreign(std::string(event.channel));
    }
  }

  void take_timing(timing_t&& m) {
    if (!is_ours(m.run_id) || !plant_.is_now()) return;
    if (m.source == "plant") scan_.plant_timing = m;
    // A controller goes on from plant to plant, and counts over all of them.
    if (m.source == "controller" && plant_.is_alone()) scan_.controller_timing = m;
  }

  void take_status(controller_status_t&& m) {
    if (!is_ours(m.run_id) || !plant_.takes(m)) return;
    m.text = as_utf8(m.text);
    m.answer = as_utf8(m.answer);
    scan_.last_status = std::move(m);
  }

  void take_foreign(const std::string& name) {
    const bool is_name = std::all_of(name.begin(), name.end(),
                                     [](unsigned char c) { return c >= 0x20 && c < 0x7F; });
    if (!is_name) {
      ++n_bad_names_;
    } else if (scan_.foreign.contains(name) || scan_.foreign.size() < most_foreign_names) {
      ++scan_.foreign[name];
    } else {
      ++scan_.foreign[""];
    }
  }

  void require_one_run(const std::string& place) const {
    if (!choose_any_) return;
    std::set<std::int64_t> runs{scan_.info.run_id};
    for (const std::int64_t id : other_runs_) {
      if (other_measured_.contains(id)) runs.insert(id);
    }
    if (runs.size() == 1) return;
    std::string known;
    for (const std::int64_t id : runs) known += (known.empty() ? "" : ", ") + std::to_string(id);
    throw InputError(place + ": several runs in one log, name the run_id: " + known);
  }

  LogVisitor& visitor_;
  bool choose_any_, run_has_begun_ = false;
  PlantFilter plant_;
  LogScan scan_;
  SampleWindow window_;
  Admission<measurement_t> measurements_;
  Admission<command_t> commands_;
  LoggerClock clock_;
  Contradictions contradictions_;
  std::set<std::int64_t> other_runs_, other_measured_;  ///< run_id of run_info and of measurements
  std::int64_t n_bad_names_ = 0;
};

/// Of the whole work: looking for the run, and for its plants.
constexpr double run_share = 0.1, plants_share = 0.2;

/// A part of the work, told as a share of the whole.
std::function<void(double)> part_of(const std::function<void(double)>& tell, double begin,
                                    double end) {
  if (!tell) return {};
  return [&tell, begin, end](double share) { tell(begin + share * (end - begin)); };
}

/// Tells the share that was read, not more often than it can be seen.
class Progress {
 public:
  Progress(std::function<void(double)> tell, std::int64_t size)
      : tell_(std::move(tell)), size_(size) {}
  void now(std::int64_t position) {
    if (!tell_ || position - told_ < step) return;
    told_ = position;
    tell_(static_cast<double>(position) / static_cast<double>(size_));
  }
  void done() const {
    if (tell_) tell_(1);
  }

 private:
  static constexpr std::int64_t step = std::int64_t{4} << 20;
  std::function<void(double)> tell_;
  std::int64_t size_, told_ = 0;
};

Choice choose(const std::filesystem::path& path, const ScanSettings& settings) {
  const auto& tell = settings.progress;
  Choice choice{.info = find_run_info(path, settings.run_id, {}, part_of(tell, 0, run_share))};
  const std::int64_t run_id = choice.info.run_id;
  // A run in one process has no plant that could come back.
  if (choice.info.mode != "single_process") {
    choice.plants = plants_of_run(path, run_id, part_of(tell, run_share, plants_share));
  }
  choice.plant = choose_plant(choice.plants, settings.plant, run_id, path.string());
  if (choice.plants.empty() || !choice.plants[choice.plant].described) return choice;
  // What was found first may be what another plant said.
  choice.info = find_run_info(path, run_id, choice.plants[choice.plant].instance, {});
  return choice;
}

}  // namespace

LogScan scan_log_with_commands(const std::filesystem::path& path, const ScanSettings& settings,
                               LogVisitor& visitor, SampleWindow::CommandSink commands) {
  Choice choice = choose(path, settings);
  EventFile file(path);
  visitor.begin(choice.info);
  Scanner scanner(std::move(choice), settings, visitor, std::move(commands));
  Progress progress(part_of(settings.progress, plants_share, 1), file.size());
  LogEvent event;
  while (file.next(event)) {
    scanner.take(event);
    progress.now(file.position());
  }
  progress.done();
  return scanner.finish(file.damage(), path.string());
}

LogScan scan_log(const std::filesystem::path& path, const ScanSettings& settings,
                 LogVisitor& visitor) {
  return scan_log_with_commands(path, settings, visitor, {});
}

}  // namespace stillframe::report

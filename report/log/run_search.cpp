#include "report/log/run_search.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "core/errors/formatted.hpp"
#include "core/errors/input_error.hpp"
#include "core/files/utf8.hpp"
#include "msgs/channels.hpp"
#include "report/log/event_file.hpp"
#include "stillframe_msgs/command_t.hpp"
#include "stillframe_msgs/measurement_t.hpp"
#include "stillframe_msgs/timing_t.hpp"

namespace stillframe::report {

using stillframe_msgs::command_t;
using stillframe_msgs::measurement_t;
using stillframe_msgs::run_info_t;
using stillframe_msgs::timing_t;

namespace {

constexpr int our_format_version = 1;

/// A damaged log may name any number of runs that are none.
constexpr std::size_t most_runs_found = 1000;

bool is_sound(const run_info_t& info) {
  return info.format_version == our_format_version && std::isfinite(info.sample_rate_hz) &&
         info.sample_rate_hz > 0;
}

/// How far apart the samples of a run are by their own time, s of plant time: the median of some,
/// so that damage to one of them does no harm.
class SamplePeriod {
 public:
  void add(const measurement_t& m) {
    const double samples = static_cast<double>(m.seq) - last_seq_;
    if (any_ && samples > 0) {
      periods_.push_back(1e-9 * (static_cast<double>(m.time_ns) - last_ns_) / samples);
    }
    last_seq_ = static_cast<double>(m.seq);
    last_ns_ = static_cast<double>(m.time_ns);
    any_ = true;
  }
  bool is_enough() const { return periods_.size() >= 32; }

  /// A sender's clock drifts by far less; a single sample says nothing.
  bool agrees(double sample_rate_hz) const {
    return periods_.empty() || std::abs(median() * sample_rate_hz - 1) <= 0.01;
  }
  double median() const {
    std::vector<double> periods = periods_;
    std::nth_element(periods.begin(), periods.begin() + middle(), periods.end());
    return periods[static_cast<std::size_t>(middle())];
  }

 private:
  std::ptrdiff_t middle() const { return static_cast<std::ptrdiff_t>(periods_.size() / 2); }

  std::vector<double> periods_;
  double last_seq_ = 0, last_ns_ = 0;
  bool any_ = false;
};

void require_sound(const run_info_t& info, const SamplePeriod& period, const std::string& place) {
  if (info.format_version != our_format_version) {
    throw InputError(place + ": format_version: found " + std::to_string(info.format_version) +
                     ", this program reads " + std::to_string(our_format_version));
  }
  if (!is_sound(info)) {
    throw InputError(place + ": sample_rate_hz: found " + std::to_string(info.sample_rate_hz) +
                     ", allowed are positive numbers");
  }
  if (!period.agrees(info.sample_rate_hz)) {
    throw InputError(place +
                     formatted(": sample_rate_hz: found %g, but its samples are %g s apart: the "
                               "log is damaged",
                               info.sample_rate_hz, period.median()));
  }
}

/// The copies of one run's run_info, told apart by their bytes.
class Copies {
 public:
  void add(std::string_view payload) {
    for (Copy& copy : copies_) {
      if (copy.payload == payload) {
        ++copy.count;
        return;
      }
    }
    if (copies_.size() < 16) copies_.push_back({std::string(payload), 1});
  }

  run_info_t best(const SamplePeriod& period) const {
    run_info_t best;
    std::pair<bool, int> rank{false, 0};
    for (const Copy& copy : copies_) {
      run_info_t info;
      if (!decode(copy.payload, info)) continue;
      const std::pair<bool, int> own{is_sound(info) && period.agrees(info.sample_rate_hz),
                                     copy.count};
      if (own <= rank) continue;
      best = std::move(info);
      rank = own;
    }
    return best;
  }

 private:
  struct Copy {
    std::string payload;
    int count = 0;
  };
  std::vector<Copy> copies_;
};

class Search {
 public:
  Search(std::optional<std::int64_t> run_id, std::optional<std::int64_t> plant_instance)
      : wanted_(run_id), plant_(plant_instance) {}

  bool has_found() const { return chosen_.has_value(); }

  /// Answers whether the run is found.
  bool take(const LogEvent& event) {
    if (event.channel == channels::run_info) {
      note<run_info_t>(event);
      return take_info(event);
    }
    if (event.channel == channels::command) note<command_t>(event);
    if (event.channel == channels::timing) note<timing_t>(event);
    if (event.channel != channels::measurement) return false;
    note<measurement_t>(event);
    measurement_t message;
    if (!decode(event.payload, message) || !is_of_plant(message)) return false;
    if (runs_.contains(message.run_id)) {
      if (is_chosen(message.run_id)) period_.add(message);
      return chosen_.has_value();
    }
    if (measured_.size() < most_runs_found) measured_.insert(message.run_id);
    return false;
  }

  /// Listens on behind what take() found; answers whether enough is known of the chosen run.
  bool listen(const LogEvent& event) {
    if (event.channel == channels::run_info) take_info(event);
    measurement_t message;
    if (event.channel == channels::measurement && decode(event.payload, message) &&
        message.run_id == *chosen_ && is_of_plant(message)) {
      period_.add(message);
    }
    return period_.is_enough();
  }

  run_info_t result(const std::string& place) const {
    if (!chosen_) explain(place);
    run_info_t info = runs_.at(*chosen_).best(period_);
    require_sound(info, period_, place);
    return info;
  }

 private:
  bool take_info(const LogEvent& event) {
    run_info_t info;
    if (!decode(event.payload, info) || !is_of_plant(info)) return false;
    if (runs_.size() < most_runs_found || runs_.contains(info.run_id)) {
      runs_[info.run_id].add(event.payload);
      // A log that was begun after the run: its measurements came first.
      if (measured_.contains(info.run_id)) return is_chosen(info.run_id);
    }
    return false;
  }

  template <typename Message>
  bool is_of_plant(const Message& message) const {
    return !plant_ || message.plant_instance == *plant_;
  }

  bool is_chosen(std::int64_t run_id) {
    if (wanted_ && *wanted_ != run_id) return false;
    chosen_ = run_id;
    return true;
  }

  template <typename Message>
  void note(const LogEvent& event) {
    const Fit found = fit<Message>(event.payload);
    if (found == Fit::other_version) ++n_other_version_;
    if (found == Fit::whole) has_any_ = true;
  }

  [[noreturn]] void explain(const std::string& place) const {
    std::string known;
    for (const auto& [id, copies] : runs_) {
      known += (known.empty() ? "" : ", ") + std::to_string(id);
    }
    if (known.empty()) explain_nothing(place);
    if (wanted_ && !runs_.contains(*wanted_)) {
      throw InputError(place + ": run_id: found none with " + std::to_string(*wanted_) +
                       ", this log holds " + known);
    }
    const std::int64_t id = wanted_ ? *wanted_ : runs_.begin()->first;
    require_sound(runs_.at(id).best(period_), period_, place);
    throw InputError(place + ": run " + std::to_string(id) + " has a " + channels::run_info +
                     " but no " + channels::measurement + " message");
  }

  [[noreturn]] void explain_nothing(const std::string& place) const {
    std::string text = place + (has_any_ ? ": no " + std::string(channels::run_info) +
                                               " message, so the others cannot be read"
                                         : ": no message of a stillframe run in this log");
    if (n_other_version_ > 0) {
      text += "; " + std::to_string(n_other_version_) +
              " messages on its channels are of other versions of their types";
    }
    if (has_any_) {
      text += "; of a log that was split, put the parts together first (cat LOG.* > whole.lcm)";
    }
    throw InputError(text);
  }

  std::optional<std::int64_t> wanted_, plant_, chosen_;
  SamplePeriod period_;
  std::map<std::int64_t, Copies> runs_;
  std::set<std::int64_t> measured_;
  std::int64_t n_other_version_ = 0;
  bool has_any_ = false;
};

}  // namespace

run_info_t find_run_info(const std::filesystem::path& path, std::optional<std::int64_t> run_id,
                         std::optional<std::int64_t> plant_instance,
                         const std::function<void(double)>& progress) {
  EventFile file(path);
  Search search(run_id, plant_instance);
  LogEvent event;
  std::int64_t told = 0;
  constexpr std::int64_t tell_every = std::int64_t{16} << 20;
  while (file.next(event) && !search.take(event)) {
    if (progress && file.position() - told >= tell_every) {
      told = file.position();
      progress(static_cast<double>(told) / static_cast<double>(file.size()));
    }
  }
  // The samples behind the first tell whether the rate is theirs, before memory is taken by it.
  constexpr int most_events = 1000;
  for (int n = 0; n < most_events && search.has_found() && file.next(event); ++n) {
    if (search.listen(event)) break;
  }
  run_info_t info = search.result(path.string());
  for (std::string* text :
       {&info.program_version, &info.scene_name, &info.scene_hash, &info.scene_text,
        &info.floor_text, &info.gains_text, &info.mode, &info.loop}) {
    *text = as_utf8(*text);
  }
  for (auto* names : {&info.floor_names, &info.leg_names, &info.frame_names}) {
    for (std::string& name : *names) name = as_utf8(name);
  }
  return info;
}

}  // namespace stillframe::report

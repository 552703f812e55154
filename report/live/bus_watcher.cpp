#include "report/live/bus_watcher.hpp"

#include <algorithm>

#include "msgs/channels.hpp"
#include "msgs/message_fit.hpp"

namespace stillframe::live {

using namespace stillframe_msgs;

namespace {

constexpr std::int64_t quiet_ns = 1'000'000'000;
// So many measurements of another size in a row are the run's, and the first one was wrong.
constexpr std::int64_t most_wrong_sizes = 10;
// So many measurements of another plant in a row are not one that finds the run taken and goes.
constexpr std::int64_t most_of_another = 20;
constexpr std::size_t most_channels = 32, most_controllers = 8, most_known_runs = 16;

bool is_end(const run_state_t& state) {
  return state.state == run_state_t::ENDED || state.state == run_state_t::FAILED;
}

bool same_sizes(const RunNames& names, const measurement_t& message) {
  return static_cast<int>(names.floor.size()) == message.n_floor &&
         static_cast<int>(names.legs.size()) == message.n_legs &&
         static_cast<int>(names.frame.size()) == message.n_frame;
}

}  // namespace

bool WatchedRun::over() const { return plant_state && is_end(*plant_state); }

BusWatcher::BusWatcher(WatchSettings settings, std::int64_t now_ns)
    : settings_(std::move(settings)), began_ns_(now_ns) {}

template <class Message, class Handler>
void BusWatcher::read(ChannelTraffic& traffic, std::string_view bytes, Handler handler) {
  switch (fit<Message>(bytes)) {
    case Fit::whole:
      break;
    case Fit::other_version:
      ++traffic.n_other_version;
      return;
    case Fit::damaged:
      ++traffic.n_broken;
      return;
  }
  Message message;
  if (message.decode(bytes.data(), 0, static_cast<int>(bytes.size())) < 0) {
    ++traffic.n_broken;
    return;
  }
  handler(message);
}

void BusWatcher::take(std::string_view channel, std::string_view bytes,
                      std::int64_t now_ns) noexcept try {
  ChannelTraffic& traffic = traffic_of(channel);
  traffic.rate.count(now_ns);
  const auto give = [&](const auto& message) { take(traffic, message, now_ns); };
  if (channel == channels::measurement) {
    read<measurement_t>(traffic, bytes, give);
  } else if (channel == channels::command) {
    read<command_t>(traffic, bytes, give);
  } else if (channel == channels::run_info) {
    read<run_info_t>(traffic, bytes, give);
  } else if (channel == channels::run_state) {
    read<run_state_t>(traffic, bytes, give);
  } else if (channel == channels::timing) {
    read<timing_t>(traffic, bytes, give);
  } else if (channel == channels::status) {
    read<controller_status_t>(traffic, bytes, give);
  } else if (channel == channels::loop) {
    read<loop_records_t>(traffic, bytes, give);
  }
} catch (const std::exception&) {
  // Only memory can have run out: what comes next may fit again.
}

ChannelTraffic& BusWatcher::traffic_of(std::string_view channel) {
  const auto found = channels_.find(channel);
  if (found != channels_.end()) return found->second;
  // Names come from the bus: anybody may make up as many as they like.
  const bool room = channels_.size() < most_channels && channel.size() <= 64;
  return channels_[room ? std::string(channel) : "other channels"];
}

bool BusWatcher::is_news(std::int64_t run_id) {
  if (std::find(known_runs_.begin(), known_runs_.end(), run_id) != known_runs_.end()) return false;
  if (known_runs_.size() == most_known_runs) known_runs_.erase(known_runs_.begin());
  known_runs_.push_back(run_id);
  return true;
}

void BusWatcher::begin(std::int64_t run_id, std::int64_t now_ns) {
  is_news(run_id);
  run_.emplace();
  run_->run_id = run_id;
  run_->first_heard_ns = run_->heard_ns = now_ns;
  if (settings_.names) run_->names = *settings_.names;
}

bool BusWatcher::watches(ChannelTraffic& traffic, std::int64_t run_id, std::int64_t now_ns,
                         Speaker speaker) {
  const bool wanted = !settings_.run_id || *settings_.run_id == run_id;
  const auto is_quiet = [&] {
    // A controller may go on speaking for a run whose plant is gone.
    const std::int64_t heard_ns = speaker == Speaker::plant
                                      ? std::max(run_->measured_ns, run_->first_heard_ns)
                                      : run_->heard_ns;
    return now_ns - heard_ns > quiet_ns;
  };
  const bool same = run_ && run_->run_id == run_id;
  if (!same && wanted && (!run_ || run_->over() || is_quiet())) begin(run_id, now_ns);
  if (run_ && run_->run_id == run_id) {
    run_->heard_ns = now_ns;
    return true;
  }
  is_news(run_id);
  ++traffic.n_other_run;
  other_run_ = run_id;
  other_run_ns_ = now_ns;
  return false;
}

/// A plant that was killed and came back measures the same run from 0 again, on a floor of its own.
bool BusWatcher::is_of_another_plant(const measurement_t& message, std::int64_t now_ns) {
  WatchedRun& run = *run_;
  if (!run.plant) run.plant = message.plant_instance;
  if (message.plant_instance == *run.plant) {
    run.n_of_another = 0;
    return false;
  }
  if (++run.n_of_another < most_of_another) return true;
  follow(message.plant_instance, now_ns);
  return false;
}

void BusWatcher::follow(std::int64_t plant_instance, std::int64_t now_ns) {
  WatchedRun before = std::move(*run_);
  begin(before.run_id, now_ns);
  WatchedRun& run = *run_;
  run.plant = plant_instance;
  run.n_before = before.n_before + before.n_measured;
  run.controllers = std::move(before.controllers);
  if (before.plant_state && before.plant_state->plant_instance == plant_instance) {
    run.plant_state = before.plant_state;
  }
  if (before.other_info && before.other_info->plant_instance == plant_instance) {
    run.info = before.other_info;
    run.names = names_of(*run.info);
  }
}

void BusWatcher::make_samples(int n_floor, int n_legs, int n_frame) {
  const auto rate = run_->info ? std::optional(run_->info->sample_rate_hz) : std::nullopt;
  run_->samples.emplace(n_floor, n_legs, n_frame, rate);
}

void BusWatcher::take(ChannelTraffic& traffic, const measurement_t& message, std::int64_t now_ns) {
  if (!watches(traffic, message.run_id, now_ns, Speaker::plant)) return;
  if (is_of_another_plant(message, now_ns)) return;
  WatchedRun& run = *run_;
  run.measured_ns = now_ns;
  if (!run.samples) {
    if (run.names.source == RunNames::Source::none) {
      run.names = numbered_names(message.n_floor, message.n_legs, message.n_frame);
    } else if (!same_sizes(run.names, message)) {
      ++traffic.n_wrong_size;
      if (run.info || ++run.wrong_sizes < most_wrong_sizes) return;
      run.names = numbered_names(message.n_floor, message.n_legs, message.n_frame);
      run.names.note = "the scene that was given has other numbers of inputs, legs or outputs";
    }
    make_samples(message.n_floor, message.n_legs, message.n_frame);
  }
  switch (run.samples->take(message)) {
    case RunSamples::Taken::wrong_size:
      ++traffic.n_wrong_size;
      if (run.info || ++run.wrong_sizes < most_wrong_sizes) return;
      run.names = numbered_names(message.n_floor, message.n_legs, message.n_frame);
      run.samples.reset();
      break;
    case RunSamples::Taken::restarted:
      run.samples.reset();
      run.plant_state.reset();
      run.plant_timing.reset();
      run.controller_timing.reset();
      run.wake_ups = {};
      break;
    case RunSamples::Taken::fresh:
      ++run.n_measured;
      run.wrong_sizes = 0;
      return;
    case RunSamples::Taken::old:
      run.wrong_sizes = 0;
      return;
  }
  make_samples(message.n_floor, message.n_legs, message.n_frame);
  run.samples->take(message);
}

void BusWatcher::take(ChannelTraffic& traffic, const command_t& message, std::int64_t) {
  // A command alone tells nothing of a run.
  if (!run_ || run_->run_id != message.run_id) {
    ++traffic.n_other_run;
    return;
  }
  if (run_->plant && message.plant_instance != *run_->plant) return;
  if (run_->samples && !run_->samples->take(message)) ++traffic.n_wrong_size;
}

// Of a run that has not been heard before it is the announcement that it begins; by the clock it
// is repeated all the time, also by a second plant on the same bus.
void BusWatcher::take(ChannelTraffic& traffic, const run_info_t& message, std::int64_t now_ns) {
  const bool wanted = !settings_.run_id || *settings_.run_id == message.run_id;
  const bool same = run_ && run_->run_id == message.run_id;
  const bool begins = same ? run_->over() : wanted && is_news(message.run_id);
  if (begins) begin(message.run_id, now_ns);
  if (!watches(traffic, message.run_id, now_ns, Speaker::plant)) return;
  WatchedRun& run = *run_;
  if (run.plant && message.plant_instance != *run.plant) {
    run.other_info = message;
    return;
  }
  if (run.info && run.info->plant_instance == message.plant_instance) return;
  run.info = message;
  run.names = names_of(message);
  const bool fits = run.samples && run.samples->n_floor() == message.n_floor &&
                    run.samples->n_legs() == message.n_legs &&
                    run.samples->n_frame() == message.n_frame;
  if (!fits) run.samples.reset();
}

void BusWatcher::take(ChannelTraffic& traffic, const run_state_t& message, std::int64_t now_ns) {
  // What a run says that is over is no reason to watch it.
  const bool known = run_ && run_->run_id == message.run_id;
  if (!known && (is_end(message) || !watches(traffic, message.run_id, now_ns, Speaker::other)))
    return;
  const bool is_other = run_->plant && message.plant_instance != *run_->plant;
  // One that finds the run taken goes, and the run goes on.
  if (message.source == "plant" && is_other && is_end(message)) return;
  (message.source == "plant" ? run_->plant_state : run_->controller_state) = message;
}

void BusWatcher::take(ChannelTraffic& traffic, const timing_t& message, std::int64_t) {
  if (!run_ || run_->run_id != message.run_id) {
    ++traffic.n_other_run;
    return;
  }
  (message.source == "plant" ? run_->plant_timing : run_->controller_timing) = message;
}

void BusWatcher::take(ChannelTraffic& traffic, const controller_status_t& message,
                      std::int64_t now_ns) {
  if (!watches(traffic, message.run_id, now_ns, Speaker::other)) return;
  auto& voices = run_->controllers;
  voices[message.instance] = {message, now_ns};
  if (voices.size() <= most_controllers) return;
  voices.erase(std::min_element(voices.begin(), voices.end(), [](const auto& a, const auto& b) {
    return a.second.heard_ns < b.second.heard_ns;
  }));
}

void BusWatcher::take(ChannelTraffic& traffic, const loop_records_t& message, std::int64_t now_ns) {
  if (!watches(traffic, message.run_id, now_ns, Speaker::other)) return;
  run_->wake_ups.take(message, now_ns);
}

}  // namespace stillframe::live

#include "plant_sim/plant_link.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string_view>
#include <utility>

#include "msgs/channels.hpp"
#include "msgs/clock.hpp"
#include "msgs/clock_bus.hpp"
#include "msgs/identity.hpp"
#include "msgs/lcm_bus.hpp"
#include "plant_sim/measurement_message.hpp"

namespace stillframe {

using namespace stillframe_msgs;

PlantLink::PlantLink(const std::string& url, run_info_t info)
    : url_(url),
      lcm_(open_lcm(url)),
      info_(std::move(info)),
      last_allowed_(info_.mode == "wall_clock" ? -1 : std::numeric_limits<std::int64_t>::max()),
      commands_(info_.n_legs),
      clocks_(info_.plant_instance) {
  command_.n_legs = info_.n_legs;
  command_.force.assign(static_cast<size_t>(info_.n_legs), 0.0);
  command_size_ = static_cast<std::size_t>(command_.getEncodedSize());
  hear_lcm();
  if (info_.mode == "lock_step") offer_.emplace(info_.plant_instance);
}

void PlantLink::hear_lcm() {
  require_hearing(*lcm_);
  // A full queue drops the newest message, not the oldest: leave room for a stall of a second or
  // so.
  lcm_->subscribe(channels::command, &PlantLink::on_command, this)->setQueueCapacity(4096);
  lcm_->subscribe(channels::run_state, &PlantLink::on_state, this);
  lcm_->subscribe(channels::clock, &PlantLink::on_clock, this);
}

void PlantLink::go_direct() {
  if (offer_) line_ = offer_->accepted();
  if (line_) lcm_ = open_lcm(url_);
  offer_.reset();
}

void PlantLink::end_line() noexcept {
  line_.reset();
  try {
    hear_lcm();
  } catch (const std::exception&) {
    // Nobody is heard, and the run ends as one without an answer.
  }
}

template <class Message>
void PlantLink::publish(const char* channel, const Message& message) {
  bytes_.resize(static_cast<size_t>(message.getEncodedSize()));
  message.encode(bytes_.data(), 0, static_cast<int>(bytes_.size()));
  send(channel, bytes_);
}

void PlantLink::send(const char* channel, const std::vector<std::uint8_t>& bytes) {
  lcm_->publish(channel, bytes.data(), static_cast<unsigned>(bytes.size()));
  if (pacer_) pacer_->sent(bytes.size(), std::strlen(channel));
  const std::string_view name(channel);
  const bool for_controller = name == channels::measurement || name == channels::run_state;
  if (line_ && for_controller && !line_->send(channel, bytes.data(), bytes.size())) end_line();
}

void PlantLink::pace_by(const std::filesystem::path& log) {
  pacer_.emplace(log, [this] { send(channels::logger_check, {}); });
}

bool PlantLink::begin_pacing() { return !pacer_ || pacer_->begin(); }

bool PlantLink::wait_for_log() noexcept { return !pacer_ || pacer_->wait(); }

void PlantLink::publish_info() { publish(channels::run_info, info_); }

void PlantLink::publish_state(std::int32_t state, std::int64_t start_monotonic_ns,
                              const std::string& text) {
  state_ = state;
  run_state_t message;
  message.run_id = info_.run_id;
  message.plant_instance = message.instance = info_.plant_instance;
  message.sent_ns = monotonic_ns();
  message.source = "plant";
  message.state = state;
  message.start_monotonic_ns = start_monotonic_ns;
  message.text = text;
  publish(channels::run_state, message);
}

void PlantLink::publish_timing(const timing_t& timing) { publish(channels::timing, timing); }

void PlantLink::publish_measurement(std::int64_t k, const Reading& reading) {
  measurement_.run_id = info_.run_id;
  measurement_.plant_instance = info_.plant_instance;
  measurement_.controller_instance = seat_is_free_ ? 0 : obeyed_;
  write_measurement(reading, k, info_.sample_rate_hz, measurement_);
  measurement_bytes_.resize(static_cast<size_t>(measurement_.getEncodedSize()));
  measurement_.encode(measurement_bytes_.data(), 0, static_cast<int>(measurement_bytes_.size()));
  repeat_measurement();
}

void PlantLink::repeat_measurement() { send(channels::measurement, measurement_bytes_); }

bool PlantLink::listen(int timeout_ms) noexcept {
  if (!line_) {
    const bool heard = handle_one(*lcm_, timeout_ms);
    ask_clocks(*lcm_, clocks_);
    return heard;
  }
  switch (line_->take(timeout_ms)) {
    case DirectLine::Came::nothing:
      return false;
    case DirectLine::Came::end:
      end_line();
      return false;
    case DirectLine::Came::message:
      break;
  }
  const lcm::ReceiveBuffer buffer = buffer_of(line_->bytes());
  if (line_->channel() == channels::command) on_command(&buffer, channels::command);
  if (line_->channel() == channels::run_state) on_state(&buffer, channels::run_state);
  return true;
}

void PlantLink::set_clock(std::int64_t start_ns, double period_ns) {
  start_ns_ = start_ns;
  period_ns_ = period_ns;
}

void PlantLink::on_command(const lcm::ReceiveBuffer* buffer, const std::string& channel) {
  if (pacer_) pacer_->sent(buffer->data_size, channel.size());
  const auto identity = identity_of(bytes_of(*buffer));
  if (!identity) {
    ++n_malformed_;
    return;
  }
  if (identity->run_id != info_.run_id) return;
  if (identity->plant_instance != info_.plant_instance ||
      (!seat_is_free_ && identity->controller_instance != obeyed_)) {
    ++n_foreign_;
    return;
  }
  // A command of this run has the size of every other, so decoding it takes no more memory.
  if (bytes_of(*buffer).size() != command_size_ || !decode(*buffer, command_) ||
      !is_sound(command_)) {
    ++n_malformed_;
    return;
  }
  if (const auto when = judge_time(command_); when != Sent::sound) {
    ++(when == Sent::unknown ? n_clock_unknown_ : n_malformed_);
    return;
  }
  const Eigen::Map<const Eigen::VectorXd> force(command_.force.data(), info_.n_legs);
  switch (commands_.add(command_.seq, force)) {
    case CommandTrack::Result::taken:
      obeyed_ = command_.instance;
      seat_is_free_ = false;
      ++n_commands_;
      return;
    case CommandTrack::Result::duplicate:
      ++n_duplicate_;
      return;
    case CommandTrack::Result::too_many:
      ++n_malformed_;
  }
}

bool PlantLink::is_sound(const command_t& command) {
  const bool finite = std::all_of(command.force.begin(), command.force.end(),
                                  [](double force) { return std::isfinite(force); });
  return command.n_legs == info_.n_legs && finite && command.instance != 0 &&
         command.seq <= last_allowed_;
}

// It answers its sample, or what would have been: nobody can have sent it before that was due, nor
// after now.
PlantLink::Sent PlantLink::judge_time(const command_t& command) {
  if (start_ns_ == 0 || command.seq < 0) return Sent::sound;
  if (!PeerClocks::is_reading(command.sent_ns)) return Sent::unsound;
  const std::int64_t now = monotonic_ns();
  const auto sent = clocks_.instant(command.instance, command.sent_ns, now);
  if (!sent) return Sent::unknown;
  const bool sound =
      sent->earliest_ns <= now && static_cast<double>(sent->latest_ns - start_ns_) >=
                                      period_ns_ * static_cast<double>(command.seq - 1);
  if (!sound) clocks_.doubt(command.instance);
  return sound ? Sent::sound : Sent::unsound;
}

void PlantLink::on_state(const lcm::ReceiveBuffer* buffer, const std::string&) {
  run_state_t state;
  if (!decode(*buffer, state) || state.run_id != info_.run_id) return;
  if (state.source == "plant") {
    if (state.plant_instance != info_.plant_instance) judge_rival(state);
    return;
  }
  if (state.source != "controller" || state.plant_instance != info_.plant_instance) return;
  // Not before its clock is known: its commands could not be told from recordings.
  const auto mine = std::find(ready_.begin(), ready_.end(), state.instance);
  if (state.state == run_state_t::READY &&
      clocks_.instant(state.instance, state.sent_ns, monotonic_ns()) && mine == ready_.end() &&
      ready_.size() < 16) {  // a flood of them
    ready_.push_back(state.instance);
  }
  // Of any other it is no concern: a controller that comes with the wrong gains would end the run
  // of the one that is there, which commands nothing while it listens and arms.
  if (state.state != run_state_t::FAILED) return;
  // As long as another is ready there is somebody to wait for.
  if (mine != ready_.end()) ready_.erase(mine);
  if (obeyed_ != 0 ? state.instance == obeyed_ : ready_.empty()) {
    controller_failure_ = "the controller refused: " + state.text;
  }
}

void PlantLink::on_clock(const lcm::ReceiveBuffer* buffer, const std::string&) {
  take_clock(*lcm_, clocks_, *buffer);
}

// Another plant of this number: who runs stays, and of two that do the first, and of two that wait
// the one with the smaller instance.
void PlantLink::judge_rival(const run_state_t& other) {
  if (!clocks_.is_fresh(other.plant_instance, other.sent_ns, monotonic_ns())) return;
  const bool other_runs = other.state == run_state_t::RUNNING;
  if (!other_runs && other.state != run_state_t::WAITING) return;
  const bool runs = state_ == run_state_t::RUNNING;
  // Of two that wait none has begun.
  const bool first =
      runs ? began_first({info_.plant_instance, start_ns_, monotonic_ns()},
                         {other.plant_instance, other.start_monotonic_ns, other.sent_ns})
           : info_.plant_instance < other.plant_instance;
  const bool stays = runs != other_runs ? runs : first;
  if (!stays) {
    rival_ = "another plant " + std::string(other_runs ? "runs" : "waits") + " as run " +
             std::to_string(info_.run_id) + "; end it first, or choose another --run-id";
  } else if (runs) {
    publish_state(run_state_t::RUNNING, start_ns_, "");
  }
}

}  // namespace stillframe

#include "tools/analysis/takeover_of.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "controller/arming.hpp"
#include "core/yaml/input_error.hpp"
#include "msgs/channels.hpp"
#include "msgs/message_fit.hpp"
#include "report/log/event_file.hpp"
#include "stillframe_msgs/controller_status_t.hpp"
#include "stillframe_msgs/loop_checkpoint_t.hpp"
#include "stillframe_msgs/loop_records_t.hpp"
#include "stillframe_msgs/measurement_t.hpp"

namespace stillframe::tools {

namespace {

using Eigen::VectorXd;
using namespace stillframe_msgs;
using State = controller_status_t;

/// Goes through the records of a controller until it has taken hold, and looks at the force sensors
/// as it does while it arms: offsets themselves are not in its records.
class TakeoverSearch {
 public:
  TakeoverSearch(const run_info_t& info, std::string place)
      : info_(info),
        place_(std::move(place)),
        policy_(controller::default_policy(info.sample_rate_hz)) {}

  void take(const report::LogEvent& event) {
    if (event.channel == channels::measurement) {
      measurement_t m;
      if (decode(event.payload, m) && m.run_id == info_.run_id) plant_ = m.plant_instance;
    } else if (event.channel == channels::checkpoint) {
      loop_checkpoint_t m;
      if (decode(event.payload, m) && m.run_id == info_.run_id && !m.policy_text.empty()) {
        policy_ =
            controller::parse_policy(m.policy_text, place_ + ": policy_text", info_.sample_rate_hz);
      }
    } else if (event.channel == channels::loop) {
      loop_records_t m;
      if (!decode(event.payload, m) || m.run_id != info_.run_id) return;
      // Records do not say whose they are: a run may have had several plants, one after the other.
      if (info_.plant_instance != 0 && plant_ != info_.plant_instance) return;
      for (const loop_record_t& record : m.records) {
        if (!done_) take(record);
      }
    }
  }

  bool done() const { return done_; }

  report::Takeover finish() {
    if (!any_) {
      throw InputError(place_ +
                       ": the controller's records are missing, and with them the time at which "
                       "the loop took hold of the frame");
    }
    if (!done_ && found_.from != found_.never) {
      found_.full = found_.from + std::llround(policy_.ramp_in_s * info_.sample_rate_hz);
    }
    found_.fault = !done_ && state_ == State::FAULT;
    return found_;
  }

 private:
  void take(const loop_record_t& record) {
    any_ = true;
    const bool heard = record.defect == 0 && record.n_legs == info_.n_legs;
    const bool let_go = record.state == State::IDLE || record.state == State::ARMING ||
                        record.state == State::FAULT;
    if (let_go) found_.from = found_.never;  // before its whole command acted
    if (found_.from == found_.never) {
      // The sample in which it ends belongs to the arming, and no command is of it.
      if (state_ == State::ARMING) listen(record, heard);
      if (heard && (record.state == State::RAMP_IN || record.state == State::ACTIVE)) {
        found_.from = record.seq;
        judge();
      } else if (record.state == State::ARMING && state_ != State::ARMING) {
        arming_.reset();
      }
    }
    if (heard && record.state == State::ACTIVE) {
      found_.full = record.seq;
      done_ = true;
    }
    state_ = record.state;
  }

  void listen(const loop_record_t& record, bool heard) {
    n_missing_ = heard ? 0 : n_missing_ + record.n_elapsed;
    if (std::max(record.n_elapsed - 1, n_missing_) > policy_.hold_periods) arming_.reset();
    if (!heard) return;
    if (!arming_) {
      arming_.emplace(info_.n_legs, policy_, info_.sample_rate_hz);
      found_.heard_from = record.seq;
    }
    if (arming_->complete()) return;
    arming_->add(VectorXd::Map(record.sigma.data(), info_.n_legs));
    found_.heard_to = record.seq;
  }

  void judge() {
    found_.offset.setZero(info_.n_legs);
    if (!arming_ || !arming_->complete()) {
      found_.heard_to = found_.heard_from - 1;  // too little is known
      return;
    }
    VectorXd offset = found_.offset, doubt = offset;
    if (arming_->judge(offset, doubt) != controller::Fault::none) return;
    found_.offset = (offset.array() != 0).cast<double>();
  }

  const run_info_t& info_;
  std::string place_;
  controller::Policy policy_;
  std::optional<controller::Arming> arming_;
  report::Takeover found_;
  std::int64_t plant_ = 0, n_missing_ = 0;
  std::int32_t state_ = -1;  ///< none yet
  bool any_ = false, done_ = false;
};

}  // namespace

std::optional<report::Takeover> takeover_of(const std::filesystem::path& log,
                                            const run_info_t& info) {
  if (info.mode != "wall_clock" || info.loop != "active") return std::nullopt;
  report::EventFile file(log);
  report::LogEvent event;
  TakeoverSearch search(info, log.string());
  while (!search.done() && file.next(event)) search.take(event);
  return search.finish();
}

}  // namespace stillframe::tools

#include "judge/hold_of.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "controller/arming.hpp"
#include "core/errors/formatted.hpp"
#include "core/errors/input_error.hpp"
#include "msgs/channels.hpp"
#include "msgs/identity.hpp"
#include "msgs/message_fit.hpp"
#include "report/log/event_file.hpp"
#include "stillframe_msgs/controller_status_t.hpp"
#include "stillframe_msgs/loop_checkpoint_t.hpp"
#include "stillframe_msgs/loop_records_t.hpp"
#include "stillframe_msgs/measurement_t.hpp"

namespace stillframe::judge {

namespace {

using Eigen::VectorXd;
using namespace stillframe_msgs;
using State = controller_status_t;

/// Goes through the records of a controller, and looks at the force sensors as it does while it
/// arms: offsets themselves are not in its records.
class HoldSearch {
 public:
  HoldSearch(const run_info_t& info, std::string place)
      : info_(info),
        place_(std::move(place)),
        policy_(controller::default_policy(info.sample_rate_hz)) {}

  void take(const report::LogEvent& event) {
    if (event.channel == channels::measurement) {
      if (fit<measurement_t>(event.payload) == Fit::whole) measured(event.payload);
    } else if (event.channel == channels::checkpoint) {
      loop_checkpoint_t m;
      if (!found_.ever && decode(event.payload, m) && m.run_id == info_.run_id &&
          !m.policy_text.empty()) {
        policy_ =
            controller::parse_policy(m.policy_text, place_ + ": policy_text", info_.sample_rate_hz);
      }
    } else if (event.channel == channels::loop) {
      loop_records_t m;
      if (!decode(event.payload, m) || m.run_id != info_.run_id) return;
      // Records do not say whose they are: a run may have had several plants, one after the other.
      if (info_.plant_instance != 0 && plant_ != info_.plant_instance) return;
      const bool another = any_ && m.instance != instance_;
      if (another && found_.ever && found_.until == never) {
        let_go("another controller took its place", true);
      }
      instance_ = m.instance;
      if (another) period_ = -1;
      for (const loop_record_t& record : m.records) {
        if (record.period > period_) take(record);  // once, as often as it was heard
      }
    }
  }

  Hold finish() {
    if (!any_) {
      throw InputError(place_ +
                       ": the controller's records are missing, and with them the time at which "
                       "the loop took hold of the frame");
    }
    if (!found_.ever) {
      never_held();
      return found_;
    }
    // Records come in batches of a tenth of a second.
    if (found_.until == never &&
        last_measured_ - last_heard_ > std::llround(info_.sample_rate_hz)) {
      let_go("the records of its controller end there", false);
    }
    // With its last sample a plant says that its run has ended, which may be heard before that one.
    const std::int64_t ends_with = found_.fault ? 0 : 2;
    if (found_.until > last_measured_ - ends_with) {
      found_.until = never;
      found_.why.clear();
      found_.fault = false;
    }
    return found_;
  }

 private:
  static constexpr std::int64_t never = report::Takeover::never;

  void measured(std::string_view payload) {
    const auto identity = identity_of(payload);
    if (!identity || identity->run_id != info_.run_id) return;
    plant_ = identity->plant_instance;
    if (info_.plant_instance != 0 && plant_ != info_.plant_instance) return;
    last_measured_ =
        std::max(last_measured_, read_int64(&payload[32]));  // seq, behind the identity
  }

  void take(const loop_record_t& record) {
    const bool heard = record.defect == 0 && record.n_legs == info_.n_legs;
    if (!found_.ever) {
      take_hold(record, heard);
    } else if (found_.until == never) {
      hold_on(record);
    }
    any_ = true;
    state_ = record.state;
    period_ = record.period;
    if (heard) last_heard_ = record.seq;
  }

  void take_hold(const loop_record_t& record, bool heard) {
    report::Takeover& takeover = found_.takeover;
    const bool let_go = record.state == State::IDLE || record.state == State::ARMING ||
                        record.state == State::FAULT;
    if (let_go) takeover.from = never;  // before its whole command acted
    if (record.state == State::FAULT) fault_ = record.fault;
    armed_ = armed_ || record.state == State::ARMING;
    if (takeover.from == never) {
      // The sample in which it ends belongs to the arming, and no command is of it.
      if (state_ == State::ARMING) listen(record, heard);
      if (heard && (record.state == State::RAMP_IN || record.state == State::ACTIVE)) {
        takeover.from = record.seq;
        ramped_from_ = record.seq;
        judge();
      } else if (record.state == State::ARMING && state_ != State::ARMING) {
        arming_.reset();
      }
    }
    if (heard && record.state == State::ACTIVE) {
      takeover.full = record.seq;
      found_.ever = true;
    }
  }

  void hold_on(const loop_record_t& record) {
    if (record.state == State::ACTIVE) leaving_ = never;
    if (record.state == State::ACTIVE) return;
    leaving_ = std::min(leaving_, last_heard_ + 1);
    const bool may_come_back = record.state == State::FADING || record.state == State::RAMP_IN;
    if (may_come_back) return;
    const bool stopped =
        record.state == State::RAMP_OUT || (record.state == State::IDLE && state_ != State::FADING);
    if (stopped) return let_go("it was stopped", false);
    let_go("its controller had the fault " +
               std::string(to_text(static_cast<controller::Fault>(record.fault))),
           true);
  }

  void let_go(const std::string& why, bool fault) {
    found_.until = std::min(leaving_, last_heard_ + 1);
    found_.why = why;
    found_.fault = fault;
  }

  void never_held() {
    report::Takeover& takeover = found_.takeover;
    const auto seconds = [&](std::int64_t seq) {
      return formatted("%.4g s", static_cast<double>(seq) / info_.sample_rate_hz);
    };
    if (takeover.from != never) {
      takeover.full = takeover.from + std::llround(policy_.ramp_in_s * info_.sample_rate_hz);
    }
    if (fault_ != 0) {
      found_.fault = true;
      found_.why = "its controller had the fault " +
                   std::string(to_text(static_cast<controller::Fault>(fault_)));
    } else if (ramped_from_ != never) {
      found_.why = "its ramp began at " + seconds(ramped_from_) + " and did not come to its end";
    } else {
      found_.why = armed_ ? "its controller never ended arming" : "its controller never armed";
    }
  }

  void listen(const loop_record_t& record, bool heard) {
    n_missing_ = heard ? 0 : n_missing_ + record.n_elapsed;
    if (std::max(record.n_elapsed - 1, n_missing_) > policy_.hold_periods) arming_.reset();
    if (!heard) return;
    if (!arming_) {
      arming_.emplace(info_.n_legs, policy_, info_.sample_rate_hz);
      found_.takeover.heard_from = record.seq;
    }
    if (arming_->complete()) return;
    arming_->add(VectorXd::Map(record.sigma.data(), info_.n_legs));
    found_.takeover.heard_to = record.seq;
  }

  void judge() {
    found_.takeover.offset.setZero(info_.n_legs);
    if (!arming_ || !arming_->complete()) {
      found_.takeover.heard_to = found_.takeover.heard_from - 1;  // too little is known
      return;
    }
    VectorXd offset = found_.takeover.offset, doubt = offset;
    if (arming_->judge(offset, doubt) != controller::Fault::none) return;
    found_.takeover.offset = (offset.array() != 0).cast<double>();
  }

  const run_info_t& info_;
  std::string place_;
  controller::Policy policy_;
  std::optional<controller::Arming> arming_;
  Hold found_;
  std::int64_t plant_ = 0, instance_ = 0, n_missing_ = 0, period_ = -1;
  std::int64_t last_measured_ = -1, last_heard_ = -1;   ///< seq
  std::int64_t ramped_from_ = never, leaving_ = never;  ///< seq
  std::int32_t state_ = -1, fault_ = 0;                 ///< none yet
  bool any_ = false, armed_ = false;
};

}  // namespace

std::optional<Hold> hold_of(const std::filesystem::path& log, const run_info_t& info) {
  if (info.mode != "wall_clock" || info.loop != "active") return std::nullopt;
  report::EventFile file(log);
  report::LogEvent event;
  HoldSearch search(info, log.string());
  while (file.next(event)) search.take(event);
  return search.finish();
}

}  // namespace stillframe::judge

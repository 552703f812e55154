#include "controller/rig/closing.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "controller/loop.hpp"
#include "controller/start_check.hpp"
#include "controller/telemetry.hpp"

namespace stillframe::controller {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double longest_silence_s = 3;
// Beside arming, ramp and what amplifiers may hold at first.
constexpr double patience_s = 20;
// After the last command of a force, in which the loop switches the amplifiers off.
constexpr double switch_off_s = 2;
constexpr std::int64_t switch_off_samples = 30;
// Of a window: a loop answers the newest of the samples that came in a burst, and has no others.
constexpr double most_missing_closed = 0.05;

class Closing {
 public:
  Closing(Io& io, const Gains& gains, const Policy& policy, Index n_floor, Index n_frame,
          const ProbeTime& time, const std::function<bool()>& stop)
      : gains_(gains),
        policy_(policy),
        time_(time),
        stop_(stop),
        supervisor_(gains, policy, true),
        began_ns_(time.now_ns()),  // what is excited by may have taken seconds
        loop_(io, supervisor_, policy,
              {.sample_rate_hz = gains.sample_rate_hz,
               .start_ns = began_ns_,
               .now_ns = began_ns_,
               .n_floor = n_floor,
               .n_frame = n_frame,
               .pacing = Pacing::card}) {
    const Excitation& plan = supervisor_.excitation();
    n_rows_ = static_cast<Index>(plan.n_samples()) + 2 * recording_margin;
    const Index m = gains.n_legs();
    closed_.recording = empty_recording(n_rows_, m, measurement_of(m, n_floor, n_frame));
    closed_.sent = Eigen::MatrixXd::Zero(n_rows_, m);
    there_.assign(static_cast<std::size_t>(n_rows_), false);
    closed_.frame_peak = mean_ = VectorXd::Zero(n_frame);
  }

  ClosedRecording run(const std::function<void(double)>& progress) {
    std::string wrong;
    bool done = false;
    const auto end = [&](const std::string& why) {
      if (!done) loop_.request(Request::stop);
      if (!done) wrong = why;
      done = true;
    };
    std::int64_t off = 0;
    while (off < switched_off()) {
      period();
      const LoopCounters& counters = loop_.counters();
      off = done && !counters.driving ? off + 1 : 0;
      if (done) continue;
      if (counters.latched) {
        end("the loop let go of the frame: " + fault_in_words(counters, gains_.legs));
      } else if (bad_frame_ >= 0) {
        end(bad_frame_in_words());
      } else if (stop_ && stop_()) {
        end("interrupted");
      } else if (passed_s(heard_ns_) > longest_silence_s + 3 * gains_.sample_time()) {
        end("no sample has come for some seconds");
      } else if (start() < 0 && passed_s(began_ns_) > patience()) {
        end("the loop did not become active; it is " + std::string(to_text(counters.state.load())) +
            (counters.n_faults > 0 ? ", after the fault " + fault_in_words(counters, gains_.legs)
                                   : ""));
      } else if (start() >= 0 && row_ + 1 >= n_rows_) {
        end("");
      }
      if (progress && start() >= 0 && row_ % 256 == 0) {
        progress(static_cast<double>(row_) / static_cast<double>(n_rows_));
      }
    }
    // On the way out, too: of what is no number no peak is made.
    if (wrong.empty() && bad_frame_ >= 0) wrong = bad_frame_in_words();
    if (!wrong.empty()) throw std::runtime_error(wrong);
    finish();
    return std::move(closed_);
  }

 private:
  std::int64_t start() const { return loop_.supervisor().excitation().start(); }
  double passed_s(std::int64_t since_ns) const {
    return 1e-9 * static_cast<double>(time_.now_ns() - since_ns);
  }
  std::string bad_frame_in_words() const {
    return "accelerometer " + std::to_string(bad_frame_ + 1) +
           " of the frame gave what is no number";
  }
  double patience() const { return patience_s + 2 * (policy_.arming_s + policy_.ramp_in_s); }
  std::int64_t switched_off() const {
    return std::llround(switch_off_s * gains_.sample_rate_hz) + switch_off_samples;
  }

  void period() {
    time_.sleep_until_ns(loop_.next_ns());
    loop_.period(time_.now_ns());
    while (const LoopRecord* record = loop_.records().oldest()) {
      take(*record);
      loop_.records().pop();
    }
    while (loop_.checkpoints().oldest() != nullptr) loop_.checkpoints().pop();
  }

  void take(const LoopRecord& record) {
    if (record.sent) {
      closed_.force_peak =
          std::max(closed_.force_peak, record.command.force.lpNorm<Eigen::Infinity>());
    }
    if (record.defect != Defect::none) return;
    heard_ns_ = time_.now_ns();
    const Measurement& now = record.measurement;
    // The loop looks at what it answers to, which these are no part of. Once the amplifiers are off
    // nothing is made of them.
    const bool is_over = start() >= 0 && record.state == State::idle;
    for (Index i = 0; i < now.frame.size() && !is_over; ++i) {
      if (bad_frame_ < 0 && !std::isfinite(now.frame(i))) bad_frame_ = i;
    }
    // Accelerometers have offsets.
    if (record.state == State::idle || record.state == State::arming) {
      mean_ += (now.frame - mean_) / static_cast<double>(++n_mean_);
    } else {
      closed_.frame_peak = closed_.frame_peak.cwiseMax((now.frame - mean_).cwiseAbs());
    }
    if (start() < 0 || now.seq < start()) return;
    const std::int64_t row = now.seq - start();
    row_ = std::max(row_, row);
    if (row >= n_rows_) return;
    Recording& out = closed_.recording;
    const auto i = static_cast<Index>(row);
    out.command.row(i) = record.excitation.transpose();
    closed_.sent.row(i) = record.command.force.transpose();
    put(now, i, out);
    there_[static_cast<std::size_t>(row)] = record.state == State::active && now.heard;
  }

  void finish() {
    Recording& out = closed_.recording;
    // What was sent last acts until something else is.
    for (Index i = 1; i < n_rows_; ++i) {
      if (there_[static_cast<std::size_t>(i)]) continue;
      out.command.row(i) = out.command.row(i - 1);
      closed_.sent.row(i) = closed_.sent.row(i - 1);
    }
    const Excitation& plan = supervisor_.excitation();
    choose_windows(out, there_, 0, plan.n_window(), plan.n_windows(), plan.n_windows(),
                   gains_.n_legs(), most_missing_closed);
    out.drift = loop_.counters().drift;
    closed_.lines = plan.lines();
    closed_.n_window = plan.n_window();
    closed_.n_faults = loop_.counters().n_faults;
    if (closed_.n_faults > 0) closed_.last_fault = fault_in_words(loop_.counters(), gains_.legs);
    closed_.n_saturated = loop_.counters().n_saturated;
    closed_.added_force = out.command.cwiseAbs().maxCoeff();
  }

  const Gains& gains_;
  const Policy& policy_;
  const ProbeTime& time_;
  const std::function<bool()>& stop_;
  Supervisor supervisor_;
  std::int64_t began_ns_, heard_ns_ = began_ns_;
  Loop loop_;
  ClosedRecording closed_;
  Index n_rows_ = 0;
  Index bad_frame_ = -1;  ///< the first accelerometer that gave no number
  std::vector<bool> there_;
  VectorXd mean_;  ///< of the accelerometers
  std::int64_t row_ = 0, n_mean_ = 0;
};

}  // namespace

ClosedRecording close_on_rig(Io& io, const Gains& gains, const Policy& policy, Index n_floor,
                             Index n_frame, const ProbeTime& time,
                             const std::function<void(double)>& progress,
                             const std::function<bool()>& stop) {
  require_stable(gains);
  require_stable_ramp(gains);
  return Closing(io, gains, policy, n_floor, n_frame, time, stop).run(progress);
}

}  // namespace stillframe::controller

#include "tools/run/single_process.hpp"

#include <cerrno>
#include <cstring>

#include "core/errors/formatted.hpp"
#include "msgs/channels.hpp"
#include "msgs/clock.hpp"
#include "msgs/log_writer.hpp"
#include "msgs/stop_signal.hpp"
#include "plant_sim/run_description.hpp"
#include "plant_sim/run_length.hpp"
#include "stillframe_msgs/run_state_t.hpp"
#include "stillframe_msgs/timing_t.hpp"
#include "tools/run/closed_loop.hpp"
#include "tools/run/progress_bar.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

namespace {

using namespace stillframe_msgs;

/// The messages of a run around its samples, as in lock-step.
class RunLogFile {
 public:
  RunLogFile(std::filesystem::path path, const run_info_t& info)
      : path_(std::move(path)), file_(path_) {
    state_.run_id = timing_.run_id = info.run_id;
    state_.plant_instance = state_.instance = state_.sent_ns = 0;
    timing_.n_late = timing_.n_lost = timing_.n_duplicate = timing_.n_listened = 0;
    timing_.n_foreign = 0;
    timing_.worst_wake_up_ns = 0;
    keep(file_.write(channels::run_info, info));
    say("controller", run_state_t::READY, "");
    say("plant", run_state_t::RUNNING, "");
  }
  bool sample(const ClosedLoop& loop) {
    if (error_ != 0) return false;
    return keep(file_.write(channels::measurement, loop.measurement())) &&
           keep(file_.write(channels::command, loop.command()));
  }
  /// Why it takes no more.
  std::string failure() const {
    return path_.string() + ": cannot be written: " + std::strerror(error_);
  }
  void say(const char* source, std::int32_t state, const std::string& text) {
    state_.source = source;
    state_.state = state;
    state_.start_monotonic_ns = 0;
    state_.text = text;
    keep(file_.write(channels::run_state, state_));
  }
  bool finish(std::int64_t n, const ClosedLoop& loop, std::int64_t wall_ns) {
    say("plant", run_state_t::ENDED, "");
    timing_.n_periods = n;
    timing_.wall_time_ns = wall_ns;
    tell("plant", loop.worst_plant_ns());
    tell("controller", loop.worst_answer_ns());
    return keep(file_.finish());
  }

 private:
  /// Of all that fails the first says why.
  bool keep(bool written) {
    if (!written && error_ == 0) error_ = errno != 0 ? errno : EIO;
    return error_ == 0;
  }
  void tell(const char* source, std::int64_t worst_ns) {
    timing_.source = source;
    timing_.worst_compute_ns = worst_ns;
    keep(file_.write(channels::timing, timing_));
  }

  std::filesystem::path path_;
  LogWriter file_;
  run_state_t state_;
  timing_t timing_;
  int error_ = 0;
};

}  // namespace

PhaseResult run_in_process(const judge::LoopDesign& design, const floor::FloorSpec& floor,
                           const std::string& floor_text, const PhaseOptions& options,
                           const RunDirectory& directory) {
  ClosedLoop loop(design.scene, design.gains, floor::make_floor_source(floor), options.run_id,
                  options.loop == "active");
  const std::int64_t n =
      run_length(design.scene, floor, loop.plant().floor_samples(), options.duration_s);
  const auto info = describe_run(design.scene, {.run_id = options.run_id,
                                                .n_samples = n,
                                                .program_version = STILLFRAME_VERSION,
                                                .floor_text = floor_text,
                                                .gains_text = to_yaml(design.gains),
                                                .mode = "single_process",
                                                .loop = options.loop});
  RunLogFile log(directory / (options.loop + ".lcm"), info);
  ProgressBar bar(options.loop, options.sample_rate_hz);
  constexpr std::int64_t show_every_ns = ns_per_s / 5;
  const std::int64_t begin = monotonic_ns();
  std::int64_t shown = begin, now = begin;
  const auto fail = [&log](const std::string& reason) {
    log.say("plant", run_state_t::FAILED, reason);
    return PhaseResult{exit_failed, reason, ""};
  };
  for (std::int64_t k = 0; k < n; ++k) {
    const std::string reason = loop.step();
    if (!log.sample(loop)) return fail(log.failure());
    if (!reason.empty()) return fail(reason);
    now = monotonic_ns();
    if (now - shown < show_every_ns) continue;
    shown = now;
    bar.show(k, n);
    if (stop_requested()) return fail("interrupted");
  }
  const std::int64_t wall = now - begin;
  if (!log.finish(n, loop, wall)) return fail(log.failure());
  const auto& answer = loop.answer();
  if (answer.n_fallback() > 0) {
    return {exit_failed,
            std::to_string(answer.n_fallback()) +
                " commands fell back to zero force, because values were not finite",
            ""};
  }
  const double speed =
      static_cast<double>(n) / options.sample_rate_hz / (static_cast<double>(wall) * 1e-9);
  const std::string line =
      formatted("%lld samples in one process by the method %s, %.0f times as fast as real time%s",
                static_cast<long long>(n), method_name(loop.plant().choice().method).c_str(), speed,
                loop.plant().n_out_of_range() > 0 ? "; force sensors were out of range" : "");
  return {exit_done, "", line};
}

}  // namespace stillframe::tools

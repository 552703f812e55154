#include <spdlog/spdlog.h>
#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "controller/background.hpp"
#include "controller/background_log.hpp"
#include "controller/gains.hpp"
#include "controller/handshake.hpp"
#include "controller/latch.hpp"
#include "controller/law.hpp"
#include "controller/lcm_stream.hpp"
#include "controller/lock_step.hpp"
#include "controller/policy.hpp"
#include "controller/realtime.hpp"
#include "controller/rig/driver.hpp"
#include "controller/rig/rig_file.hpp"
#include "controller/session.hpp"
#include "controller/start_check.hpp"
#include "controller/telemetry.hpp"
#include "controller/timing_file.hpp"
#include "core/cli/command.hpp"
#include "core/files/printable_log.hpp"
#include "core/files/standard_output.hpp"
#include "core/files/whole_file.hpp"
#include "core/yaml/reader.hpp"
#include "msgs/clock.hpp"
#include "msgs/identity.hpp"
#include "msgs/lcm_bus.hpp"
#include "msgs/stop_signal.hpp"

namespace stillframe::controller {

using stillframe_msgs::timing_t;

namespace {

constexpr int exit_done = 0, exit_error = 1, exit_bad_input = 2, exit_refused = 3, exit_failed = 4;

constexpr const char* description =
    "The controller process of a stillframe run. It reads gains, refuses them if the sampled "
    "closed loop\n"
    "is not stable, waits on LCM for a plant that runs the same scene, and answers its "
    "measurements\n"
    "(SF_MEASUREMENT) with piezo forces (SF_COMMAND) until the plant ends the run. Lock-step or\n"
    "wall-clock, sample rate and delay are the plant's to say (SF_RUN_INFO).\n"
    "With --rig or --io it runs a rig of its own in place of a plant, wall-clock, and says on LCM\n"
    "what it measures and commands, as a plant would (docs/hardware.md).\n"
    "In wall-clock runs it arms, ramps the loop in, and lets the frame go smoothly when anything\n"
    "fails, by the numbers of a policy (docs/safety.md). `stillframe ctl` starts, stops and "
    "resets\n"
    "it; Ctrl-C, SIGTERM and a hang-up ramp out and end it.";

constexpr const char* footer =
    "Examples:\n"
    "  stillframe-controller --gains gains.yaml --check-only\n"
    "  scripts/private_network stillframe-controller --gains gains.yaml --run-id 7 --timeout 30\n"
    "  stillframe-controller --gains gains.yaml --policy policy.yaml --realtime enforce\n"
    "  scripts/private_network stillframe-controller --gains gains.yaml --io simulation --duration "
    "20\n"
    "  stillframe-controller --gains gains.yaml --rig rig.yaml\n"
    "Exit codes: 0 done, 1 internal error or output that cannot be written, 2 bad input, 3 "
    "refused\n"
    "(an unstable loop, no force limit, another controller, no real time where it is enforced), 4 "
    "the\n"
    "run failed, fell back, or ended with a latched fault.";

struct Options {
  std::filesystem::path gains;
  std::string lcm_url;
  std::optional<std::int64_t> run_id;
  std::optional<std::filesystem::path> rig;
  std::string io = "lcm";
  std::optional<double> duration_s;
  double timeout_s = 10;
  double phase = 0.5;
  std::optional<std::filesystem::path> policy, timing;
  std::filesystem::path flight_folder = ".";
  std::optional<std::filesystem::path> latch;
  bool reset = false;
  std::optional<std::string> realtime;
  bool check_only = false;
};

void add_options(cli::Command& app, Options& options) {
  app.option("--gains", options.gains, "Gains file (YAML), as `stillframe design` writes it")
      .required()
      .type_name("FILE");
  app.option("--lcm-url", options.lcm_url,
             "LCM provider (default: the environment's LCM_DEFAULT_URL, or "
             "udpm://239.255.76.67:7667?ttl=0)")
      .type_name("URL");
  app.option("--run-id", options.run_id, "Run to serve (default: the first that is heard)")
      .type_name("ID");
  app.option("--rig", options.rig,
             "Rig file (YAML): driver, channels with their gains and signs (docs/hardware.md)")
      .type_name("FILE");
  app.option("--io", options.io,
             "Where samples come from: lcm, a plant on the bus; simulation, the plant of the gains "
             "in this process; device, converters behind devices; or a driver of your own, a "
             "shared library (default: the rig file's, or lcm)")
      .type_name("NAME");
  app.option("--duration", options.duration_s,
             "Seconds after which a run on a rig ends (default: at Ctrl-C or SIGTERM)")
      .check(cli::positive_number());
  app.option("--timeout", options.timeout_s,
             "Seconds without a word from the plant after which the run has failed")
      .check(cli::positive_number())
      .show_default();
  app.option("--phase", options.phase,
             "Wall-clock mode: when in a sample to wake up, as a part of it from 0 up to 1")
      .check(cli::number_between(0.0, 0.999))
      .show_default();
  app.option("--policy", options.policy,
             "Wall-clock mode: fault policy (YAML, docs/safety.md; default: its defaults)")
      .type_name("FILE");
  app.option("--realtime", options.realtime,
             "Wall-clock mode: SCHED_FIFO, locked memory and fine timers: off; best_effort: go "
             "on without what the system refuses; enforce: do not (default: the policy's)")
      .check(cli::one_of({"off", "best_effort", "enforce"}));
  app.option("--timing", options.timing,
             "Wall-clock mode: write histograms of wake-up, receipt, computing and publishing "
             "at the end (JSON)")
      .type_name("FILE");
  app.option("--flight-folder", options.flight_folder,
             "Wall-clock mode: where flight records (flight-RUN-N.lcm) go after a fault")
      .show_default()
      .type_name("DIR")
      .check(cli::existing_folder());
  app.option("--latch", options.latch,
             "Wall-clock mode: where a latched fault is kept until a person resets it (default: "
             "$XDG_STATE_HOME or ~/.local/state, stillframe/latch-SCENE_TITLE.yaml)")
      .type_name("FILE");
  app.flag("--reset", options.reset,
           "Wall-clock mode: the cause of a fault that is latched from before is mended");
  app.flag("--check-only", options.check_only,
           "Only check the gains: print the spectral radius of the sampled closed loop");
}

// Long enough for a disk that is slow; one that takes longer hangs.
constexpr double terminal_patience_s = 1, disk_patience_s = 4;
constexpr std::size_t most_lines = 1000, most_files = 16;  // that wait for them

/// What may hang. Nothing that serves the frame waits for either.
struct Outside {
  Background terminal{most_lines}, disk{most_files};
  bool disk_hangs = false;  ///< it was waited for once
};

void print_closing_line(Background& terminal, const timing_t& counters) {
  terminal.give([counters] {
    std::printf(
        "controller: %lld periods, %lld late, %lld lost, worst wake-up %.1f us, worst compute %.1f "
        "us\n",
        static_cast<long long>(counters.n_periods), static_cast<long long>(counters.n_late),
        static_cast<long long>(counters.n_lost),
        static_cast<double>(counters.worst_wake_up_ns) / 1e3,
        static_cast<double>(counters.worst_compute_ns) / 1e3);
    std::fflush(stdout);
  });
}

/// How a run ended in words, for all that is not an end in good order.
std::string trouble(Outcome outcome, const ControllerLink& link, double timeout_s) {
  switch (outcome) {
    case Outcome::plant_failed:
      return "the plant failed: " + link.plant_state().text;
    case Outcome::missed:
      return "the run had ended before its start was heard";
    case Outcome::silent:
      return fmt::format("nothing heard from the plant for {} s{}", timeout_s, link.unanswered());
    case Outcome::interrupted:
      return "interrupted before the run had ended";
    case Outcome::ended:
    case Outcome::began_anew:
    case Outcome::refused:
      break;
  }
  return "";
}

int close_run(Outcome outcome, ControllerLink& link, const timing_t& counters, double timeout_s,
              Background& terminal) {
  if (outcome == Outcome::interrupted) {
    link.publish_state(link.run_info().run_id, stillframe_msgs::run_state_t::FAILED,
                       "the controller was interrupted");
  }
  if (outcome == Outcome::ended) link.publish_timing(counters);
  if (counters.n_periods > 0) print_closing_line(terminal, counters);
  const std::string text = trouble(outcome, link, timeout_s);
  if (text.empty()) return exit_done;
  spdlog::error(text);
  return exit_failed;
}

int serve_lock_step(const Options& options, const Gains& gains, ControllerLink& link,
                    Background& terminal) {
  Answer answer(law_from_gains(gains), gains.force_limit_n, link.run_info().loop != "passive");
  timing_t counters{};
  const Outcome outcome = run_lock_step(link, answer, options.timeout_s, counters);
  const int code = close_run(outcome, link, counters, options.timeout_s, terminal);
  if (answer.n_saturated() > 0) {
    spdlog::warn("{} commands were limited by force_limit_n", answer.n_saturated());
  }
  if (answer.n_fallback() == 0) return code;
  spdlog::error("{} commands fell back to zero force, because values were not finite",
                answer.n_fallback());
  return exit_failed;
}

void say_counters(const LoopCounters& counters) {
  if (counters.n_saturated > 0)
    spdlog::warn("{} commands were limited", counters.n_saturated.load());
  if (counters.n_faults > 0) {
    spdlog::warn("{} faults, {} times back in the loop", counters.n_faults.load(),
                 counters.n_rejoins.load());
  }
  if (counters.drift != 0 || counters.n_locks > 0) {
    spdlog::info("the clock of the samples: {:+.1f} ppm of this machine's, {} times found anew",
                 -1e6 * counters.drift, counters.n_locks.load());
  }
  if (counters.n_page_faults > 0) {
    spdlog::warn("{} page faults in the loop", counters.n_page_faults.load());
  }
  if (counters.n_records_dropped > 0) {
    spdlog::warn("{} records of the loop were dropped from telemetry",
                 counters.n_records_dropped.load());
  }
}

/// Session after session, as long as the plant begins anew.
class WallClock {
 public:
  WallClock(const Options& options, const Gains& gains, const Policy& policy,
            const std::string& policy_text, ControllerLink& link, Latch& latch, Outside& outside)
      : options_(options),
        gains_(gains),
        policy_(policy),
        link_(link),
        outside_(outside),
        presence_(link.instance(), monotonic_ns()),
        latch_(latch) {
    session_options_ = {.timeout_s = options.timeout_s,
                        .phase = options.phase,
                        .any_run = !options.run_id,
                        .flight_folder = options.flight_folder,
                        .policy_text = policy_text,
                        .say = [](const std::string& text) { spdlog::info(text); },
                        .warn = [](const std::string& text) { spdlog::warn(text); }};
    link.stop_measurements();
    // Stop and interlock are not to wait for their turn behind ordinary programs.
    prepare_servant(policy);
  }

  int serve(Start start) {
    while (true) {
      if (start.over) return close(*start.over);
      LcmStream stream(lcm_url(options_.lcm_url), link_.run_info(), link_.instance(), policy_);
      const Outcome outcome = run_session(stream, start);
      if (outcome != Outcome::began_anew) return close(outcome);
      spdlog::info("the plant begins anew");
      link_.forget();
      start = shake_hands(link_, gains_, options_.run_id, options_.timeout_s);
    }
  }

  /// On a rig, which this process speaks for. Without an end it ends when it is told to.
  int serve_rig(Io& io, const RigFile& rig) {
    ScaledIo scaled(io, rig.channels);
    Outcome outcome = run_session(scaled, {{}, monotonic_ns(), 0});
    if (outcome == Outcome::interrupted && !options_.duration_s) outcome = Outcome::ended;
    link_.publish_end();
    return close(outcome);
  }

 private:
  Outcome run_session(Io& io, const Start& start) {
    Session session(io, link_, gains_, policy_, presence_, latch_, outside_.disk, session_options_,
                    start);
    const Outcome outcome = session.run();
    session.add_to(counters_, times_);
    say_counters(session.counters());
    if (outcome == Outcome::refused) throw Refusal(session.reason());
    never_active_ = session.never_active();
    return outcome;
  }

  int close(Outcome outcome) {
    int code = close_run(outcome, link_, counters_, options_.timeout_s, outside_.terminal);
    if (!write_files() && code == exit_done) code = exit_error;
    if (!never_active_.empty()) spdlog::error(never_active_);
    if (latch_.fault() == Fault::none) return never_active_.empty() ? code : exit_failed;
    spdlog::error("the run ended with a latched fault: {}",
                  fault_in_words(latch_.fault(), latch_.leg()));
    return exit_failed;
  }

  /// False, and said, if they are not what was asked for.
  bool write_files() {
    const auto sound = std::make_shared<std::atomic<bool>>(true);
    if (options_.timing) {
      outside_.disk.give([sound, file = *options_.timing, counters = counters_, times = times_] {
        try {
          write_timing_file(file, counters, times);
        } catch (const std::exception& error) {
          spdlog::error("{}", error.what());
          *sound = false;
        }
      });
    }
    if (outside_.disk.finish(disk_patience_s)) return *sound;
    outside_.disk_hangs = true;
    spdlog::error("the disk does not answer: files of this run are not complete");
    return false;
  }

  const Options& options_;
  const Gains& gains_;
  const Policy& policy_;
  ControllerLink& link_;
  Outside& outside_;
  Presence presence_;
  Latch& latch_;
  SessionOptions session_options_;
  timing_t counters_{};
  LoopTimes times_;
  std::string never_active_;
};

/// policy_text: that of the file, which is read once.
Policy policy_of(const Options& options, double sample_rate_hz, std::string& policy_text) {
  Policy policy = default_policy(sample_rate_hz);
  if (options.policy) {
    policy_text = YamlReader::from_file(*options.policy).source_text();
    policy = parse_policy(policy_text, options.policy->string(), sample_rate_hz);
  }
  if (options.realtime) policy.realtime = realtime_named(*options.realtime);
  return policy;
}

/// The latch of a wall-clock run. A plant that waits is told if it cannot be read.
Latch open_latch(const Options& options, ControllerLink& link, Background& disk) {
  const auto warn = [](const std::string& text) { spdlog::warn(text); };
  try {
    const Latch latch(
        options.latch ? *options.latch : default_latch_file(link.run_info().scene_name), disk, warn,
        options.reset);
    if (latch.file().empty()) {
      warn(
          "a latched fault will not outlive this process: there is no home folder, and no "
          "--latch FILE");
    }
    if (latch.fault() != Fault::none) {
      spdlog::warn(
          "a fault is latched from before ({}, {}): mend its cause, then `stillframe ctl "
          "reset` or --reset",
          fault_in_words(latch.fault(), latch.leg()), latch.file().string());
    }
    return latch;
  } catch (const InputError& error) {
    link.publish_state(link.run_info().run_id, stillframe_msgs::run_state_t::FAILED, error.what());
    throw;
  }
}

/// Why wall-clock runs would be refused, empty where they would not.
struct Reasons {
  std::string any, active;  ///< any run; those that control
};

template <class Check>
std::string refusal_by(Check check) {
  try {
    check();
  } catch (const Refusal& refusal) {
    return refusal.what();
  }
  return "";
}

/// What has to be had before forces are sent by the clock. Errors: Refusal.
void require_real_time(const Policy& policy, ControllerLink& link) {
  const RealtimeReport realtime = prepare_process(policy);
  spdlog::info("real time: {}", realtime.text);
  if (policy.realtime != Policy::Realtime::enforce || realtime.complete) return;
  link.publish_state(link.run_info().run_id, stillframe_msgs::run_state_t::FAILED, "no real time");
  throw Refusal("real time is enforced and was not obtained: " + realtime.text +
                "; run as root or with CAP_SYS_NICE and CAP_IPC_LOCK, or take best_effort");
}

int serve_rig(const Options& options, const Gains& gains, const Policy& policy,
              const std::string& policy_text, const Reasons& reasons, Outside& outside) {
  RigFile rig = options.rig ? read_rig(*options.rig, gains) : default_rig(gains);
  choose_driver(rig, options.io == "lcm" ? "" : options.io);
  require_clocked_delay(gains, options.gains.string());
  for (const std::string& reason : {reasons.any, reasons.active}) {
    if (!reason.empty()) throw Refusal(reason);
  }
  const LoadedIo io = load_driver(rig.driver, rig.setting(gains));
  catch_stop_signals();
  ignore_write_signals();
  ControllerLink link(lcm_url(options.lcm_url), policy);
  const auto n_samples =
      static_cast<std::int64_t>(options.duration_s.value_or(0) * gains.sample_rate_hz);
  link.host(describe_rig(rig, gains, YamlReader::from_file(options.gains).source_text(),
                         options.run_id.value_or(new_run_id()), n_samples, STILLFRAME_VERSION));
  const auto& info = link.run_info();
  spdlog::info("run {} of {}: driver {}, {} Hz", info.run_id, info.scene_name, rig.driver,
               info.sample_rate_hz);
  require_real_time(policy, link);
  Latch latch = open_latch(options, link, outside.disk);
  return WallClock(options, gains, policy, policy_text, link, latch, outside).serve_rig(*io, rig);
}

int serve(const Options& options, const Gains& gains, const Policy& policy,
          const std::string& policy_text, const Reasons& reasons, Outside& outside) {
  catch_stop_signals();
  ignore_write_signals();
  ControllerLink link(lcm_url(options.lcm_url), policy);
  spdlog::info("waiting for a plant");
  const Start start = shake_hands(link, gains, options.run_id, options.timeout_s);
  const auto& info = link.run_info();
  if (start.over) return close_run(*start.over, link, {}, options.timeout_s, outside.terminal);
  spdlog::info("run {} of {}: {}, {} Hz, {} loop", info.run_id, info.scene_name, info.mode,
               info.sample_rate_hz, info.loop);
  if (info.mode != "wall_clock") return serve_lock_step(options, gains, link, outside.terminal);
  const bool ramps = reasons.any.empty() && info.loop != "passive";
  if (const std::string& reason = ramps ? reasons.active : reasons.any; !reason.empty()) {
    link.publish_state(info.run_id, stillframe_msgs::run_state_t::FAILED, reason);
    throw Refusal(reason);
  }
  require_real_time(policy, link);
  Latch latch = open_latch(options, link, outside.disk);
  return WallClock(options, gains, policy, policy_text, link, latch, outside).serve(start);
}

int run(const Options& options, Outside& outside) {
  if (options.timing) require_place("--timing", *options.timing);
  const Gains gains = read_gains(options.gains);
  std::string policy_text;
  const Policy policy = policy_of(options, gains.sample_rate_hz, policy_text);
  const double radius = require_stable(gains);
  if (!gains.plant_is_as_designed) {
    spdlog::warn(
        "{}: plant: has no hash, as one that `stillframe design` wrote; stability, the force that "
        "a sound loop asks for and what each channel should read are judged by these matrices",
        options.gains.string());
  }
  if (options.check_only) {
    std::printf("spectral radius %.17g\n", radius);
    return exit_done;
  }
  spdlog::info("{}: stable, spectral radius {:.9f}", options.gains.string(), radius);
  const Reasons reasons{.any = refusal_by([&] { force_limit(gains, policy); }),
                        .active = refusal_by([&] { require_stable_ramp(gains); })};
  if (options.rig || options.io != "lcm") {
    return serve_rig(options, gains, policy, policy_text, reasons, outside);
  }
  return serve(options, gains, policy, policy_text, reasons, outside);
}

}  // namespace

int main(int argc, char** argv, Outside& outside) {
  Options options;
  cli::Command app(description);
  app.footer(footer);
  add_options(app, options);
  try {
    if (const auto code = app.parse(argc, argv, exit_done, exit_bad_input)) return *code;
    return run(options, outside);
  } catch (const InputError& error) {
    spdlog::error("{}", error.what());
    return exit_bad_input;
  } catch (const Refusal& error) {
    spdlog::error("refused: {}", error.what());
    return exit_refused;
  } catch (const std::exception& error) {
    spdlog::error("{}", error.what());
    return exit_error;
  }
}

/// A terminal or a disk that hangs does not keep the process.
int main_with_outside(int argc, char** argv) {
  Outside outside;
  log_in_background("controller", outside.terminal);
  set_printable_log("%n: %^%l%$: %*");
  const int code = main(argc, argv, outside);
  const bool written = !outside.disk_hangs && outside.disk.finish(disk_patience_s);
  if (!outside.terminal.finish(terminal_patience_s) || !written) _exit(code);
  return code;
}

}  // namespace stillframe::controller

int main(int argc, char** argv) {
  return stillframe::with_standard_output(
      "controller", [&] { return stillframe::controller::main_with_outside(argc, argv); });
}

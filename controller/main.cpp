#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <exception>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "controller/deadlines.hpp"
#include "controller/gains.hpp"
#include "controller/handshake.hpp"
#include "controller/law.hpp"
#include "controller/lock_step.hpp"
#include "controller/realtime.hpp"
#include "controller/start_check.hpp"
#include "controller/wall_clock.hpp"
#include "core/yaml/input_error.hpp"
#include "msgs/lcm_bus.hpp"
#include "msgs/stop_signal.hpp"

namespace stillframe::controller {

namespace {

constexpr int exit_done = 0, exit_bad_input = 2, exit_refused = 3, exit_failed = 4;

constexpr const char* description =
    "The controller process of a stillframe run. It reads gains, refuses them if the sampled "
    "closed loop\n"
    "is not stable, waits on LCM for a plant that runs the same scene, and answers its "
    "measurements\n"
    "(SF_MEASUREMENT) with piezo forces (SF_COMMAND) until the plant ends the run. Lock-step or\n"
    "wall-clock, sample rate and delay are the plant's to say (SF_RUN_INFO).";

constexpr const char* footer =
    "Examples:\n"
    "  stillframe-controller --gains gains.yaml --check-only\n"
    "  scripts/private_network stillframe-controller --gains gains.yaml --run-id 7 --timeout 30\n"
    "Exit codes: 0 done, 2 bad input, 3 refused (an unstable loop), 4 the run failed or fell back.";

struct Options {
  std::filesystem::path gains;
  std::string lcm_url;
  std::optional<std::int64_t> run_id;
  double timeout_s = 10;
  double phase = 0.5;
  bool realtime = false, check_only = false;
};

void add_options(CLI::App& app, Options& options) {
  app.add_option("--gains", options.gains, "Gains file (YAML), as `stillframe design` writes it")
      ->required()
      ->type_name("FILE");
  app.add_option("--lcm-url", options.lcm_url,
                 "LCM provider (default: the environment's LCM_DEFAULT_URL, or "
                 "udpm://239.255.76.67:7667?ttl=0)")
      ->type_name("URL");
  app.add_option("--run-id", options.run_id, "Run to serve (default: the first that is heard)")
      ->type_name("ID");
  app.add_option("--timeout", options.timeout_s,
                 "Seconds without a word from the plant after which the run has failed")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--phase", options.phase,
                 "Wall-clock mode: when in a sample to wake up, as a part of it from 0 up to 1")
      ->check(CLI::Range(0.0, 0.999))
      ->capture_default_str();
  app.add_flag("--realtime", options.realtime,
               "Ask for SCHED_FIFO and locked memory, and say what was obtained");
  app.add_flag("--check-only", options.check_only,
               "Only check the gains: print the spectral radius of the sampled closed loop");
}

void print_closing_line(const Counters& counters) {
  std::printf(
      "controller: %lld periods, %lld late, %lld lost, worst wake-up %.1f us, worst compute %.1f "
      "us\n",
      static_cast<long long>(counters.n_periods), static_cast<long long>(counters.n_late),
      static_cast<long long>(counters.n_lost), static_cast<double>(counters.worst_wake_up_ns) / 1e3,
      static_cast<double>(counters.worst_compute_ns) / 1e3);
}

int close_run(Outcome outcome, LcmIo& io, const Answer& answer, const Counters& counters,
              double timeout_s) {
  using stillframe_msgs::run_state_t;
  switch (outcome) {
    case Outcome::plant_failed:
      spdlog::error("the plant failed: {}", io.plant_state().text);
      return exit_failed;
    case Outcome::missed:
      spdlog::error("the run had ended before its start was heard");
      return exit_failed;
    case Outcome::silent:
      spdlog::error("nothing heard from the plant for {} s", timeout_s);
      return exit_failed;
    case Outcome::interrupted:
      io.publish_state(io.run_info().run_id, run_state_t::FAILED, "the controller was interrupted");
      spdlog::error("interrupted before the run had ended");
      return exit_failed;
    case Outcome::ended:
      break;
  }
  io.publish_timing(counters);
  print_closing_line(counters);
  if (answer.n_saturated() > 0) {
    spdlog::warn("{} commands were limited by force_limit_n", answer.n_saturated());
  }
  if (answer.n_fallback() == 0) return exit_done;
  spdlog::error("{} commands fell back to zero force, because values were not finite",
                answer.n_fallback());
  return exit_failed;
}

int serve(const Options& options, const Gains& gains) {
  // Before LCM starts its reading thread, which inherits the scheduling.
  if (options.realtime) spdlog::info("real time: {}", request_realtime());
  catch_stop_signals();
  LcmIo io(lcm_url(options.lcm_url));
  Counters counters;
  spdlog::info("waiting for a plant");
  const Start start = shake_hands(io, gains, options.run_id, options.timeout_s);
  const auto& info = io.run_info();
  Answer answer(law_from_gains(gains), gains.force_limit_n, info.loop != "passive");
  if (start.over) return close_run(*start.over, io, answer, counters, options.timeout_s);
  spdlog::info("run {} of {}: {}, {} Hz, {} loop", info.run_id, info.scene_name, info.mode,
               info.sample_rate_hz, info.loop);
  Outcome outcome;
  if (info.mode == "wall_clock") {
    request_fine_timers();
    const Deadlines deadlines(start.start_monotonic_ns, info.sample_rate_hz, options.phase);
    outcome = run_wall_clock(io, answer, deadlines, options.timeout_s, counters);
  } else {
    outcome = run_lock_step(io, answer, options.timeout_s, counters);
  }
  return close_run(outcome, io, answer, counters, options.timeout_s);
}

int run(const Options& options) {
  const Gains gains = read_gains(options.gains);
  const double radius = require_stable(gains);
  if (options.check_only) {
    std::printf("spectral radius %.17g\n", radius);
    return exit_done;
  }
  spdlog::info("{}: stable, spectral radius {:.9f}", options.gains.string(), radius);
  return serve(options, gains);
}

}  // namespace

int main(int argc, char** argv) {
  spdlog::set_default_logger(spdlog::stderr_color_st("controller"));
  spdlog::set_pattern("%n: %^%l%$: %v");
  Options options;
  CLI::App app(description);
  app.footer(footer);
  add_options(app, options);
  try {
    app.parse(argc, argv);
    return run(options);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? exit_done : exit_bad_input;
  } catch (const InputError& error) {
    spdlog::error("{}", error.what());
    return exit_bad_input;
  } catch (const Refusal& error) {
    spdlog::error("refused: {}", error.what());
    return exit_refused;
  } catch (const std::exception& error) {
    spdlog::error("{}", error.what());
    return exit_failed;
  }
}

}  // namespace stillframe::controller

int main(int argc, char** argv) { return stillframe::controller::main(argc, argv); }

#include <pthread.h>
#include <sched.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <cstdio>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <optional>
#include <sstream>
#include <string>

#include "core/cli/command.hpp"
#include "core/control/design/control_loop.hpp"
#include "core/files/printable_log.hpp"
#include "core/files/standard_output.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "msgs/identity.hpp"
#include "msgs/lcm_bus.hpp"
#include "msgs/stop_signal.hpp"
#include "plant_sim/floor/floor_block.hpp"
#include "plant_sim/run_description.hpp"
#include "plant_sim/run_length.hpp"
#include "plant_sim/run_plant.hpp"

namespace stillframe {

namespace {

constexpr int exit_done = 0, exit_error = 1, exit_bad_input = 2, exit_refused = 3, exit_failed = 4;

constexpr const char* description =
    "The plant process of a stillframe run: the nonlinear frame and floor of a scene, integrated "
    "between\n"
    "samples with the piezo forces held. It announces the run on LCM (SF_RUN_INFO), waits for a "
    "controller,\n"
    "publishes what its instruments read (SF_MEASUREMENT) and takes piezo forces (SF_COMMAND).";

constexpr const char* footer =
    "Example, in two terminals of one private network (`stillframe run` does all of it):\n"
    "  stillframe design scene.yaml --out gains.yaml\n"
    "  stillframe-plant scene.yaml --gains gains.yaml --run-id 7\n"
    "  stillframe-controller --gains gains.yaml --run-id 7\n"
    "Exit codes: 0 done, 1 internal error or output that cannot be written, 2 bad input, 3 "
    "refused,\n"
    "(another plant has this number), 4 the run failed.";

struct Options {
  std::filesystem::path scene, gains;
  std::optional<std::filesystem::path> floor, controller, scene_folder, controller_folder,
      floor_folder, pace_by_log;
  std::string mode = "lock_step", loop = "active", lcm_url;
  std::optional<std::int64_t> run_id;
  std::optional<double> duration_s;
  double timeout_s = 10, amplifier_fade_s = 1;
  std::int64_t amplifier_hold_samples = 10;
  std::optional<int> priority;
  bool progress = false;
};

void add_options(cli::Command& app, Options& options) {
  app.option("scene", options.scene, "Scene file (YAML)").required().type_name("SCENE");
  app.option("--gains", options.gains,
             "Gains file that the run announces, as the controller has it")
      .required()
      .type_name("FILE");
  app.option("--controller", options.controller, "Controller block that replaces the scene's")
      .type_name("FILE");
  app.option("--floor", options.floor, "Floor block that replaces the scene's").type_name("FILE");
  app.option("--scene-folder", options.scene_folder,
             "Look here for recordings that the scene names (default: beside it)")
      .type_name("DIR");
  app.option("--controller-folder", options.controller_folder,
             "Look here for the law that the controller block names (default: beside it)")
      .type_name("DIR");
  app.option("--floor-folder", options.floor_folder,
             "Look here for recordings that the floor block names (default: beside it)")
      .type_name("DIR");
  app.option("--mode", options.mode,
             "lock_step: as fast as the machine goes; wall_clock: at the sample rate")
      .check(cli::one_of({"lock_step", "wall_clock"}))
      .show_default();
  app.option("--loop", options.loop, "active, or passive: the controller commands zero force")
      .check(cli::one_of({"active", "passive"}))
      .show_default();
  app.option("--duration", options.duration_s,
             "Seconds of plant time (default: the scene's, or the floor's)")
      .check(cli::positive_number());
  app.option("--run-id", options.run_id,
             "Number that ties the messages of one run together (default: random)")
      .check(cli::positive_number());
  app.option("--lcm-url", options.lcm_url,
             "LCM provider (default: the environment's LCM_DEFAULT_URL, or "
             "udpm://239.255.76.67:7667?ttl=0)");
  app.option("--timeout", options.timeout_s,
             "Seconds without a word from the controller before giving up")
      .check(cli::positive_number())
      .show_default();
  app.option("--amplifier-hold", options.amplifier_hold_samples,
             "Wall-clock: samples without a command for which the amplifiers hold the last one")
      .check(cli::number_from_zero())
      .show_default()
      .type_name("SAMPLES");
  app.option("--amplifier-fade", options.amplifier_fade_s,
             "Wall-clock: seconds in which they then let it go, smoothly")
      .check(cli::positive_number())
      .show_default()
      .type_name("S");
  app.option("--priority", options.priority,
             "Wall-clock: SCHED_FIFO at this priority, if the system allows it: a plant stands "
             "for a machine, which is never late")
      .check(cli::whole_number(1, 98));
  app.option("--pace-by-log", options.pace_by_log,
             "Lock-step: wait whenever the lcm-logger (--flush-interval=1) that writes this "
             "log falls behind, so "
             "that it loses nothing")
      .check(cli::existing_file());
  app.flag("--progress", options.progress,
           "Print 'progress SAMPLE SAMPLES' lines to standard output");
}

// Before LCM starts its reading thread, which inherits it.
void request_fifo(int priority) {
  const sched_param parameters{.sched_priority = priority};
  if (const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters)) {
    spdlog::info("no SCHED_FIFO ({}): the plant may be late", std::strerror(error));
  }
}

int run(const Options& options) {
  const Scene scene =
      read_scene(options.scene, options.controller,
                 {.scene = options.scene_folder, .controller = options.controller_folder});
  require_loop_signals(scene);
  auto floor = read_floor(scene, options.floor);
  if (!floor)
    throw InputError(scene.file + ": the key 'floor' is missing, and no --floor is given");
  if (options.floor_folder) {
    const std::string name = options.floor.value_or(scene.file).string();
    floor->reader = YamlReader::from_text(floor->text, name, *options.floor_folder);
  }
  if (options.mode == "wall_clock" && scene.controller->delay_samples < 1) {
    std::ostringstream found;
    found << scene.controller->delay_samples;
    throw InputError(scene.controller->place + ": delay_samples: found " + found.str() +
                     ", allowed in wall-clock mode is 1 or more: the command of a sample is "
                     "known at the next");
  }
  const auto spec = floor::read_floor_block(floor->reader, scene.controller->sample_rate_hz,
                                            floor_input_names(scene));
  Plant plant(scene, floor::make_floor_source(spec));
  const std::int64_t n = run_length(scene, spec, plant.floor_samples(), options.duration_s);
  spdlog::info("method {}: {}", method_name(plant.choice().method), plant.choice().reason);
  if (options.priority && options.mode == "wall_clock") request_fifo(*options.priority);
  PlantLink link(
      lcm_url(options.lcm_url),
      describe_run(scene, {.run_id = options.run_id.value_or(new_run_id()),
                           .plant_instance = new_instance(),
                           .n_samples = n,
                           .program_version = STILLFRAME_VERSION,
                           .floor_text = floor->text,
                           .gains_text = YamlReader::from_file(options.gains).source_text(),
                           .mode = options.mode,
                           .loop = options.loop}));

  if (options.pace_by_log) link.pace_by(*options.pace_by_log);

  catch_stop_signals();
  ignore_write_signals();
  PlantRunOptions run_options;
  run_options.timeout_s = options.timeout_s;
  run_options.amplifier_hold_samples = options.amplifier_hold_samples;
  run_options.amplifier_fade_s = options.amplifier_fade_s;
  if (options.progress) {
    run_options.progress = [](std::int64_t k, std::int64_t total) {
      std::printf("progress %lld %lld\n", static_cast<long long>(k), static_cast<long long>(total));
      std::fflush(stdout);
    };
  }
  PlantOutcome outcome;
  outcome.reason = await_controller(link, options.timeout_s);
  if (outcome.reason.empty()) {
    outcome = options.mode == "wall_clock" ? run_wall_clock(plant, link, run_options)
                                           : run_lock_step(plant, link, run_options);
  }
  if (plant.n_out_of_range() > 0) {
    spdlog::warn("{} readings of force sensors were out of range, and cut off there",
                 plant.n_out_of_range());
  }
  if (outcome.ended) return exit_done;
  if (!link.rival().empty()) throw Refusal(link.rival());
  spdlog::error("the run did not end as it should: {}", outcome.reason);
  return exit_failed;
}

}  // namespace

int plant_main(int argc, char** argv) {
  cli::Command app(description, "stillframe-plant");
  Options options;
  add_options(app, options);
  app.footer(footer);
  app.version(STILLFRAME_VERSION);
  if (const auto code = app.parse(argc, argv, exit_done, exit_bad_input)) return *code;
  spdlog::set_default_logger(spdlog::stderr_color_mt("plant"));
  set_printable_log("%n: %^%l%$: %*");
  try {
    return run(options);
  } catch (const Refusal& refusal) {
    spdlog::error("{}", refusal.what());
    return exit_refused;
  } catch (const InputError& error) {
    spdlog::error("{}", error.what());
    return exit_bad_input;
  } catch (const std::exception& error) {
    spdlog::error("{}", error.what());
    return exit_error;
  }
}

}  // namespace stillframe

int main(int argc, char** argv) {
  return stillframe::with_standard_output("plant",
                                          [&] { return stillframe::plant_main(argc, argv); });
}

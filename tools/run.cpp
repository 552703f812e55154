#include <ctime>
#include <iostream>
#include <limits>
#include <memory>

#include "controller/policy.hpp"
#include "controller/start_check.hpp"
#include "core/errors/formatted.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "judge/loop_between.hpp"
#include "judge/loop_design.hpp"
#include "judge/page_of.hpp"
#include "msgs/identity.hpp"
#include "msgs/lcm_bus.hpp"
#include "msgs/stop_signal.hpp"
#include "plant_sim/plant.hpp"
#include "plant_sim/run_length.hpp"
#include "report/page/write_page.hpp"
#include "tools/exit_code.hpp"
#include "tools/run/judge.hpp"
#include "tools/run/phase.hpp"
#include "tools/run/run_files.hpp"
#include "tools/run/single_process.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

namespace {

struct RunOptions {
  std::filesystem::path scene;
  std::optional<std::filesystem::path> controller, design_scene, floor, policy, out;
  std::optional<std::string> realtime;
  std::string mode = "lock_step", loop = "both", lcm_url;
  std::optional<double> duration_s;
  std::optional<std::int64_t> run_id;
  double timeout_s = 10;
  bool json = false;
};

std::filesystem::path default_folder(const std::filesystem::path& scene) {
  const std::time_t now = std::time(nullptr);
  char stamp[32];
  std::strftime(stamp, sizeof stamp, "%Y%m%d-%H%M%S", std::localtime(&now));
  return std::filesystem::path("runs") / (scene.stem().string() + "-" + stamp);
}

/// What is to be run. The processes of a run read copies of these texts, in its folder.
struct Checked {
  judge::LoopDesign design;
  floor::FloorSpec spec;
  std::string floor_text;
  std::filesystem::path floor_folder;  ///< of what the floor block names
  std::optional<std::string> controller_text, policy_text;
  RunFiles files;
};

std::filesystem::path folder_of(const std::filesystem::path& file) {
  return file.has_parent_path() ? file.parent_path() : ".";
}

/// The text of a file that has been read before; a pipe gives its text only once.
std::optional<std::string> text_again(const std::filesystem::path& file, const std::string& mode) {
  std::error_code ignored;
  if (std::filesystem::is_regular_file(file, ignored))
    return YamlReader::from_file(file).source_text();
  if (mode == "single_process") return std::nullopt;
  throw InputError(file.string() +
                   ": is no regular file, and is to be read twice; allowed is a file, or --mode "
                   "single_process");
}

/// Where a controller block stands that is not in the scene itself.
std::optional<std::filesystem::path> controller_file(const RunOptions& options,
                                                     const Scene& scene) {
  if (options.controller) return options.controller;
  const auto block = YamlReader::from_text(scene.text, scene.file).find("controller");
  if (!block || !block->is_scalar()) return std::nullopt;
  return folder_of(options.scene) / block->text();
}

std::optional<std::string> controller_text(const RunOptions& options, const Scene& scene) {
  const auto file = controller_file(options, scene);
  if (!file) return std::nullopt;
  auto text = text_again(*file, options.mode);
  const auto& law = scene.controller->law;
  if (text &&
      text_hash(scene.text + scene.bodies_hash + *text + (law ? law->bytes : "")) != scene.hash) {
    throw InputError(file->string() + ": was changed while it was read");
  }
  return text;
}

/// What the processes of a run by the clock would refuse.
void require_clocked(const RunOptions& options, const judge::LoopDesign& design,
                     const controller::Policy& policy) {
  controller::require_clocked_delay(design.gains, design.scene.controller->place);
  controller::force_limit(design.gains, policy);
  if (options.loop != "passive") controller::require_stable_ramp(design.gains);
}

/// What no one refuses, as it depends on the floor: a loop that answers to a push changes its
/// forces faster than its floor asks for, as one that runs away does.
void warn_of_pushes(const RunOptions& options, const Scene& scene,
                    const controller::Policy& policy) {
  if (options.mode != "wall_clock" || options.loop == "passive") return;
  if (policy.free_rate_n_per_s || !judge::has_forces(scene)) return;
  std::cerr << "stillframe: warning: the scene's disturbances push the frame beside its floor, and "
               "no --policy states limits.free_rate_n_per_s: if one makes the loop change a leg's "
               "force faster than the floor and the default leave room for, the loop lets go of "
               "the frame with the latched fault restless (docs/safety.md)\n";
}

/// Everything that a person may have got wrong is found before anything is started or written.
Checked check_input(const RunOptions& options) {
  judge::LoopDesign design =
      judge::make_loop_design(options.scene, options.controller, options.design_scene);
  const double rate_hz = design.gains.sample_rate_hz;
  const controller::Policy policy = options.policy
                                        ? controller::read_policy(*options.policy, rate_hz)
                                        : controller::default_policy(rate_hz);
  controller::require_stable(design.gains);
  if (options.mode == "wall_clock") require_clocked(options, design, policy);
  const auto block = read_floor(design.scene, options.floor);
  if (!block) {
    throw InputError(design.scene.file + ": the key 'floor' is missing, and no --floor is given");
  }
  auto spec = floor::read_floor_block(block->reader, design.gains.sample_rate_hz,
                                      floor_input_names(design.scene));
  RunFiles files(design.scene, spec);
  const Plant plant(design.scene, floor::make_floor_source(spec));
  run_length(design.scene, spec, plant.floor_samples(), options.duration_s);
  auto controller = controller_text(options, design.scene);
  std::optional<std::string> policy_text;
  if (options.policy) policy_text = text_again(*options.policy, options.mode);
  if (options.mode != "single_process") open_lcm(lcm_url(options.lcm_url));
  warn_of_pushes(options, design.scene, policy);
  return {.design = std::move(design),
          .spec = std::move(spec),
          .floor_text = block->text,
          .floor_folder = block->reader.folder(),
          .controller_text = std::move(controller),
          .policy_text = std::move(policy_text),
          .files = std::move(files)};
}

int fail(RunDirectory& directory, const PhaseResult& result) {
  directory.set_failure(result.reason);
  std::cerr << "stillframe: the run failed: " << result.reason << "; what there is lies in "
            << directory.present().string() << "\n";
  return result.exit_code;
}

int run_into(RunDirectory& directory, const RunOptions& options, const Checked& checked) {
  const judge::LoopDesign& design = checked.design;
  RunFiles files = checked.files;
  const auto keep = [&](const std::string& name, const std::string& text) {
    directory.write(name, text);
    files.add(directory / name, text);
    return directory / name;
  };
  PhaseOptions phase{.scene = keep("scene.yaml", design.scene.text),
                     .gains = keep("gains.yaml", to_yaml(design.gains)),
                     .floor = keep("floor.yaml", checked.floor_text),
                     .scene_folder = folder_of(options.scene),
                     .controller_folder =
                         folder_of(controller_file(options, design.scene).value_or(options.scene)),
                     .floor_folder = checked.floor_folder,
                     .controller = {},
                     .mode = options.mode,
                     .loop = "",
                     .lcm_url = lcm_url(options.lcm_url),
                     .run_id = options.run_id.value_or(new_run_id()),
                     .duration_s = options.duration_s,
                     .sample_rate_hz = design.gains.sample_rate_hz,
                     .timeout_s = options.timeout_s,
                     .policy = {},
                     .realtime = options.realtime};
  if (checked.controller_text) phase.controller = keep("controller.yaml", *checked.controller_text);
  if (checked.policy_text) phase.policy = keep("policy.yaml", *checked.policy_text);
  std::vector<judge::LogToAnalyse> logs;
  for (const char* loop : {"passive", "active"}) {
    if (options.loop != "both" && options.loop != loop) continue;
    if (!logs.empty()) ++phase.run_id;  // the last number has no next one
    phase.loop = loop;
    const PhaseResult result =
        options.mode == "single_process"
            ? run_in_process(design, checked.spec, checked.floor_text, phase, directory)
            : run_phase(phase, directory);
    if (const std::string changed = files.changed(); !changed.empty()) {
      const std::string then = result.reason.empty() ? "" : " (" + result.reason + ")";
      return fail(directory, {exit_failed, changed + then, ""});
    }
    if (result.exit_code != exit_done) return fail(directory, result);
    if (!options.json) std::cout << loop << ": " << result.controller_line << "\n";
    logs.push_back({directory / (std::string(loop) + ".lcm"), {.run_id = phase.run_id}});
  }
  const judge::RunAnalyses runs = judge::analyse_runs(std::move(logs));

  report::Verdict verdict;
  try {
    verdict = judge(design, runs, directory);
  } catch (const InputError& error) {
    return fail(directory, {exit_failed, error.what(), ""});
  }
  report::write_json(verdict, directory / "verdict.json");
  directory.write("verdict.txt", report::to_text(verdict));
  page::write_page(judge::page_of(runs, verdict), directory / "report.html");
  directory.finish();
  std::cout << (options.json ? report::to_json(verdict) : report::to_text(verdict));
  if (!options.json) std::cout << "Run directory: " << directory.name().string() << "\n";
  return exit_code_of(verdict.judgement.outcome);
}

int run(const RunOptions& options) {
  const Checked checked = check_input(options);
  catch_stop_signals();
  RunDirectory directory(options.out.value_or(default_folder(options.scene)),
                         options.out ? RunDirectory::Taken::refuse : RunDirectory::Taken::count_on);
  try {
    return run_into(directory, options, checked);
  } catch (const std::exception& error) {
    directory.set_failure(error.what());
    throw;
  }
}

}  // namespace

void add_run(cli::Command& app, int& exit_code) {
  auto options = std::make_shared<RunOptions>();
  cli::Command verb = app.verb(
      "run", "Run plant, controller and logger of a scene, passive and active, and judge the logs");
  verb.option("scene", options->scene, "Scene file (YAML) with controller and floor")
      .required()
      .type_name("SCENE");
  verb.option("--controller", options->controller, "Controller block that replaces the scene's")
      .type_name("FILE");
  verb.option("--design-scene", options->design_scene,
              "Take the gains of this scene's model (same legs) and run them on SCENE")
      .type_name("FILE");
  verb.option("--floor", options->floor, "Floor block that replaces the scene's").type_name("FILE");
  verb.option("--out", options->out,
              "Run directory, which must not be there yet (default: runs/SCENE-DATE-TIME)")
      .type_name("DIR");
  verb.option("--mode", options->mode,
              "lock_step: one command a measurement, as fast as the machine goes; "
              "single_process: the same to the bit in this process, without LCM; "
              "wall_clock: at the sample rate by the clock")
      .check(cli::one_of({"lock_step", "single_process", "wall_clock"}))
      .show_default();
  verb.option("--loop", options->loop, "passive: zero force; active; or both, one after the other")
      .check(cli::one_of({"both", "passive", "active"}))
      .show_default();
  verb.option("--duration", options->duration_s,
              "Seconds of plant time (default: the scene's, or the floor's)")
      .check(cli::positive_number());
  verb.option("--run-id", options->run_id,
              "Number that ties the messages of a run together (default: random; "
              "the second loop has the next one)")
      .check(cli::whole_number(std::int64_t{1}, std::numeric_limits<std::int64_t>::max() - 1))
      .type_name("ID");
  verb.option("--lcm-url", options->lcm_url,
              "LCM provider (default: the environment's LCM_DEFAULT_URL, or "
              "udpm://239.255.76.67:7667?ttl=0)");
  verb.option("--timeout", options->timeout_s, "Seconds of silence after which a run has failed")
      .check(cli::positive_number())
      .show_default();
  verb.option("--policy", options->policy,
              "Wall-clock: fault policy of the controller (YAML, docs/safety.md)")
      .type_name("FILE");
  verb.option("--realtime", options->realtime,
              "Wall-clock: off; best_effort: real-time scheduling as far as the system allows "
              "it; enforce: all of it or no run (default: the policy's)")
      .check(cli::one_of({"off", "best_effort", "enforce"}));
  verb.flag("--json", options->json, "Print the verdict as JSON, as in verdict.json");
  verb.footer(
      "The run directory holds report.html (everything in one file that opens anywhere),\n"
      "passive.lcm and active.lcm (LCM logs), scene.yaml, floor.yaml, gains.yaml (and\n"
      "controller.yaml, policy.yaml if they are files of their own), verdict.json, verdict.txt "
      "and\n"
      "the plots. The run reads these copies; recordings stay where they are, and a run during "
      "which\n"
      "one is changed has failed. In wall-clock mode LOOP_timing.json (histograms) and, after a\n"
      "fault, flight-RUN-N.lcm (the last seconds; `stillframe replay` reads it). Until all is "
      "well\n"
      "it is called DIR.incomplete.\n"
      "Exit code 4: a process failed, or the run did not meet what the scene accepts (its block\n"
      "`accept`, or the defaults of docs/scene.md); a run that shows nothing to judge by is \"not\n"
      "judged\", exit 0.");
  verb.runs([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace stillframe::tools

#include <iostream>
#include <memory>

#include "core/errors/input_error.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "judge/recorded_run.hpp"
#include "plant_sim/floor_motion.hpp"
#include "plant_sim/run_length.hpp"
#include "report/plots/plot_budget.hpp"
#include "tools/budget_text.hpp"
#include "tools/given_files.hpp"
#include "tools/patience.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

namespace {

struct BudgetOptions {
  std::filesystem::path scene;
  std::optional<std::filesystem::path> controller, floor, plot;
  std::vector<std::filesystem::path> logs;
  std::vector<std::string> signals;
  std::optional<double> duration_s;
  double within_percent = 5;
  bool json = false;
};

/// The signals that are asked for, or else what the scene compares on such a floor.
std::vector<judge::ComparedFrame> axes_of(const BudgetOptions& options, const Scene& scene,
                                          const floor::FloorSpec& spec) {
  std::vector<judge::ComparedFrame> axes;
  for (const std::string& name : options.signals) axes.push_back({name, "", name});
  if (!axes.empty()) return axes;
  const auto multisine = judge::multisine_in(spec);
  axes = judge::compared_frames(scene, multisine ? &*multisine : nullptr);
  if (!axes.empty()) return axes;
  for (const SceneSignal& output : scene.outputs) axes.push_back({output.name, "", output.name});
  return axes;
}

std::vector<judge::BudgetRun> runs_of(const BudgetOptions& options, const judge::LoopDesign& design,
                                      const std::string& floor_text,
                                      const std::vector<judge::ComparedFrame>& axes) {
  std::vector<judge::BudgetRun> runs;
  for (const auto& log : options.logs) {
    runs.push_back(judge::budget_run(log, design, floor_text, axes));
    if (runs.back().n_samples != runs.front().n_samples) {
      throw InputError(log.string() + ": found " + std::to_string(runs.back().n_samples) +
                       " samples, allowed are as many as " + runs.front().log.string() + " has, " +
                       std::to_string(runs.front().n_samples));
    }
  }
  return runs;
}

report::BudgetPlot plot_of(const std::string& title, const judge::Budget& budget,
                           const std::vector<judge::BudgetRun>& runs) {
  report::BudgetPlot plot{.title = title, .sources = budget.sources, .panels = {}};
  for (std::size_t i = 0; i < budget.axes.size(); ++i) {
    for (const judge::MethodBudget& one : budget.methods) {
      const judge::SignalBudget& signal = one.axes[i];
      report::BudgetPanel panel{.axis = budget.axes[i].name,
                                .method = judge::name_of(one.method),
                                .total = signal.total.velocity,
                                .measured = {},
                                .sources = {}};
      for (const judge::BudgetPart& part : signal.sources) panel.sources.push_back(part.velocity);
      for (const judge::BudgetRun& run : runs) {
        if (run.method == one.method) panel.measured = run.axes[i].velocity;
      }
      plot.panels.push_back(std::move(panel));
    }
  }
  plot.n_columns = budget.methods.size();
  return plot;
}

int run(const BudgetOptions& options) {
  std::vector<GivenFile> read{{"the scene", options.scene},
                              {"the controller block", options.controller},
                              {"the floor block", options.floor}};
  for (const auto& log : options.logs) read.push_back({"the log", log});
  require_own_places(read, {{"--plot", options.plot}});
  Patience patience("linearising");
  const judge::LoopDesign design = judge::make_loop_design(options.scene, options.controller);
  const auto block = read_floor(design.scene, options.floor);
  if (!block) {
    throw InputError(design.scene.file + ": the key 'floor' is missing, and no --floor is given");
  }
  const floor::FloorSpec spec = floor::read_floor_block(block->reader, design.gains.sample_rate_hz,
                                                        floor_input_names(design.scene));
  judge::BudgetPlan plan{
      .axes = axes_of(options, design.scene, spec),
      .progress = [&](double share) { patience.now("error budget", 100 * share); }};
  patience.now("reading logs");
  const std::vector<judge::BudgetRun> runs = runs_of(options, design, block->text, plan.axes);
  patience.now("error budget");
  plan.n_samples = runs.empty()
                       ? run_length(design.scene, spec, floor::make_floor_source(spec)->n_samples(),
                                    options.duration_s)
                       : runs.front().n_samples;
  const judge::Budget budget = judge::error_budget(design, spec, plan);
  if (options.plot) report::plot_budget(plot_of(design.scene.title, budget, runs), *options.plot);
  const double within = options.within_percent / 100;
  if (options.json) {
    print(budget_json(design.scene.title, budget, runs, within));
  } else {
    std::cout << budget_text(design.scene.title, budget, runs, within);
  }
  for (const judge::BudgetCheck& check : judge::checks_of(budget, runs)) {
    if (!check.met(within)) return exit_failed;
  }
  return exit_done;
}

}  // namespace

void add_budget(cli::Command& app, int& exit_code) {
  auto options = std::make_shared<BudgetOptions>();
  cli::Command verb = app.verb(
      "budget",
      "What each source (floor, forces, sensors) adds to the motion of the frame, passive and by "
      "each law, also against a run");
  verb.option("scene", options->scene, "Scene file (YAML) with controller and floor")
      .required()
      .type_name("SCENE");
  verb.option("--controller", options->controller, "Controller block that replaces the scene's")
      .type_name("FILE");
  verb.option("--floor", options->floor, "Floor block that replaces the scene's").type_name("FILE");
  cli::Option duration = verb.option("--duration", options->duration_s,
                                     "Seconds of plant time (default: the scene's, or the floor's)")
                             .check(cli::positive_number());
  verb.option("--log", options->logs,
              "Hold the budget against this run of SCENE, passive or active; may be given "
              "twice")
      .type_name("LOG")
      .excludes(duration);
  verb.option("--within", options->within_percent,
              "How far a measured rms may be off, in percent of it")
      .check(cli::number_from_zero())
      .show_default();
  verb.option("--signal", options->signals,
              "An output or monitor of the scene (default: the frames that it compares, or "
              "its outputs)")
      .type_name("NAME");
  verb.option("--plot", options->plot,
              "Draw the third octaves of sources, sum and run into a PNG file")
      .type_name("FILE");
  verb.flag("--json", options->json, "Print JSON (keys below)");
  verb.footer(
      "What has a course, as floors and forces, goes through the exact sampled loop from rest over "
      "the\n"
      "samples of the run; noises go through it in the mean square. Axes of one floor are "
      "correlated:\n"
      "shares count what is between two of them half for each, so that they add up "
      "(docs/budget.md)."
      "\n"
      "Keys of --json:\n"
      "  scene, sample_rate_hz, n_samples\n"
      "  left_out     what of the scene is not linear and not in the budget\n"
      "  edges_hz     of the cells of power\n"
      "  bands_hz     of third_octaves_m_s\n"
      "  sources      names, in the order of the table\n"
      "  axes         of each: frame; floor, its own level, null if it has none; methods "
      "(passive,\n"
      "               feedback, feed_forward), and of each: rms_m_s2, share_m2_s4 (of the mean\n"
      "               square), cumulative_rms_m_s2 (up to the end of each cell), shared_m2_s4 "
      "(the\n"
      "               share cell by cell), third_octaves_m_s (rms velocity), scatter_m_s2\n"
      "               (standard deviation of the rms of one run), vibration_class; the same\n"
      "               of `sources`\n"
      "  runs         log, method; of each axis predicted_m_s2, scatter_m_s2, measured_m_s2, met,\n"
      "               third_octaves_m_s, vibration_class\n"
      "Exit code 4: a run is further off than --within and twice the scatter.\n"
      "Example: stillframe budget config/scenes/metrology_frame.yaml --duration 20");
  verb.runs([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace stillframe::tools

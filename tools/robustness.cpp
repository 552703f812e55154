#include <atomic>
#include <iostream>
#include <memory>
#include <optional>
#include <thread>

#include "controller/start_check.hpp"
#include "core/control/robustness/worst_case.hpp"
#include "core/errors/input_error.hpp"
#include "core/mechanics/scene/controller_block.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "judge/aim.hpp"
#include "judge/loop_design.hpp"
#include "report/plots/plot_robustness.hpp"
#include "tools/given_files.hpp"
#include "tools/patience.hpp"
#include "tools/robustness_file.hpp"
#include "tools/robustness_spread.hpp"
#include "tools/robustness_text.hpp"
#include "tools/shard_option.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

using robustness::Evaluator;
using robustness::Measure;
using robustness::Record;
using robustness::Shard;
using robustness::WorstCase;

namespace {

struct RobustnessOptions {
  std::filesystem::path scene;
  std::optional<std::filesystem::path> controller, design_scene, uncertainty, out, from, plot;
  std::uint64_t samples = 1000, seed = 1;
  std::string shard;
  int jobs = 0;
  bool no_search = false, json = false;
};

/// The worst cases in the order of robustness::measures; none if they were not looked for.
using WorstCases = std::vector<WorstCase>;

constexpr const char* worst_keys[] = {"spectral_radius", "least_damping_ratio", "peak"};

SceneUncertainty uncertainty_of(const RobustnessOptions& options, const Scene& scene) {
  if (options.uncertainty) return read_uncertainty(YamlReader::from_file(*options.uncertainty));
  if (scene.uncertainty) return *scene.uncertainty;
  throw InputError(scene.file +
                   ": the key 'uncertainty' is missing; write it, or give --uncertainty FILE");
}

Evaluator evaluator_of(const judge::LoopDesign& design, const SceneUncertainty& uncertainty) {
  const SceneController& controller = *design.scene.controller;
  auto parameters = robustness::parameters_of(design.scene, uncertainty);
  if (parameters.empty()) {
    const std::string place = uncertainty.place.empty() ? design.scene.file : uncertainty.place;
    throw InputError(place +
                     ": uncertainty: nothing of this scene is uncertain; give at least one "
                     "of its values above 0");
  }
  const FeedForward& filter = design.gains.feed_forward.filter;
  return Evaluator({.scene = design.scene,
                    .sampling = design.settings.sampling,
                    .law = filter.empty() ? whole_law_of(design.settings) : law_of(design.settings),
                    .feed_forward = filter,
                    .parameters = std::move(parameters),
                    .frequencies_hz = robustness::outcome_frequencies_hz(
                        judge::lowest_aim_hz(controller), controller.sample_rate_hz)});
}

/// What was asked, nothing sampled yet.
Record empty_record(const RobustnessOptions& options, const judge::LoopDesign& design,
                    const SceneUncertainty& uncertainty, const Evaluator& evaluator) {
  Record record;
  record.scene = design.scene.title;
  record.scene_hash = design.scene.hash;
  if (options.design_scene) {
    record.scene_hash = text_hash(record.scene_hash + read_scene(*options.design_scene).hash);
  }
  record.uncertainty = uncertainty;
  for (const auto& parameter : evaluator.parameters()) {
    record.parameters.push_back(name_of(parameter));
  }
  record.frequencies_hz = evaluator.frequencies_hz();
  record.sample_time = design.settings.sampling.sample_time;
  record.seed = options.seed;
  record.samples = options.samples;
  return record;
}

/// Samples, or takes the samples of a file that must be of the same question.
void fill(const RobustnessOptions& options, const Evaluator& evaluator, Patience& patience,
          Record& record) {
  if (options.from) {
    Record found = read_record(*options.from);
    record.seed = found.seed;
    record.samples = found.samples;
    const std::string differs = difference_between(record, found);
    if (!differs.empty()) {
      throw InputError(options.from->string() + " is not of this scene: they differ in " + differs);
    }
    record = std::move(found);
    return;
  }
  const Shard shard = parse_shard(options.shard);
  record.n_shards = shard.of;
  record.shards = {shard.number};
  record.nominal = evaluator(Eigen::VectorXd::Zero(evaluator.size()));
  const auto n = static_cast<double>(shard.size(options.samples));
  record.tally = run_samples(
      evaluator, {options.seed, options.samples, shard}, options.jobs,
      [&](std::uint64_t done) { patience.now("samples", 100 * static_cast<double>(done) / n); });
}

WorstCases search(const RobustnessOptions& options, const Evaluator& evaluator,
                  const Record& record, Patience& patience) {
  WorstCases found;
  for (const Measure measure : robustness::measures) {
    std::vector<Eigen::VectorXd> starts;
    for (const auto& sample : record.tally.worst[static_cast<size_t>(measure)]) {
      starts.push_back(sample.values);
    }
    found.push_back(search_worst(evaluator, measure, starts, options.jobs, [&](std::uint64_t done) {
      patience.now("worst case: evaluation " + std::to_string(done));
    }));
  }
  return found;
}

void print_json(const Record& record, const WorstCases& worst, const Evaluator& evaluator) {
  Json document = to_json(record);
  const BadShare share = bad_share(record.tally);
  document["unstable_share"] = share.found;
  document["unstable_share_below"] = share.below;
  document["worst_found"] = Json();
  for (size_t m = 0; m < worst.size(); ++m) {
    Json entry = to_json(worst[m].outcome);
    entry["n_evaluations"] = worst[m].evaluations;
    entry["stable_part"] = worst[m].stable_part;
    for (const auto& [kind, outcome] : worst[m].without) {
      entry["without"][robustness::kind_text(kind)] = to_json(outcome);
    }
    entry["values"] = to_json(worst[m].values);
    entry["deviations"] = Json::array();
    for (size_t i = 0; i < record.parameters.size(); ++i) {
      entry["deviations"].push_back(
          describe(evaluator.parameters()[i], worst[m].values(static_cast<Eigen::Index>(i))));
    }
    document["worst_found"][worst_keys[m]] = entry;
  }
  print(document);
}

void print_page(const Record& record, const WorstCases& worst, const Evaluator& evaluator) {
  std::cout << page_of(record);
  if (worst.empty()) return;
  std::cout << "\nThe worst plants that a search of the corners found; there may be worse ones.\n";
  for (const Measure measure : robustness::measures) {
    std::cout << page_of(worst[static_cast<size_t>(measure)], measure, evaluator.parameters());
  }
}

void plot(const Record& record, const WorstCases& worst, const Evaluator& evaluator,
          const std::filesystem::path& path) {
  const robustness::Tally& tally = record.tally;
  std::vector<Eigen::VectorXd> drawn{Eigen::VectorXd::Zero(evaluator.size())};
  if (!worst.empty()) {
    const WorstCase& highest = worst[static_cast<size_t>(Measure::peak)];
    if (highest.outcome.verdict == robustness::Outcome::Verdict::stable) {
      drawn.push_back(highest.values);
    }
  }
  const Spread spread(record);
  const Eigen::VectorXd frequencies = frequencies_of(evaluator, drawn, spread);
  report::RobustnessPlot picture;
  picture.title = record.scene + ": floor to frame on plants that differ from the model";
  picture.frequencies_hz.assign(frequencies.begin(), frequencies.end());
  picture.nominal = evaluator.curve(drawn.front(), frequencies, false).gain;
  if (drawn.size() > 1) picture.worst = evaluator.curve(drawn.back(), frequencies, false).gain;
  if (tally.n_stable > 0) {
    picture.low = spread.low(frequencies);
    picture.high = spread.high(frequencies);
    picture.most = spread.most(frequencies);
  }
  picture.nominal_damping = record.nominal.damping;
  const DampingBars bars = damping_bars(tally, record.nominal.damping);
  picture.damping_width = bars.width;
  for (const auto& [from, share] : bars.shares) picture.damping.push_back({from, share});
  report::plot_robustness(picture, path);
}

int run(RobustnessOptions options) {
  if (options.jobs == 0)
    options.jobs = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  require_own_places({{"the scene", options.scene},
                      {"the controller block", options.controller},
                      {"the design scene", options.design_scene},
                      {"the uncertainty block", options.uncertainty},
                      {"the record", options.from}},
                     {{"--out", options.out}, {"--plot", options.plot}});
  parse_shard(options.shard);
  Record record;
  WorstCases worst;
  std::optional<Evaluator> evaluator;
  {
    Patience patience("linearising");
    const judge::LoopDesign design =
        judge::make_loop_design(options.scene, options.controller, options.design_scene);
    const SceneUncertainty uncertainty = uncertainty_of(options, design.scene);
    controller::require_stable(design.gains);
    evaluator = evaluator_of(design, uncertainty);
    record = empty_record(options, design, uncertainty, *evaluator);
    fill(options, *evaluator, patience, record);
    if (options.out) write_record(record, *options.out);
    if (!options.no_search && options.shard.empty()) {
      worst = search(options, *evaluator, record, patience);
    }
    if (options.plot) plot(record, worst, *evaluator, *options.plot);
  }
  options.json ? print_json(record, worst, *evaluator) : print_page(record, worst, *evaluator);
  return exit_done;
}

constexpr const char* robustness_footer =
    "The gains stay those of the scene as it is; the plant varies within the scene's uncertainty\n"
    "block (docs/scene.md), or that of --uncertainty FILE, which has the same keys:\n"
    "  stiffness: 0.1            # of each leg, +-10 %\n"
    "  actuator_gain: 0.05       # force that acts over force that is reported, of each leg\n"
    "  delay_samples: 0.3        # of all commands\n"
    "config/uncertainty/piezo_frame.yaml has them all. Each parameter is drawn evenly, one by "
    "one.\n"
    "The page shows how many plants are unstable, how T (largest singular value, floor to frame)\n"
    "spreads over frequency, and the worst plants that were sampled and that a search of the "
    "corners\n"
    "of the box found. That search gives a lower bound: there may be a worse plant.\n"
    "\n"
    "Sample i is a function of the seed and i alone, so samples can be shared out. On a cluster,\n"
    "after `sbatch --array=1-100`, each task runs\n"
    "  stillframe robustness SCENE --samples 1000000 --shard ${SLURM_ARRAY_TASK_ID}/100 \\\n"
    "    --out part_${SLURM_ARRAY_TASK_ID}.json\n"
    "With GNU parallel, over the machines of a list that share this folder:\n"
    "  seq 100 | parallel --sshloginfile hosts --workdir . -j1 \\\n"
    "    stillframe robustness SCENE --samples 1000000 --shard {}/100 --out part_{}.json\n"
    "Then\n"
    "  stillframe merge part_*.json --out all.json\n"
    "  stillframe robustness SCENE --from all.json --plot all.png\n"
    "A shard alone is not searched for the worst case; the last line does that.\n"
    "\n"
    "Keys of --json, and of the file of --out (to the first blank line):\n"
    "  format, version, scene, scene_hash, uncertainty, seed, n_samples, shards (n_shards, done)\n"
    "  sample_time_s, frequencies_hz, parameters (names), nominal (no deviation)\n"
    "  counts (stable, unstable, failed), failures (how many by why)\n"
    "  extremes [least, most] and histograms (width of a bin, first_bin, counts) of "
    "spectral_radius,\n"
    "    least_damping_ratio (by the logarithm of its size), peak, largest_singular_values at "
    "each\n"
    "    frequency, highest_singular_values with the resonances next to it; bin k is k to k + 1\n"
    "    widths\n"
    "  worst_samples by each measure: index, values (-1 to 1 for each parameter)\n"
    "\n"
    "  unstable_share, unstable_share_below (with a confidence of 95 %)\n"
    "  worst_found by each measure: values, deviations (in words), stable_part (of them, up to "
    "which\n"
    "    the loop is stable), without (what becomes of it with one kind of parameters at 0)\n"
    "Exit code 0 whatever the plants do; 3 if the loop is not even stable on the scene as it is.\n"
    "Example: stillframe robustness config/scenes/metrology_frame.yaml \\\n"
    "  --uncertainty config/uncertainty/piezo_frame.yaml --plot robustness.png";

}  // namespace

void add_robustness(cli::Command& app, int& exit_code) {
  auto options = std::make_shared<RobustnessOptions>();
  cli::Command verb =
      app.verb("robustness",
               "What a loop does on plants that differ from the scene: samples and worst case");
  verb.option("scene", options->scene, "Scene file (YAML) with a controller block")
      .required()
      .type_name("SCENE");
  verb.option("--controller", options->controller, "Controller block that replaces the scene's")
      .type_name("FILE");
  verb.option("--design-scene", options->design_scene,
              "Take the gains of this scene's model (same legs); the plant is SCENE")
      .type_name("FILE");
  verb.option("--uncertainty", options->uncertainty, "Uncertainty block that replaces the scene's")
      .type_name("FILE");
  cli::Option samples =
      verb.option("--samples", options->samples, "Number of samples, of all shards together")
          .check(cli::whole_number(0LL, 1000000000000LL))
          .type_name("N")
          .show_default();
  cli::Option seed = verb.option("--seed", options->seed, "Seed of the samples")
                         .check(cli::whole_number(0LL, 1000000000000LL))
                         .type_name("S")
                         .show_default();
  cli::Option shard =
      verb.option("--shard", options->shard,
                  "Only the samples whose index leaves I - 1 when divided by N, I from 1")
          .type_name("I/N");
  verb.option("--jobs", options->jobs, "Threads; 0: one for each core. Changes no result")
      .check(cli::whole_number(0, 1024))
      .type_name("J")
      .show_default();
  cli::Option out =
      verb.option("--out", options->out, "Write the samples' record (JSON)").type_name("FILE");
  verb.option("--from", options->from, "Take the samples from a record instead")
      .type_name("FILE")
      .excludes(samples)
      .excludes(seed)
      .excludes(shard)
      .excludes(out);
  verb.flag("--no-search", options->no_search, "Do not search for the worst case");
  verb.option("--plot", options->plot, "Draw the spread of T and of the damping into a PNG file")
      .type_name("FILE");
  verb.flag("--json", options->json, "Print JSON (keys below)");
  verb.footer(robustness_footer);
  verb.runs([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace stillframe::tools

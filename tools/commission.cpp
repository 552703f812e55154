#include <algorithm>
#include <cmath>
#include <future>
#include <iostream>
#include <memory>
#include <optional>

#include "controller/policy.hpp"
#include "controller/realtime.hpp"
#include "controller/rig/simulated_io.hpp"
#include "core/errors/input_error.hpp"
#include "core/files/whole_file.hpp"
#include "core/mechanics/scene/controller_block.hpp"
#include "judge/loop_design.hpp"
#include "msgs/stop_signal.hpp"
#include "report/plots/plot_fit.hpp"
#include "report/table.hpp"
#include "tools/commission_rig.hpp"
#include "tools/given_files.hpp"
#include "tools/json.hpp"
#include "tools/patience.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

namespace {

using controller::RigFile;

struct CommissionOptions {
  std::filesystem::path scene;
  std::optional<std::filesystem::path> rig, controller, uncertainty, simulate, plot;
  std::string io;
  std::optional<double> force_n;
  double window_s = 2;
  int windows = 5;
  bool json = false;
};

/// Beside a file, under its name with ".updated".
std::filesystem::path updated(const std::filesystem::path& path, const std::string& ending) {
  return path.parent_path() / (path.stem().string() + ending);
}

SceneUncertainty uncertainty_of(const CommissionOptions& options, const Scene& scene) {
  if (options.uncertainty) return read_uncertainty(YamlReader::from_file(*options.uncertainty));
  if (scene.uncertainty) return *scene.uncertainty;
  throw InputError(scene.file +
                   ": the key 'uncertainty' is missing, which says what is to be found and how "
                   "well it is known; write it, or give --uncertainty FILE");
}

/// The scene's text with a block behind it.
std::string with_block(std::string text, const std::string& block) {
  if (!text.ends_with('\n')) text += '\n';
  return text + "\n# Measured on the rig; without this block the scene is as it was written.\n" +
         block;
}

/// The rig of a scene that plays one: all that the scene has is measured.
RigFile simulated_rig(const judge::LoopDesign& design) {
  RigFile rig = controller::default_rig(design.gains);
  for (const SceneSignal& output : design.scene.outputs) {
    rig.channels.frame.push_back({.number = static_cast<Eigen::Index>(rig.frame.size())});
    rig.frame.push_back(output.name);
  }
  rig.floor.clear();
  rig.channels.floor.clear();
  return rig;
}

/// The loops that the gains of before and those of the updated scene make on what was found.
struct Loops {
  double before = 0, after = 0;  ///< spectral radii
};

struct Files {
  std::filesystem::path scene, rig, uncertainty;
};

Json to_json(const Commissioned& found, const std::optional<Files>& files,
             const std::optional<Loops>& loops, const CommissionOptions& options, bool passed) {
  Json wrong = Json::array();
  for (const auto& leg : found.wiring.legs) {
    for (const std::string& what : leg.wrong) wrong.push_back({{"leg", leg.leg}, {"what", what}});
  }
  Json parameters = Json::array(), outputs = Json::array();
  for (std::size_t i = 0; files && i < found.question.parameters.size(); ++i) {
    const auto& parameter = found.question.parameters[i];
    Json with = Json::array();
    for (const std::size_t other : alike(found, i)) {
      with.push_back(name_of(found.question.parameters[other]));
    }
    parameters.push_back({{"name", name_of(parameter)},
                          {"deviation", found_deviation(found, i)},
                          {"standard_deviation", found_doubt(found, i)},
                          {"known_before", known_before(found, i)},
                          {"told", is_told(found, i)},
                          {"alike", with}});
  }
  const auto& legs = found.question.scene.controller->legs;
  for (Eigen::Index i = 0; i < found.fit.left.size(); ++i) {
    const auto m = static_cast<Eigen::Index>(legs.size());
    const std::string name =
        i < 2 * m ? (i < m ? "sigma " : "applied ") + legs[static_cast<std::size_t>(i % m)]
                  : found.rig.frame[static_cast<std::size_t>(i - 2 * m)];
    outputs.push_back(
        {{"name", name}, {"left_before", found.fit.left_before(i)}, {"left", found.fit.left(i)}});
  }
  return {{"scene", found.question.scene.title},
          {"wrong", wrong},
          {"connected", found.wiring.connected},
          {"clock_ppm", files ? Json(-1e6 * found.recording.drift) : Json()},
          {"n_samples", found.recording.n_samples},
          {"n_lost", found.recording.n_lost},
          {"parameters", parameters},
          {"outputs", outputs},
          {"over_noise", files ? Json(found.fit.over_noise) : Json()},
          {"converged", found.fit.converged},
          {"spectral_radius_before", loops ? Json(loops->before) : Json()},
          {"spectral_radius", loops ? Json(loops->after) : Json()},
          {"scene_file", files ? Json(files->scene.string()) : Json()},
          {"rig_file", files && options.rig ? Json(files->rig.string()) : Json()},
          {"uncertainty_file", files ? Json(files->uncertainty.string()) : Json()},
          {"passed", passed}};
}

void print_wiring(const Commissioned& found) {
  for (const auto& leg : found.wiring.legs) {
    for (const std::string& what : leg.wrong) std::cout << leg.leg << ": " << what << "\n";
  }
  if (found.wiring.sound) std::cout << "Every leg answers as the rig file and the scene say.\n";
  if (!found.wiring.sound && found.wiring.connected)
    std::cout
        << "Cables and signs are put right for what follows, and gains that are off by more than "
           "half; the rest is for the fit.\n";
}

std::string with_unit(const robustness::Parameter& parameter, double deviation) {
  return deviation_text(parameter, deviation / parameter.size);
}

void print_page(const Commissioned& found, const Files& files, const Loops& loops,
                const CommissionOptions& options) {
  const auto& parameters = found.question.parameters;
  std::cout << report::cell(
      "\n%lld samples, %lld lost, clock %+.1f ppm; driven, the least output "
      "reads %.0f dB more than at rest\n\n",
      report::count(found.recording.n_samples), report::count(found.recording.n_lost),
      -1e6 * found.recording.drift, found.disturbance_db);
  report::Table table({"what", "", "found", "+- (95 %)", "known before"}, 2);
  bool trade = false, told = false;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const auto others = alike(found, i);
    std::string note;
    if (others.size() == 1) note = "or " + name_of(parameters[others[0]]);
    if (others.size() > 1) note = report::cell("or with %zu others", others.size());
    if (!is_told(found, i)) note = "not told" + (note.empty() ? "" : ", " + note);
    const auto without_sign = [&](double deviation) {
      return with_unit(parameters[i], deviation).substr(1);
    };
    trade = trade || !others.empty();
    told = told || is_told(found, i);
    table.add({name_of(parameters[i]), note, with_unit(parameters[i], found_deviation(found, i)),
               without_sign(1.96 * found_doubt(found, i)), without_sign(known_before(found, i))});
  }
  const auto& fit = found.fit;
  std::cout << table.print();
  if (trade) {
    std::cout
        << "or ...: this rig tells both together rather than each (--json has all names). All "
           "forces, masses\nand stiffnesses times one number are the same to force sensors "
           "and accelerometers.\n";
  }
  std::cout << report::cell("\nWhat is left is %.2f times the power of the noise at rest.\n",
                            fit.over_noise);
  if (!fit.is_noise()) {
    std::cout << "The rig does something that no value of these parameters does: do not trust the "
                 "bands.\n";
  }
  if (!told) std::cout << "The rig tells nothing of what was asked.\n";
  if (!fit.converged) std::cout << "The fit has not settled.\n";
  std::cout << report::cell(
                   "Spectral radius on what was found: %.6f with the gains of before, "
                   "%.6f with those of the updated scene.\n",
                   loops.before, loops.after)
            << "Written: " << files.scene.string() << ", " << files.uncertainty.string();
  if (options.rig) std::cout << ", " << files.rig.string();
  std::cout << "\nNext: stillframe design " << files.scene.string() << " --out gains.yaml, and\n"
            << "  stillframe robustness " << files.scene.string() << " --uncertainty "
            << files.uncertainty.string() << "\n";
}

void draw(const Commissioned& found, const std::filesystem::path& path) {
  report::FitPlot plot{.title = found.question.scene.title, .frequencies_hz = {}, .legs = {}};
  const double window_s = static_cast<double>(found.n_window) * found.question.sampling.sample_time;
  plot.frequencies_hz.resize(static_cast<Eigen::Index>(found.lines.size()));
  std::ranges::transform(found.lines, plot.frequencies_hz.begin(),
                         [&](int line) { return line / window_s; });
  const auto& legs = found.question.scene.controller->legs;
  for (std::size_t i = 0; i < legs.size(); ++i) {
    const fitting::LegResponse& leg = found.fit.legs[i];
    plot.legs.push_back(
        {legs[i], leg.measured.cwiseAbs(), leg.fitted.cwiseAbs(), leg.before.cwiseAbs()});
  }
  plot_fit(plot, path);
}

/// The plant that --simulate plays the rig by.
SampledPlant played(const CommissionOptions& options, const judge::LoopDesign& design) {
  const judge::LoopDesign hidden = judge::make_loop_design(*options.simulate, options.controller);
  const std::string name = options.simulate->string();
  if (hidden.scene.controller->legs != design.scene.controller->legs) {
    throw InputError(name + ": has other legs than the scene");
  }
  if (!std::ranges::equal(hidden.scene.outputs, design.scene.outputs, {}, &SceneSignal::name,
                          &SceneSignal::name)) {
    throw InputError(name + ": has other outputs than the scene, or in another order");
  }
  if (hidden.gains.sample_rate_hz != design.gains.sample_rate_hz) {
    throw InputError(name + ": has another sample rate than the scene");
  }
  return hidden.sampled;
}

Commissioned measured(const CommissionOptions& options, const judge::LoopDesign& design,
                      const RigFile& rig, const Progress& progress) {
  const CommissionQuestion question{
      .design = design,
      .uncertainty = uncertainty_of(options, design.scene),
      .force_n = probe_force(options.force_n, design.gains, options.scene),
      .window_s = options.window_s,
      .n_windows = options.windows};
  if (!options.simulate && rig.driver.empty()) {
    throw InputError("no driver: name one in a rig file or with --io, or play with --simulate");
  }
  std::optional<SampledPlant> plant;
  if (options.simulate) plant = played(options, design);
  catch_stop_signals();
  // As the loop that will stand here: what measures, and the threads of its driver, wait behind
  // nobody; what computes afterwards has no such right.
  auto thread = std::async(std::launch::async, [&] {
    controller::prepare_thread(controller::default_policy(design.gains.sample_rate_hz).priority,
                               std::nullopt);
    const auto go = [&](controller::Io& io) {
      return measure(io, rig, question, controller::real_time(), progress, stop_requested);
    };
    if (plant) {
      controller::SimulatedIo io(*plant);
      return go(io);
    }
    const controller::DriverSetting setting = rig.setting(design.gains);
    const controller::LoadedIo io = controller::load_driver(rig.driver, setting);
    return go(*io);
  });
  try {
    return thread.get();
  } catch (const InputError&) {
    throw;
  } catch (const Refusal&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw Failure(std::string("the rig could not be measured: ") + error.what());
  }
}

int run(const CommissionOptions& options) {
  if (options.simulate && (options.rig || !options.io.empty())) {
    throw InputError("--simulate plays the rig: leave the rig file and --io out");
  }
  const judge::LoopDesign design = judge::make_loop_design(options.scene, options.controller);
  if (YamlReader::from_file(options.scene).find("corrections")) {
    throw InputError(options.scene.string() +
                     ": corrections: are there already; commission the scene as it was written, "
                     "or write them into it");
  }
  try {
    YamlReader::from_text(with_block(design.scene.text, "corrections: {}\n"), "");
  } catch (const InputError&) {
    throw InputError(options.scene.string() +
                     ": a block cannot be written behind it; write its keys a line each, without "
                     "'...' at the end");
  }
  RigFile rig =
      options.rig ? controller::read_rig(*options.rig, design.gains) : simulated_rig(design);
  if (!options.io.empty()) rig.driver = options.io;
  const Files files{updated(options.scene, ".updated.yaml"),
                    options.rig ? updated(*options.rig, ".updated.yaml") : std::filesystem::path(),
                    updated(options.scene, ".updated.uncertainty.yaml")};
  require_own_places(
      {{"the scene", options.scene},
       {"the rig file", options.rig},
       {"--controller", options.controller},
       {"--uncertainty", options.uncertainty},
       {"--simulate", options.simulate}},
      {{"the updated scene", files.scene}, {"the uncertainty that is left", files.uncertainty}});
  Commissioned found = [&] {
    Patience patience("wiring");
    const auto progress = [&](const std::string& what, double done) {
      patience.now(what, 100 * done);
    };
    Commissioned all = measured(options, design, rig, progress);
    if (all.wiring.connected) fit_recording(all, progress);
    return all;
  }();
  if (!options.json) print_wiring(found);
  if (!found.wiring.connected) {
    if (options.json)
      print(to_json(found, {}, {}, options, false));
    else
      std::cout << "No rig file can put all of it right: nothing else was done.\n";
    return exit_failed;
  }
  std::string text = design.scene.text;
  if (!text.ends_with('\n')) text += '\n';
  write_whole_file(files.scene, text +
                                    "\n# Measured on the rig; without this block the scene is "
                                    "as it was written.\n" +
                                    corrections_block(found));
  write_whole_file(files.uncertainty,
                   "# What is left to doubt of " + files.scene.filename().string() +
                       ": two standard deviations of the least known.\n" + uncertainty_left(found));
  if (options.rig) write_whole_file(files.rig, to_yaml(found.rig, design.gains));
  if (options.plot) draw(found, *options.plot);
  const Loops loops{judge::make_loop_design(files.scene, options.controller, options.scene).radius,
                    judge::make_loop_design(files.scene, options.controller).radius};
  bool anything_told = false;
  for (std::size_t i = 0; i < found.question.parameters.size(); ++i) {
    anything_told = anything_told || is_told(found, i);
  }
  const bool passed =
      anything_told && found.fit.converged && loops.after < 1 && found.fit.is_noise();
  if (options.json) {
    print(to_json(found, files, loops, options, passed));
  } else {
    print_page(found, files, loops, options);
  }
  return passed ? exit_done : exit_failed;
}

}  // namespace

void add_commission(cli::Command& app, int& exit_code) {
  auto options = std::make_shared<CommissionOptions>();
  cli::Command verb = app.verb(
      "commission", "Measure a rig before its loop is closed, and correct the scene by it");
  verb.option("scene", options->scene, "Scene with a controller").required().type_name("SCENE");
  verb.option("rig", options->rig, "Rig file (docs/hardware.md)").type_name("RIG");
  verb.option("--controller", options->controller, "Controller block that replaces the scene's")
      .type_name("FILE");
  verb.option("--uncertainty", options->uncertainty,
              "What the scene is known to (default: the scene's own block)")
      .type_name("FILE");
  verb.option("--io", options->io, "Driver (default: the rig file's)").type_name("NAME");
  verb.option("--simulate", options->simulate,
              "Play the rig by another scene of the same legs, all of whose outputs are measured")
      .type_name("SCENE");
  verb.option("--force", options->force_n,
              "N, peak of the force on a leg (default: 2 % of the force limit)")
      .check(cli::positive_number());
  verb.option("--window", options->window_s,
              "s, one period of what a leg is driven by (default: 2)")
      .check(cli::positive_number());
  verb.option("--windows", options->windows,
              "Periods that are recorded of each leg, and twice as many at rest (default: 5)")
      .check(cli::whole_number(2, 1000));
  verb.option("--plot", options->plot, "PNG: what each leg answers, measured, fitted and before")
      .type_name("FILE");
  verb.flag("--json", options->json, "Print JSON (keys below)");
  verb.footer(
      "First the wiring, as `rig` finds it, and puts it right for what follows. Then one leg after "
      "the\n"
      "other is driven by a multisine from 2 / window to 0.42 of the sample rate, but for the "
      "model's own\n"
      "resonances, and what all force sensors, read-backs and accelerometers answer is fitted: of "
      "every\n"
      "parameter that the uncertainty names, its value and how well it is known now "
      "(docs/hardware.md).\n"
      "Written beside the scene: SCENE.updated.yaml, the scene with a block of corrections, and\n"
      "SCENE.updated.uncertainty.yaml; beside the rig file RIG.updated.yaml, with cables, signs "
      "and gains.\n"
      "No loop is closed. The rig is let go of beyond ten times the force, and at Ctrl-C.\n"
      "Exit codes: 0 something is told, fitted to the noise, and the loop of the updated scene is "
      "stable; 4 not, or "
      "the rig\n"
      "could not be measured.\n"
      "Keys of --json:\n"
      "  scene, wrong (leg, what), connected, clock_ppm, n_samples, n_lost\n"
      "  parameters   {name, deviation, standard_deviation, known_before (relative, m, rad or "
      "samples), told,\n"
      "               alike (names of those it could trade places with)}\n"
      "  outputs      {name, left_before, left (of what was read, rms)}\n"
      "  over_noise (power of what is left over that of the noise at rest), converged,\n"
      "  spectral_radius_before, spectral_radius, scene_file, rig_file, uncertainty_file, passed\n"
      "Example: stillframe commission frame.yaml rig.yaml --uncertainty piezo_frame.yaml\n"
      "To try it without a rig: stillframe commission frame.yaml --simulate other_frame.yaml");
  verb.runs([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace stillframe::tools

#include <algorithm>
#include <cmath>
#include <ctime>
#include <exception>
#include <filesystem>
#include <future>
#include <iostream>
#include <memory>
#include <optional>

#include "controller/policy.hpp"
#include "controller/realtime.hpp"
#include "controller/rig/scaled_io.hpp"
#include "controller/rig/simulated_io.hpp"
#include "controller/start_check.hpp"
#include "core/errors/input_error.hpp"
#include "core/files/whole_file.hpp"
#include "core/mechanics/scene/controller_block.hpp"
#include "judge/loop_design.hpp"
#include "judge/page_tables_of.hpp"
#include "msgs/stop_signal.hpp"
#include "report/page/write_page.hpp"
#include "report/plots/plot_fit.hpp"
#include "tools/commission_text.hpp"
#include "tools/given_files.hpp"
#include "tools/patience.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

namespace {

using controller::RigFile;

using Eigen::Index;

struct CommissionOptions {
  std::filesystem::path scene;
  std::optional<std::filesystem::path> rig, controller, uncertainty, simulate, policy, plot, report;
  std::string io, until = "scene";
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

/// The rig of a scene that plays one: accelerometers are all outputs of the scene, and what of the
/// floor its law hears.
RigFile simulated_rig(const judge::LoopDesign& design) {
  RigFile rig = controller::default_rig(design.gains);
  for (const SceneSignal& output : design.scene.outputs) {
    rig.channels.frame.push_back({.number = static_cast<Eigen::Index>(rig.frame.size())});
    rig.frame.push_back(output.name);
  }
  return rig;
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

/// The Io of a rig, from the first measurement to the last of the loop.
class Rig {
 public:
  Rig(const CommissionOptions& options, const judge::LoopDesign& design, const RigFile& file)
      : file_(file), setting_(file.setting(design.gains)) {
    if (options.simulate) plant_ = played(options, design);
    priority_ = controller::default_policy(design.gains.sample_rate_hz).priority;
  }

  /// Does something with it as the loop does that will stand here: what measures, and the threads
  /// of its driver, wait behind nobody; what computes afterwards has no such right.
  template <class Measure>
  auto with(Measure measure) {
    auto thread = std::async(std::launch::async, [&] {
      controller::prepare_thread(priority_, std::nullopt);
      if (!simulated_ && plant_) simulated_.emplace(*plant_);
      if (!loaded_ && !plant_) loaded_.emplace(controller::load_driver(file_.driver, setting_));
      controller::Io& io = plant_ ? static_cast<controller::Io&>(*simulated_) : **loaded_;
      return measure(io);
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

 private:
  const RigFile& file_;
  controller::DriverSetting setting_;
  std::int64_t priority_ = 0;
  std::optional<SampledPlant> plant_;
  std::optional<controller::SimulatedIo> simulated_;
  std::optional<controller::LoadedIo> loaded_;
};

void draw(const Commissioning& all, const std::filesystem::path& path) {
  const judge::Commissioned& found = *all.found;
  report::FitPlot plot{.title = all.title,
                       .left_label = "force sensor over actuator (dB)",
                       .fitted = "updated scene",
                       .other = "scene as it was",
                       .frequencies_hz = {},
                       .panels = {}};
  const double window_s = static_cast<double>(found.n_window) * found.question.sampling.sample_time;
  plot.frequencies_hz.resize(static_cast<Index>(found.lines.size()));
  std::ranges::transform(found.lines, plot.frequencies_hz.begin(),
                         [&](int line) { return line / window_s; });
  for (std::size_t i = 0; i < all.legs.size(); ++i) {
    const fitting::LegResponse& leg = found.fit.legs[i];
    plot.panels.push_back(
        {all.legs[i], leg.measured.cwiseAbs(), leg.fitted.cwiseAbs(), leg.before.cwiseAbs()});
  }
  plot_fit(plot, path);
}

/// By which a loop is closed. Errors: as read_policy; Refusal without a force limit.
controller::Policy policy_of(const CommissionOptions& options, const controller::Gains& gains) {
  controller::Policy policy = options.policy
                                  ? controller::read_policy(*options.policy, gains.sample_rate_hz)
                                  : controller::default_policy(gains.sample_rate_hz);
  policy.start_at_once = true;
  if (policy.excitation.kind != controller::ExcitationPlan::Kind::none) {
    throw InputError(policy.excitation.place +
                     ": excitation: found one, allowed is none: commission has its own");
  }
  const double limit = controller::force_limit(gains, policy);
  const double force = controller::probe_force(options.force_n, gains, options.scene);
  if (!(force < limit)) {
    throw InputError("--force: found " + shortest_digits(force) +
                     ", allowed is below the force limit of " + shortest_digits(limit));
  }
  return policy;
}

/// Closes the loop of the gains that the design has, and holds it against its prediction.
ClosedOnRig closed(Rig& rig, const CommissionOptions& options, const judge::LoopDesign& design,
                   const RigFile& file, double force_n,
                   const std::function<void(double)>& progress) {
  controller::Policy policy = policy_of(options, design.gains);
  policy.excitation = {.kind = controller::ExcitationPlan::Kind::multisine,
                       .window_s = options.window_s,
                       .windows = options.windows};
  policy.excitation.force_n = judge::added_force(force_n, design, policy);
  ClosedOnRig all{.run = rig.with([&](controller::Io& io) {
    controller::ScaledIo scaled(io, file.channels);
    auto run = controller::close_on_rig(scaled, design.gains, policy,
                                        static_cast<Index>(file.channels.floor.size()),
                                        static_cast<Index>(file.channels.frame.size()),
                                        controller::real_time(), progress, stop_requested);
    judge::require_motion(run.recording, run.n_window, design.gains.sample_rate_hz,
                          design.gains.legs, file);
    return run;
  })};
  all.responses = judge::closed_responses(all.run, design, judge::outputs_of(file, design.scene));
  return all;
}

/// What is asked for before anything moves. Errors: InputError.
void require_sense(const CommissionOptions& options, const judge::LoopDesign& design,
                   bool corrected) {
  if (options.simulate && (options.rig || !options.io.empty())) {
    throw InputError("--simulate plays the rig: leave the rig file and --io out");
  }
  if (!options.simulate && !options.rig && options.io.empty()) {
    throw InputError("no driver: name one in a rig file or with --io, or play with --simulate");
  }
  if (options.until != "loop" && options.policy) {
    throw InputError("--policy is of the loop: it goes with --until loop");
  }
  if (corrected && options.until != "loop") {
    throw InputError(options.scene.string() +
                     ": corrections: are there already; commission the scene as it was written, "
                     "or write them into it; with --until loop its loop is closed as it is");
  }
  if (corrected && options.plot) {
    throw InputError("--plot draws what is fitted, and this scene is corrected already");
  }
  if (options.until == "wiring" && (options.plot || options.uncertainty)) {
    throw InputError(
        "--plot and --uncertainty are of the scene, which --until wiring leaves alone");
  }
  if (options.until == "loop") {
    policy_of(options, design.gains);
    controller::require_clocked_delay(design.gains, design.scene.controller->place);
  }
  judge::require_recordable(design, options.window_s, options.windows);
  if (corrected) return;
  try {
    YamlReader::from_text(with_block(design.scene.text, "corrections: {}\n"), "");
  } catch (const InputError&) {
    throw InputError(options.scene.string() +
                     ": a block cannot be written behind it; write its keys a line each, without "
                     "'...' at the end");
  }
}

/// Measures, fits, and writes what was found; true if a loop may be closed on it.
bool find_scene(Commissioning& all, Rig& rig, const CommissionOptions& options,
                const judge::LoopDesign& design, const CommissionedFiles& files,
                const judge::Progress& progress) {
  const bool only_wiring = options.until == "wiring";
  const judge::CommissionQuestion question{
      .design = design,
      .uncertainty = only_wiring ? SceneUncertainty{} : uncertainty_of(options, design.scene),
      .force_n = controller::probe_force(options.force_n, design.gains, options.scene),
      .window_s = options.window_s,
      .n_windows = options.windows,
      .only_wiring = only_wiring};
  all.found = rig.with([&](controller::Io& io) {
    return judge::measure(io, all.rig, question, controller::real_time(), progress, stop_requested);
  });
  judge::Commissioned& found = *all.found;
  all.passed = found.wiring.sound;
  if (!found.wiring.connected) return false;
  if (!only_wiring) fit_recording(found, progress);
  all.rig = found.rig;
  if (files.rig) write_whole_file(*files.rig, to_yaml(found.rig, design.gains));
  all.files.rig = files.rig;
  if (only_wiring) return true;
  write_whole_file(*files.scene, with_block(design.scene.text, corrections_block(found)));
  write_whole_file(*files.uncertainty,
                   "# What is left to doubt of " + files.scene->filename().string() +
                       ": two standard deviations of the least known.\n" + uncertainty_left(found));
  all.files = files;
  if (options.plot) draw(all, *options.plot);
  all.loops = {judge::make_loop_design(*files.scene, options.controller, options.scene).radius,
               judge::make_loop_design(*files.scene, options.controller).radius};
  all.passed = judge::anything_told(found) && found.fit.converged && all.loops->after < 1 &&
               found.fit.is_noise();
  return all.passed;
}

void say_next(const Commissioning& all) {
  if (!all.files.scene) return;
  const std::string scene = all.files.scene->string();
  std::cout << "Next: stillframe design " << scene << " --out gains.yaml, and\n"
            << "  stillframe robustness " << scene << " --uncertainty "
            << all.files.uncertainty->string() << "\n";
}

int run(const CommissionOptions& options) {
  const judge::LoopDesign design = judge::make_loop_design(options.scene, options.controller);
  const bool corrected = YamlReader::from_file(options.scene).find("corrections").has_value();
  require_sense(options, design, corrected);
  Commissioning all{
      .title = design.scene.title,
      .how = {.scene = options.scene.string(),
              .played = options.simulate ? options.simulate->string() : "",
              .date = judge::date_of(std::time(nullptr) * 1'000'000),
              .force_n = controller::probe_force(options.force_n, design.gains, options.scene),
              .window_s = options.window_s,
              .windows = options.windows},
      .rig = options.rig ? controller::read_rig(*options.rig, design.gains) : simulated_rig(design),
      .legs = design.gains.legs};
  if (!options.simulate) controller::choose_driver(all.rig, options.io);
  judge::outputs_of(all.rig, design.scene);  // an unknown name is not said after minutes
  CommissionedFiles files{updated(options.scene, ".updated.yaml"),
                          updated(options.scene, ".updated.uncertainty.yaml"),
                          {}};
  if (options.rig) files.rig = updated(*options.rig, ".updated.yaml");
  require_own_places({{"the scene", options.scene},
                      {"the rig file", options.rig},
                      {"--controller", options.controller},
                      {"--uncertainty", options.uncertainty},
                      {"--policy", options.policy},
                      {"--simulate", options.simulate}},
                     {{"the updated scene", files.scene},
                      {"the uncertainty that is left", files.uncertainty},
                      {"the updated rig file", files.rig},
                      {"--plot", options.plot},
                      {"--report", options.report}});
  Rig rig(options, design, all.rig);
  catch_stop_signals();
  // What was found is said, whatever becomes of a later step.
  std::exception_ptr failure;
  try {
    Patience patience("wiring");
    const auto progress = [&](const std::string& what, double done) {
      patience.now(what, 100 * done);
    };
    const bool may_close = corrected || find_scene(all, rig, options, design, files, progress);
    if (may_close && options.until == "loop") {
      all.passed = false;
      std::optional<judge::LoopDesign> found;
      if (!corrected) found = judge::make_loop_design(*files.scene, options.controller);
      all.closed = closed(rig, options, found ? *found : design, all.rig,
                          all.found ? all.found->force_n : all.how.force_n,
                          [&](double done) { progress("closed", done); });
      all.passed = all.is_closed_well();
    }
  } catch (...) {
    if (!all.found && !all.closed) throw;
    failure = std::current_exception();
    all.passed = false;
  }
  if (options.json) {
    print(to_json(all));
  } else {
    if (all.found) print_wiring(all);
    if (all.is_fitted()) print_parameters(all);
    if (all.closed) print_closed(all);
    if (options.until == "loop" && !all.closed) std::cout << "The loop was not measured closed.\n";
    if (options.until == "scene") say_next(all);
  }
  if (options.report) write_page(page_of(all), *options.report);
  if (failure) std::rethrow_exception(failure);
  return all.passed ? exit_done : exit_failed;
}

}  // namespace

void add_commission(cli::Command& app, int& exit_code) {
  auto options = std::make_shared<CommissionOptions>();
  cli::Command verb =
      app.verb("commission",
               "From the first cable of a rig to its loop: wiring, scene, closed and measured");
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
  verb.option("--report", options->report, "HTML page of all that was found").type_name("FILE");
  verb.option(
          "--until", options->until,
          "The last step: wiring; scene, measured and corrected; loop, closed on it and measured")
      .check(cli::one_of({"wiring", "scene", "loop"}))
      .show_default();
  verb.option("--policy", options->policy,
              "With --until loop: fault policy (docs/safety.md; default: its defaults)")
      .type_name("FILE");
  verb.flag("--json", options->json, "Print JSON (keys below)");
  verb.footer(
      "wiring: as `rig` finds it, and puts it right for what follows. scene: one leg after the "
      "other is\n"
      "driven by a multisine from 2 / window to 0.42 of the sample rate, but for the model's own\n"
      "resonances, and what all force sensors, read-backs and accelerometers answer is fitted: of "
      "every\n"
      "parameter that the uncertainty names, its value and how well it is known now. loop: gains "
      "are\n"
      "designed anew, and the loop is closed on the rig as a controller would, with a "
      "multisine\n"
      "added to its commands; what it makes of that is held against its prediction "
      "(docs/hardware.md).\n"
      "Each step is taken only if the one before it ended well. A scene that was corrected begins "
      "with loop.\n"
      "Written beside the scene: SCENE.updated.yaml, the scene with a block of corrections, and\n"
      "SCENE.updated.uncertainty.yaml; beside the rig file RIG.updated.yaml, with cables, signs "
      "and gains.\n"
      "The rig is let go of beyond ten times the force, at any fault of a closed loop, and at "
      "Ctrl-C.\n"
      "Exit codes: 0 the wiring was sound (wiring); something is told, fitted to the noise, and "
      "the loop of\n"
      "the updated scene is stable (scene); and within 1 dB of its prediction where noise lets it "
      "be seen,\n"
      "and the frame was shaken no harder than without it (loop); 4 not, or the rig could not be "
      "measured.\n"
      "Keys of --json:\n"
      "  scene, wrong (leg, what), connected, clock_ppm, n_samples, n_lost\n"
      "  parameters   {name, deviation, standard_deviation, known_before (relative, m, rad or "
      "samples), told,\n"
      "               alike (names of those it could trade places with)}\n"
      "  outputs      {name, left_before, left (of what was read, rms)}\n"
      "  over_noise (power of what is left over that of the noise at rest), n_late, n_left_out, "
      "converged,\n"
      "  spectral_radius_before, spectral_radius, scene_file, rig_file, uncertainty_file\n"
      "  closed       {responses {of (frame or sigma, and strain), frequencies_hz, measured, "
      "standard_deviation,\n"
      "               predicted, passive (largest singular values from added forces, m/s^2 or N "
      "per "
      "N), n_told,\n"
      "               n_acting, mean_db, mean_doubt_db, worst_db, worst_hz, as_predicted}, "
      "frame_peak_m_s2,\n"
      "               force_peak_n, added_force_n, n_lost, n_saturated, n_faults, "
      "frame_peak_driven_m_s2,\n"
      "               shaken_harder (null: nothing to compare by), as_predicted}\n"
      "  passed\n"
      "Example: stillframe commission frame.yaml rig.yaml --uncertainty piezo_frame.yaml\n"
      "To try it without a rig: stillframe commission frame.yaml --simulate other_frame.yaml "
      "--until loop");
  verb.runs([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace stillframe::tools

#include <iostream>
#include <memory>
#include <optional>

#include "controller/start_check.hpp"
#include "core/errors/formatted.hpp"
#include "core/errors/input_error.hpp"
#include "core/files/whole_file.hpp"
#include "judge/loop_design.hpp"
#include "report/plots/plot_trade.hpp"
#include "tools/design_page.hpp"
#include "tools/design_trade.hpp"
#include "tools/given_files.hpp"
#include "tools/json.hpp"
#include "tools/loop_mat.hpp"
#include "tools/patience.hpp"
#include "tools/unit_hint.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

namespace {

struct DesignOptions {
  std::filesystem::path scene;
  std::optional<std::filesystem::path> controller, design_scene, out, mat, plot_trade;
  bool json = false;
};

void plot_trade(const judge::LoopDesign& design, const std::filesystem::path& path) {
  Patience patience("trade");
  const DesignTrade trade =
      design_trade(design, [&](double done) { patience.now("trade", 100 * done); });
  report::TradePlot plot{.title = design.scene.title + ": target, sample rate, delay",
                         .rates_hz = trade.rates_hz,
                         .columns = {}};
  for (const TradeCurve& curve : trade.curves) {
    const std::string title = formatted("delay %g sample(s)", curve.delay_samples);
    if (plot.columns.empty() || plot.columns.back().title != title) {
      plot.columns.push_back({title, {}});
    }
    plot.columns.back().curves.push_back(
        {formatted("%g Hz", curve.target_hz), curve.disk, curve.price_db});
  }
  report::plot_trade(plot, path);
}

int run(const DesignOptions& options) {
  require_own_places(
      {{"the scene", options.scene},
       {"the controller block", options.controller},
       {"the design scene", options.design_scene}},
      {{"--out", options.out}, {"--mat", options.mat}, {"--plot-trade", options.plot_trade}});
  auto patience = std::make_unique<Patience>("linearising");
  const judge::LoopDesign design =
      judge::make_loop_design(options.scene, options.controller, options.design_scene);
  hint_at_units(design.scene);
  if (const auto& law = design.scene.controller->law) {
    const std::optional<std::filesystem::path> file = law->file;
    require_own_places({{"the law", file}}, {{"--out", options.out}, {"--mat", options.mat}});
    if (options.plot_trade) {
      throw InputError(design.scene.controller->place +
                       ": law: --plot-trade draws what designed gains cost, and these are not");
    }
  }
  const DesignAnalysis analysis =
      analyse(design, [&](const std::string& what) { patience->now(what); });
  patience.reset();  // the line is taken away before the page
  if (options.json) {
    print(design_json(design, analysis));
  } else {
    std::cout << design_page(design, analysis);
  }
  if (options.plot_trade) plot_trade(design, *options.plot_trade);
  if (options.mat) write_loop_mat(design, *options.mat);
  controller::require_stable(design.gains);
  if (options.out) write_whole_file(*options.out, to_yaml(design.gains));
  return exit_done;
}

}  // namespace

void add_design(cli::Command& app, int& exit_code) {
  auto options = std::make_shared<DesignOptions>();
  cli::Command verb = app.verb("design",
                               "Decoupled PI force-feedback gains K_P and K_I of a scene, "
                               "and what the closed loop then does");
  verb.option("scene", options->scene, "Scene file (YAML) with a controller block")
      .required()
      .type_name("SCENE");
  verb.option("--controller", options->controller, "Controller block that replaces the scene's")
      .type_name("FILE");
  verb.option("--design-scene", options->design_scene,
              "Take the gains of this scene's model (same legs) and judge them on SCENE")
      .type_name("FILE");
  verb.option("--out", options->out, "Write the gains file that stillframe-controller reads")
      .type_name("FILE");
  verb.option("--mat", options->mat,
              "Write plants, loops, law and gains as a MATLAB level-5 file (docs/exports.md)")
      .type_name("FILE");
  verb.option("--plot-trade", options->plot_trade,
              "Draw what target, sample rate and delay cost each other into a PNG file")
      .type_name("FILE");
  verb.flag("--json", options->json, "Print JSON (keys below)");
  verb.footer(
      "The page: gains; poles of the continuous law; what gets from floor, sensor noise and "
      "forces "
      "to the\n"
      "frame; margins; rates at which the loop is stable; warnings in words. Gains whose sampled "
      "closed\n"
      "loop is not stable are printed and refused: exit code 3, no file written.\n"
      "Keys of --json:\n"
      "  scene, scene_hash, order, legs, target_hz, damping_ratio, K_P, K_I, leak_hz\n"
      "  law                         file; of A, B, C, D n_states, inputs, outputs, and then\n"
      "                              no order, K_P, K_I, closed_loop_poles, *_order and\n"
      "                              stable_rates_hz: null\n"
      "  feed_forward                floor, to_hz, corner_hz, target_hz, damping_ratio (null: the\n"
      "                              feedback's), at_most_db, actuator_error, noise_over_floor,\n"
      "                              taps; null where there is none\n"
      "  closed_loop_poles           [re, im] in rad/s, continuous law on the whole plant\n"
      "  exact_order, deck_order     lowest and highest pole over its target's, largest_real "
      "(1/s)\n"
      "  spectral_radius, misaligned_spectral_radius   the second: applied force one sample late\n"
      "  reduction                   of a scene with `reduce`, as `linearise` has it; else null\n"
      "  frequencies_hz              of the next keys, a row each\n"
      "  singular_values             of T, open loop; closed_singular_values: of the loop that "
      "runs;\n"
      "                              continuous_singular_values: of its law without sampling, "
      "delay\n"
      "                              and instruments\n"
      "  noise_m_s2_per_n            largest, of sensor noise to outputs\n"
      "  compliance, passive_compliance   m/N at the outputs, of the loop that runs and open\n"
      "  spread_db, crosstalk_db     of the T that runs: largest over smallest singular value, "
      "and\n"
      "                              what reaches other outputs than its own; null if not square\n"
      "  peaks                       of, hz, singular_value: between two of frequencies_hz the "
      "highest\n"
      "                              point of the open, closed or continuous curve, where it is "
      "more\n"
      "                              than 1 dB above both; null: no bound, as nothing damps it\n"
      "  margins                     leg_gain, all_gain [down, up]; leg_delay_s, all_delay_s;\n"
      "                              delays_proven; leg_disk, all_disk, all_disk_hz; null if\n"
      "                              unstable\n"
      "  stable_rates_hz             intervals up to 200 kHz\n"
      "  recommended                 sample_rate_hz, lead_samples, roll_off_hz, price_db, disk,\n"
      "                              warnings: those of the page that stay with these settings\n"
      "  warnings; notes (what is known to do no harm)");
  verb.runs([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace stillframe::tools

#include "core/modes.hpp"

#include <iostream>
#include <memory>

#include "core/scene/scene_reader.hpp"
#include "report/table.hpp"
#include "tools/json.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

namespace {

struct Options {
  std::filesystem::path scene;
  bool json = false;
};

int run(const Options& options) {
  const Scene scene = read_scene(options.scene);
  const LinearModel linear = linearise(make_model(scene), {}, {});
  const Modes result = modes(linear);
  if (options.json) {
    print({{"scene", scene.title},
           {"dofs", linear.q_names},
           {"natural_frequencies_hz", to_json(result.natural_frequencies_hz)},
           {"damping_ratios", to_json(result.damping_ratios)},
           {"eigenvalues", to_json(result.eigenvalues)},
           {"mode_shapes", to_json(result.shapes)}});
    return exit_done;
  }
  std::cout << scene.title << ": " << linear.q_names.size() << " degrees of freedom\n";
  report::Table table({"mode", "frequency Hz", "damping ratio"}, 0);
  for (Index i = 0; i < result.natural_frequencies_hz.size(); ++i) {
    // A ratio below 1e-10 is the rounding of an eigenvalue problem, not damping.
    const double ratio = result.damping_ratios(i);
    table.add({report::cell("%td", i + 1), report::cell("%.4f", result.natural_frequencies_hz(i)),
               report::cell("%.4g", std::abs(ratio) < 1e-10 ? 0.0 : ratio)});
  }
  std::cout << table.print();
  return exit_done;
}

}  // namespace

void add_modes(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<Options>();
  CLI::App* verb = app.add_subcommand(
      "modes", "Natural frequencies, damping ratios and mode shapes of a scene at rest");
  verb->add_option("scene", options->scene, "Scene file (YAML)")->required()->type_name("SCENE");
  verb->add_flag(
      "--json", options->json,
      "Print JSON: natural_frequencies_hz, damping_ratios, eigenvalues [re, im] in rad/s, dofs, "
      "mode_shapes (a row a dof, a column a mode, mass-normalised)");
  verb->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace stillframe::tools

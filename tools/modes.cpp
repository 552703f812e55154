#include "core/mechanics/modes.hpp"

#include <iostream>
#include <memory>
#include <numbers>

#include "core/mechanics/scene/scene_reader.hpp"
#include "core/mechanics/unstable.hpp"
#include "core/mechanics/unsymmetric_load.hpp"
#include "report/table.hpp"
#include "tools/largest_parts.hpp"
#include "tools/node_parts.hpp"
#include "tools/operating_point.hpp"
#include "tools/patience.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

namespace {

struct ModesOptions {
  std::filesystem::path scene;
  bool json = false;
};

void print_frequencies(const NodeParts& parts, const Modes& result) {
  constexpr Index most_shapes = 24;  // a screen
  const Index n_modes = result.natural_frequencies_hz.size();
  report::Table table({"mode", "frequency Hz", "largest parts"}, 3);
  for (Index i = 0; i < n_modes; ++i) {
    table.add(
        {report::cell("%4td", i + 1), report::cell("%12.6g", result.natural_frequencies_hz(i)),
         i < most_shapes ? largest_parts(parts.names, parts.of_dofs * result.shapes.col(i)) : ""});
  }
  std::cout << "Natural frequencies, without damping" << (result.moving ? " and gyroscopy" : "")
            << "; nodes with mass, m and rad over the largest\n"
            << table.print();
  if (n_modes > most_shapes) {
    std::cout << report::cell("Shapes of %td more: see --json\n", n_modes - most_shapes);
  }
}

void print_eigenvalues(const Modes& result) {
  report::Table table({"pair", "real 1/s", "imaginary rad/s", "frequency Hz", "damping ratio"}, 0);
  for (Index i = 0; i < result.eigenvalues.size(); ++i) {
    const std::complex<double> value = result.eigenvalues(i);
    // A complex pair is one line, with its positive frequency.
    if (value.imag() < 0) continue;
    const double known_to = result.known_to(i);
    const auto shown = [&](double part) { return std::abs(part) <= known_to ? 0.0 : part; };
    const double ratio = result.damping_ratios(i / 2);
    table.add({i % 2 == 0 ? report::cell("%td", i / 2 + 1) : "",
               report::cell("%.6g", shown(value.real())), report::cell("%.6g", shown(value.imag())),
               report::cell("%.6g", shown(value.imag()) / (2 * std::numbers::pi)),
               report::cell("%.4g", shown(ratio * std::abs(value)) == 0 ? 0.0 : ratio)});
  }
  std::cout << "Eigenvalues\n" << table.print();
}

void print_page(const Scene& scene, const Model& model, const LinearModel& linear,
                const NodeParts& parts, const Modes& result) {
  const bool natural = result.natural_frequencies_hz.size() == result.eigenvalues.size() / 2;
  std::cout << scene.title << ": " << linear.q_names.size() << " degrees of freedom, about "
            << operating_point_in_words(scene) << "\n";
  if (natural) {
    print_frequencies(parts, result);
  } else if (result.moving) {
    std::cout
        << "No natural frequencies: the stiffness is not symmetric or not positive in motion\n";
  } else {
    std::cout << "No natural frequencies: the stiffness is not symmetric, as "
              << unsymmetric_load(model) << "\n";
  }
  if (!natural || result.moving || !linear.D.isZero(0)) print_eigenvalues(result);
  if (result.n_growing > 0) {
    std::cout << report::cell("NOT STABLE: %td eigenvalue(s) with a positive real part\n",
                              result.n_growing);
  }
}

void print_json(const Scene& scene, const LinearModel& linear, const Modes& result) {
  print({{"scene", scene.title},
         {"scene_hash", scene.hash},
         {"operating_point", operating_point_in_words(scene)},
         {"dofs", linear.q_names},
         {"moving", result.moving},
         {"natural_frequencies_hz", to_json(result.natural_frequencies_hz)},
         {"damping_ratios", to_json(result.damping_ratios)},
         {"eigenvalues", to_json(result.eigenvalues)},
         {"growing_eigenvalues", result.n_growing},
         {"mode_shapes", to_json(result.shapes)}});
}

/// Errors: those of modes(), with the nodes that move where the configuration is not stable.
Modes solve(const NodeParts& parts, const LinearModel& linear) {
  try {
    return modes(linear);
  } catch (const Unstable& error) {
    throw Refusal(std::string(error.what()) + ", which moves " +
                  largest_parts(parts.names, parts.of_dofs * error.shape()) +
                  " (m and rad over the largest)");
  }
}

int run(const ModesOptions& options) {
  Patience patience("reading the scene");
  const Scene scene = read_scene(options.scene);
  const Model model = make_model(scene);
  patience.now("linearising");
  const LinearModel linear = linearise(model, {}, {});
  patience.now("eigenvalues");
  const NodeParts parts = node_parts(model, linear.x_0);
  const Modes result = solve(parts, linear);
  options.json ? print_json(scene, linear, result)
               : print_page(scene, model, linear, parts, result);
  return exit_done;
}

}  // namespace

void add_modes(cli::Command& app, int& exit_code) {
  auto options = std::make_shared<ModesOptions>();
  cli::Command verb = app.verb(
      "modes",
      "Natural frequencies, damping ratios and mode shapes of a scene about its operating point");
  verb.option("scene", options->scene, "Scene file (YAML)").required().type_name("SCENE");
  verb.flag("--json", options->json, "Print JSON (keys below)");
  verb.footer(
      "At rest an unstable scene is refused; in motion its growing eigenvalues are printed.\n"
      "Keys of --json:\n"
      "  scene, scene_hash, operating_point, dofs, moving\n"
      "  natural_frequencies_hz  of (K + N + G) v = omega^2 M v, upwards; empty where that has no\n"
      "                          solution (stiffness not symmetric, or not positive in motion)\n"
      "  eigenvalues             [re, im] in rad/s, of the whole model, in pairs by modulus\n"
      "  damping_ratios          -re / |.|, one a pair\n"
      "  growing_eigenvalues     how many have a positive real part\n"
      "  mode_shapes             a row a dof, a column a natural frequency, mass-normalised\n"
      "Example: stillframe modes config/scenes/metrology_frame.yaml");
  verb.runs([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace stillframe::tools

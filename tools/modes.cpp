#include "core/mechanics/modes.hpp"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>
#include <optional>

#include "core/errors/formatted.hpp"
#include "core/mechanics/partition/free_model.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "core/mechanics/sparse/damped_modes.hpp"
#include "core/mechanics/sparse/sparse_equilibrium.hpp"
#include "core/mechanics/sparse/sparse_scene.hpp"
#include "core/mechanics/state_space.hpp"
#include "core/mechanics/unsymmetric_load.hpp"
#include "core/numerics/infinity.hpp"
#include "core/numerics/two_pi.hpp"
#include "report/table.hpp"
#include "tools/largest_parts.hpp"
#include "tools/node_parts.hpp"
#include "tools/operating_point.hpp"
#include "tools/patience.hpp"
#include "tools/stability_note.hpp"
#include "tools/unit_hint.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

namespace {

struct ModesOptions {
  std::filesystem::path scene;
  int lowest = 0;  ///< 0: all
  bool json = false;
};

/// What is printed, whichever way it was found.
struct Found {
  Modes modes;
  std::vector<std::string> coordinates;  ///< what the rows of the shapes are
  NodeParts parts;
  Eigen::MatrixXd displacements;  ///< n_x x n_modes, of the shapes
  bool sparse = false, damped = false;
  std::string why_not_symmetric;
};

void print_frequencies(const Found& found) {
  constexpr Index most_shapes = 24;  // a screen
  const Modes& result = found.modes;
  const NodeParts& parts = found.parts;
  const Index n_modes = result.natural_frequencies_hz.size();
  report::Table table({"mode", "frequency Hz", "largest parts"}, 3);
  for (Index i = 0; i < n_modes; ++i) {
    table.add({formatted("%4td", i + 1), formatted("%12.6g", result.natural_frequencies_hz(i)),
               i < most_shapes
                   ? largest_parts(parts.names, parts.of_displacements * found.displacements.col(i))
                   : ""});
  }
  std::cout << "Natural frequencies, without damping" << (result.moving ? " and gyroscopy" : "")
            << "; nodes with mass, m and rad over the largest\n"
            << table.print();
  if (n_modes > most_shapes) {
    std::cout << formatted("Shapes of %td more: see --json\n", n_modes - most_shapes);
  }
}

void print_eigenvalues(const Modes& result) {
  report::Table table({"pair", "real 1/s", "imaginary rad/s", "frequency Hz", "damping ratio"}, 0);
  for (Index i = 0; i < result.eigenvalues.size(); ++i) {
    const std::complex<double> value = result.eigenvalues(i);
    // A complex pair is one line, with its positive frequency.
    if (value.imag() < 0) continue;
    if (std::isnan(value.real())) {
      if (i % 2 == 0) table.add({formatted("%td", i / 2 + 1), "not found", "", "", ""});
      continue;
    }
    const double known_to = result.known_to(i);
    const auto shown = [&](double part) { return std::abs(part) <= known_to ? 0.0 : part; };
    const double ratio = result.damping_ratios(i / 2);
    table.add({i % 2 == 0 ? formatted("%td", i / 2 + 1) : "",
               formatted("%.6g", shown(value.real())), formatted("%.6g", shown(value.imag())),
               formatted("%.6g", shown(value.imag()) / two_pi),
               formatted("%.4g", shown(ratio * std::abs(value)) == 0 ? 0.0 : ratio)});
  }
  std::cout << "Eigenvalues\n" << table.print();
}

/// Pairs of which rounding leaves less than three digits, if that is as much as a millionth of the
/// slowest that is known: else nothing is meant by 0 but what moves freely.
Index n_in_doubt(const Modes& modes) {
  Index n = 0;
  double hidden = 0, slowest = infinity;
  for (Index i = 0; i < modes.eigenvalues.size(); ++i) {
    const double size = std::abs(modes.eigenvalues(i));
    if (!(modes.known_to(i) > 1e-3 * size)) {
      slowest = std::min(slowest, size);
      continue;
    }
    hidden = std::max(hidden, modes.known_to(i));
    n += i % 2 == 0 ? 1 : 0;
  }
  return hidden > 1e-6 * slowest ? n : 0;
}

void print_doubt(const Modes& modes) {
  const Index n = n_in_doubt(modes);
  if (n == 0) return;
  std::cout << formatted(
      "Rounding leaves less than three digits of %td pair(s) of eigenvalues: what is below %.2g Hz "
      "is shown as 0\n",
      n, modes.known_to.maxCoeff() / two_pi);
}

void print_page(const Scene& scene, const Found& found) {
  const Modes& result = found.modes;
  const bool natural = result.natural_frequencies_hz.size() == result.eigenvalues.size() / 2;
  std::cout << scene.title << ": " << found.coordinates.size() << " "
            << (found.sparse ? "coordinates" : "degrees of freedom") << ", about "
            << operating_point_in_words(scene) << "\n";
  if (natural) {
    print_frequencies(found);
  } else {
    std::cout << "No natural frequencies: the stiffness is not symmetric"
              << (result.moving ? " or not positive in motion" : ", as " + found.why_not_symmetric)
              << "\n";
  }
  if (!natural || result.moving || found.damped) print_eigenvalues(result);
  print_doubt(result);
  if (result.n_growing > 0) {
    std::cout << formatted("NOT STABLE: %td eigenvalue(s) with a positive real part\n",
                           result.n_growing);
  }
}

void print_json(const Scene& scene, const Found& found) {
  const Modes& result = found.modes;
  print({{"scene", scene.title},
         {"scene_hash", scene.hash},
         {"operating_point", operating_point_in_words(scene)},
         {"dofs", found.coordinates},
         {"moving", result.moving},
         {"natural_frequencies_hz", to_json(result.natural_frequencies_hz)},
         {"damping_ratios", to_json(result.damping_ratios)},
         {"eigenvalues", to_json(result.eigenvalues)},
         {"eigenvalues_known_to", to_json(result.known_to)},
         {"n_growing_eigenvalues", result.n_growing},
         {"mode_shapes", to_json(result.shapes)}});
}

Found all_modes(const Scene& scene, Patience& patience) {
  const Model model = make_model(scene);
  patience.now("linearising");
  const LinearModel linear = linearise(model, {}, {});
  patience.now("eigenvalues");
  Found found;
  found.coordinates = linear.q_names;
  found.parts = node_parts(model, linear.x_0);
  const Eigen::MatrixXd DF = displacements_of_dofs(model, linear.x_0);
  found.modes = with_what_moves(
      [&] { return modes(linear); },
      [&](const Eigen::VectorXd& shape) { return what_moves(model, linear, shape); });
  found.displacements = DF * found.modes.shapes;
  found.damped = !linear.D.isZero(0);
  if (!found.modes.moving) found.why_not_symmetric = unsymmetric_load(model);
  return found;
}

/// Keeps the lowest natural frequencies and as many pairs of eigenvalues, the lowest by modulus.
void keep_lowest(Found& found, Index n_modes) {
  Modes& modes = found.modes;
  const Index n_natural = std::min<Index>(n_modes, modes.natural_frequencies_hz.size()),
              n_pairs = std::min<Index>(n_modes, modes.damping_ratios.size());
  modes.natural_frequencies_hz.conservativeResize(n_natural);
  modes.shapes.conservativeResize(Eigen::NoChange, n_natural);
  found.displacements.conservativeResize(Eigen::NoChange, n_natural);
  modes.damping_ratios.conservativeResize(n_pairs);
  modes.eigenvalues.conservativeResize(2 * n_pairs);
  modes.known_to.conservativeResize(2 * n_pairs);
}

Found lowest_of_many(const Model& model, Index n_modes, Patience& patience) {
  const MixedModel mixed(model);
  patience.now("equilibrium");
  const MixedState state = sparse_equilibrium(mixed).state;
  patience.now("the lowest modes");
  Found found;
  found.sparse = true;
  found.coordinates = coordinate_names(model);
  found.parts = node_parts(model, state.x);
  found.modes = with_what_moves(
      [&] { return sparse_modes(mixed, state, n_modes); },
      [&](const Eigen::VectorXd& shape) { return what_moves(model, state.x, shape); });
  found.displacements.setZero(model.n_x, found.modes.shapes.cols());
  found.displacements.topRows(model.n_c) = found.modes.shapes;
  found.damped = mixed.damped();
  return found;
}

/// lowest: how many, 0 for all.
Found found_modes(const Scene& scene, Index lowest, Patience& patience) {
  std::optional<Model> model;
  if (lowest > 0) model = large_scene(scene, lowest);
  if (model) return lowest_of_many(*model, lowest, patience);
  try {
    Found found = all_modes(scene, patience);
    if (lowest == 0) return found;
    // Strains know what is slow better than a stiffness matrix does.
    if (n_in_doubt(found.modes) > 0 && (model = large_scene(scene, 0, 0))) {
      return lowest_of_many(*model, std::min(lowest, model->n_c), patience);
    }
    keep_lowest(found, lowest);
    return found;
  } catch (const Massless&) {
    // Without dofs what has no mass follows the rest, and there are fewer modes than coordinates.
    model = large_scene(scene, 0, 0);
    if (!model) throw;
    return lowest_of_many(*model, lowest > 0 ? std::min(lowest, model->n_c) : model->n_c, patience);
  }
}

int run(const ModesOptions& options) {
  Patience patience("reading the scene");
  const Scene scene = read_scene(options.scene);
  hint_at_units(scene);
  const Found found = found_modes(scene, options.lowest, patience);
  options.json ? print_json(scene, found) : print_page(scene, found);
  return exit_done;
}

}  // namespace

void add_modes(cli::Command& app, int& exit_code) {
  auto options = std::make_shared<ModesOptions>();
  cli::Command verb = app.verb(
      "modes",
      "Natural frequencies, damping ratios and mode shapes of a scene about its operating point");
  verb.option("scene", options->scene, "Scene file (YAML)").required().type_name("SCENE");
  verb.option(
          "--lowest", options->lowest,
          "Only so many modes, the lowest: of a scene with `dofs: auto` and hundreds of beams in a "
          "fraction of the time and memory")
      .check(cli::whole_number(1, 100000))
      .type_name("N");
  verb.flag("--json", options->json, "Print JSON (keys below)");
  verb.footer(
      "At rest an unstable scene is refused; in motion its growing eigenvalues are printed.\n"
      "Keys of --json:\n"
      "  scene, scene_hash, operating_point, dofs, moving\n"
      "  natural_frequencies_hz  of (K + N + G) v = omega^2 M v, upwards; empty where that has no\n"
      "                          solution (stiffness not symmetric, or not positive in motion)\n"
      "  eigenvalues             [re, im] in rad/s, of the whole model, in pairs by modulus\n"
      "  eigenvalues_known_to    rad/s, one an eigenvalue; what is less is 0\n"
      "  damping_ratios          -re / |.|, one a pair\n"
      "  n_growing_eigenvalues   how many have a positive real part\n"
      "  mode_shapes             a row a dof, a column a natural frequency, mass-normalised\n"
      "Of a scene with `dofs: auto` that is large, with --lowest, or where a dof moves no mass: "
      "dofs\n"
      "are all free coordinates of the nodes, there are as many modes as have mass,\n"
      "and eigenvalues those that the lowest modes turn into when they are damped, null where one "
      "is "
      "not found\n"
      "(mostly of modes damped so much that they do not ring).\n"
      "Example: stillframe modes config/scenes/metrology_frame.yaml");
  verb.runs([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace stillframe::tools

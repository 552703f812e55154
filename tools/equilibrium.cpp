#include "core/mechanics/equilibrium.hpp"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>
#include <optional>

#include "core/errors/formatted.hpp"
#include "core/errors/input_error.hpp"
#include "core/mechanics/model/prescribed.hpp"
#include "core/mechanics/node_moves.hpp"
#include "core/mechanics/partition/free_model.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "core/mechanics/sparse/mixed_signals.hpp"
#include "core/mechanics/sparse/sparse_equilibrium.hpp"
#include "core/mechanics/sparse/sparse_scene.hpp"
#include "report/table.hpp"
#include "tools/operating_point.hpp"
#include "tools/patience.hpp"
#include "tools/stability_note.hpp"
#include "tools/unit_hint.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

namespace {

struct EquilibriumOptions {
  std::filesystem::path scene;
  bool json = false;
};

/// Deformations and stress resultants of an element of the scene, n_e each.
struct ElementRows {
  const ModelElement* element = nullptr;
  Eigen::VectorXd e, sigma;
};

/// An equilibrium with all that hangs on it, whichever way it was found.
struct Page {
  Scene scene;
  std::unique_ptr<Model> model;
  bool large = false;  ///< by sparse_equilibrium: coordinates are all free ones of the nodes
  bool moving = false;
  double residual = 0, reference = 0;
  int iterations = 0, load_steps = 1;
  std::vector<std::string> coordinates, units;
  Eigen::VectorXd q, x;  ///< of the coordinates, and n_x
  std::vector<ElementRows> elements;
  std::vector<SceneSignal> held;  ///< directions along or about which something holds a node
  Eigen::VectorXd reactions;      ///< of these, N or N m
  Json stable;
};

void add_held(const Scene& scene, const SceneConstraint& constraint,
              std::vector<SceneSignal>& held) {
  if (constraint.node.empty()) return;
  const auto add = [&](Quantity quantity, const Eigen::Vector3d& direction) {
    SceneSignal signal;
    signal.node = constraint.node;
    signal.place = constraint.place;
    signal.quantity = quantity;
    signal.direction = direction;
    signal.name = direction_in_words(direction);
    held.push_back(signal);
  };
  for (const auto& direction : constraint.directions) add(Quantity::reaction, direction);
  if (!constraint.rotation) return;
  for (Index i = scene.planar ? 2 : 0; i < 3; ++i) {
    add(Quantity::reaction_moment, Eigen::Vector3d::Unit(i));
  }
}

/// Elements of the scene; the model has more, which hold the norms of Euler parameters.
std::vector<std::size_t> elements_of(const Scene& scene, const Model& model) {
  std::vector<std::size_t> elements;
  for (const SceneElement& element : scene.elements) {
    elements.push_back(static_cast<std::size_t>(model.element_index(element.name)));
  }
  return elements;
}

/// Deformations or stresses of one element of all.
Eigen::VectorXd entries_of(const ModelElement& element, const Eigen::VectorXd& all) {
  Eigen::VectorXd own(element.element->n_deformations());
  for (Index i = 0; i < own.size(); ++i) own(i) = all(element.row[static_cast<size_t>(i)]);
  return own;
}

template <class Found>
void take_counts(const Found& found, Page& page) {
  page.residual = found.residual;
  page.reference = found.reference;
  page.iterations = found.iterations;
  page.load_steps = found.load_steps;
}

void solve(Page& page, Patience& patience) {
  const Model& model = *page.model;
  patience.now("equilibrium");
  const Equilibrium found = solve_equilibrium(model);
  take_counts(found, page);
  page.moving = found.motion.moving();
  page.q = found.motion.state.q_d;
  page.x = found.motion.x;
  patience.now("reactions");
  Lineariser lineariser(model, {}, page.held,
                        {.mass = false, .damping = false, .stiffness = false});
  const LinearModel names = lineariser.about(found.motion);  // and values, no matrices
  page.coordinates = names.q_names;
  page.units = names.q_units;
  page.reactions = names.y_0;
  for (const std::size_t k : elements_of(page.scene, model)) {
    const ModelElement& element = model.elements[k];
    page.elements.push_back({&element, entries_of(element, lineariser.data().e),
                             entries_of(element, lineariser.data().sigma)});
  }
  patience.now("stability");
  page.stable = warn_unless_stable(model, linearise(model, found.motion, {}, {}));
}

void solve_large(Page& page, Patience& patience) {
  const Model& model = *page.model;
  const MixedModel mixed(model);
  patience.now("equilibrium");
  const SparseEquilibrium found = sparse_equilibrium(mixed);
  take_counts(found, page);
  page.x = found.state.x;
  page.coordinates = coordinate_names(model);
  page.q = page.x.head(model.n_c);
  page.units = coordinate_units(model);
  patience.now("reactions");
  page.reactions = reactions_at_rest(mixed, found.state, page.held);
  for (const std::size_t k : elements_of(page.scene, model)) {
    page.elements.push_back(
        {&model.elements[k], mixed.deformations(k, found.state.x), mixed.stresses(k, found.state)});
  }
  patience.now("stability");
  page.stable =
      warn_unless_stable(mixed, found.state, [&] { lowest_modes(mixed, found.state, 1); });
}

Page solved(const EquilibriumOptions& options) {
  Patience patience("reading the scene");
  Page page;
  page.scene = read_scene(options.scene);
  page.scene.modal_damping.reset();  // what is at rest asks for no modes
  hint_at_units(page.scene);
  if (page.scene.operating_point == OperatingPoint::as_written) {
    throw Refusal(
        "the scene asks for a snapshot (operating_point: as_written), which is no equilibrium; "
        "take that key out to look for one");
  }
  for (const auto& support : page.scene.supports) add_held(page.scene, support, page.held);
  for (const auto& motion : page.scene.prescribed) add_held(page.scene, motion, page.held);
  std::optional<Model> large = large_scene(page.scene, 1);
  page.large = large.has_value();
  page.model = std::make_unique<Model>(large ? std::move(*large) : make_model(page.scene));
  page.large ? solve_large(page, patience) : solve(page, patience);
  // Without the sign of a zero.
  page.reactions.array() += 0.0;
  for (ElementRows& rows : page.elements) {
    rows.e.array() += 0.0;
    rows.sigma.array() += 0.0;
  }
  return page;
}

/// What is left of values below the rounding of positions, 1e-15 of the scene's size, and of turns;
/// less where the nodes hardly move.
class WithoutRounding {
 public:
  explicit WithoutRounding(const Page& page)
      : size_(scene_size(*page.model)),
        turn_(std::min(1e-15, 1e-6 * largest_move(*page.model, page.x))) {}
  double length(double value) const { return above(size_ * turn_, value); }
  double turn(double value) const { return above(turn_, value); }
  double either(double value) const { return above(std::min(size_, 1.0) * turn_, value); }

 private:
  static double above(double least, double value) { return std::abs(value) < least ? 0.0 : value; }
  double size_, turn_;
};

void print_elements(const Page& page, const WithoutRounding& shown) {
  report::Table table({"element", "mode", "deformation", "stress resultant"}, 1);
  for (const auto& [element, e, sigma] : page.elements) {
    for (Index i = 0; i < e.size(); ++i) {
      table.add(
          {i == 0 ? element->name : "", formatted("%td", i + 1),
           element->zero[static_cast<size_t>(i)] ? "rigid" : formatted("%.6g", shown.either(e(i))),
           formatted("%.6g", sigma(i))});
    }
  }
  std::cout << "\nElements (m, rad; N, N m), stresses of rigid deformations from the balance\n"
            << table.print();
}

void print_dofs(const Page& page, const WithoutRounding& shown) {
  report::Table dofs({"dof", "unit", "value"}, 2);
  for (size_t i = 0; i < page.coordinates.size(); ++i) {
    const double value = page.q(static_cast<Index>(i));
    dofs.add({page.coordinates[i], page.units[i],
              formatted("%.9g", page.units[i] == "m" ? shown.length(value) : shown.turn(value))});
  }
  std::cout << dofs.print() << "\n";
}

void print_page(const Page& page) {
  std::cout << page.scene.title << ": " << (page.moving ? "stationary motion" : "equilibrium")
            << formatted(" found in %d iterations, %d load step(s)\n", page.iterations,
                         page.load_steps)
            << formatted("Largest force out of balance %.3g, of %.6g\n\n", page.residual,
                         page.reference);
  const WithoutRounding shown(page);
  if (!page.large) print_dofs(page, shown);
  std::vector<NodeDisplacement> nodes = node_displacements(*page.model, page.x);
  for (NodeDisplacement& node : nodes) {
    for (double& value : node.displacement) value = shown.length(value);
    for (double& value : node.rotation) value = shown.turn(value);
  }
  std::cout << "Nodes, from the scene as written\n" << table_of(*page.model, nodes);
  print_elements(page, shown);
  report::Table reactions({"node", "along or about", "unit", "reaction"}, 3);
  for (size_t i = 0; i < page.held.size(); ++i) {
    reactions.add({page.held[i].node, page.held[i].name, unit_of(*page.model, page.held[i]),
                   formatted("%.6g", page.reactions(static_cast<Index>(i)))});
  }
  if (!page.held.empty()) std::cout << "\nWhat supports and drives exert\n" << reactions.print();
}

void print_json(const Page& page) {
  Json elements = Json::array(), reactions = Json::array();
  for (const auto& [element, e, sigma] : page.elements) {
    elements.push_back({{"element", element->name},
                        {"deformations", to_json(e)},
                        {"stress_resultants", to_json(sigma)}});
  }
  for (size_t i = 0; i < page.held.size(); ++i) {
    reactions.push_back({{"node", page.held[i].node},
                         {"direction", to_json(Eigen::VectorXd(page.held[i].direction))},
                         {"unit", unit_of(*page.model, page.held[i])},
                         {"value", page.reactions(static_cast<Index>(i))}});
  }
  print({{"scene", page.scene.title},
         {"scene_hash", page.scene.hash},
         {"moving", page.moving},
         {"stable", page.stable},
         {"dofs", page.coordinates},
         {"dof_units", page.units},
         {"q", to_json(page.q)},
         {"nodal_displacements", to_json(*page.model, node_displacements(*page.model, page.x))},
         {"elements", elements},
         {"reactions", reactions},
         {"residual", page.residual},
         {"reference", page.reference},
         {"n_iterations", page.iterations},
         {"n_load_steps", page.load_steps}});
}

int run(const EquilibriumOptions& options) {
  const Page page = solved(options);
  options.json ? print_json(page) : print_page(page);
  return exit_done;
}

}  // namespace

void add_equilibrium(cli::Command& app, int& exit_code) {
  auto options = std::make_shared<EquilibriumOptions>();
  cli::Command verb =
      app.verb("equilibrium",
               "Equilibrium of a scene under its loads, gravity, preloads and stationary "
               "prescribed motion: displacements, stresses, reactions");
  verb.option("scene", options->scene, "Scene file (YAML)").required().type_name("SCENE");
  verb.flag("--json", options->json, "Print JSON (keys below)");
  verb.footer(
      "The loads grow in steps where they are too large to be balanced at once; what cannot be\n"
      "balanced is refused with the part of the load that was reached.\n"
      "An equilibrium that is not stable is printed all the same, with a warning and exit code 0.\n"
      "Of a scene with `dofs: auto` and hundreds of beams, dofs are all free coordinates of the "
      "nodes,\n"
      "which the page leaves to the table of nodes.\n"
      "Keys of --json:\n"
      "  scene, scene_hash, moving\n"
      "  stable                whether nothing grows about it, as `modes` judges; null: not known\n"
      "  dofs, dof_units, q    names, units and values of the degrees of freedom\n"
      "  nodal_displacements   {node, displacement (m), rotation (rad, angle times axis)}\n"
      "  elements              {element, deformations (m, rad), stress_resultants (N, N m)}\n"
      "  reactions             {node, direction, unit, value}: N along it, or N m about it\n"
      "  residual, reference   largest force that is left, and that had to be balanced\n"
      "  n_iterations, n_load_steps\n"
      "Example: stillframe equilibrium config/scenes/metrology_frame.yaml");
  verb.runs([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace stillframe::tools

#include "core/mechanics/equilibrium.hpp"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>

#include "core/errors/input_error.hpp"
#include "core/mechanics/model/prescribed.hpp"
#include "core/mechanics/node_moves.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "report/table.hpp"
#include "tools/operating_point.hpp"
#include "tools/patience.hpp"
#include "tools/stability_note.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

namespace {

struct EquilibriumOptions {
  std::filesystem::path scene;
  bool json = false;
};

/// An equilibrium with all that hangs on it.
struct Page {
  Scene scene;
  Model model;
  Equilibrium equilibrium;
  std::vector<SceneSignal> held;  ///< directions along or about which something holds a node
  LinearModel linear;             ///< only its names and values, no matrices
  Eigen::VectorXd e, sigma;       ///< n_e
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

Page solve(const EquilibriumOptions& options) {
  Patience patience("reading the scene");
  Scene scene = read_scene(options.scene);
  if (scene.operating_point == OperatingPoint::as_written) {
    throw Refusal(
        "the scene asks for a snapshot (operating_point: as_written), which is no equilibrium; "
        "take that key out to look for one");
  }
  Model model = make_model(scene);
  patience.now("equilibrium");
  Equilibrium equilibrium = solve_equilibrium(model);
  patience.now("reactions");
  Page page{std::move(scene), std::move(model), std::move(equilibrium), {}, {}, {}, {}};
  for (const auto& support : page.scene.supports) add_held(page.scene, support, page.held);
  for (const auto& motion : page.scene.prescribed) add_held(page.scene, motion, page.held);
  Lineariser lineariser(page.model, {}, page.held,
                        {.mass = false, .damping = false, .stiffness = false});
  page.linear = lineariser.about(page.equilibrium.motion);
  page.e = lineariser.data().e;
  page.sigma = lineariser.data().sigma;
  page.linear.y_0.array() += 0.0;
  return page;
}

/// Elements of the scene; the model has more, which hold the norms of Euler parameters.
std::vector<const ModelElement*> elements_of(const Page& page) {
  std::vector<const ModelElement*> elements;
  for (const SceneElement& element : page.scene.elements) {
    const Index k = page.model.element_index(element.name);
    elements.push_back(&page.model.elements[static_cast<size_t>(k)]);
  }
  return elements;
}

/// Deformations or stresses of one element, without the sign of a zero.
Eigen::VectorXd entries_of(const ModelElement& element, const Eigen::VectorXd& all) {
  Eigen::VectorXd own(element.element->n_deformations());
  for (Index i = 0; i < own.size(); ++i) own(i) = all(element.row[static_cast<size_t>(i)]) + 0.0;
  return own;
}

/// What is left of values below the rounding of positions, 1e-15 of the scene's size, and of turns;
/// less where the nodes hardly move.
class WithoutRounding {
 public:
  explicit WithoutRounding(const Page& page)
      : size_(scene_size(page.model)),
        turn_(std::min(1e-15, 1e-6 * largest_move(page.model, page.equilibrium.motion.x))) {}
  double length(double value) const { return above(size_ * turn_, value); }
  double turn(double value) const { return above(turn_, value); }
  double either(double value) const { return above(std::min(size_, 1.0) * turn_, value); }

 private:
  static double above(double least, double value) { return std::abs(value) < least ? 0.0 : value; }
  double size_, turn_;
};

void print_elements(const Page& page, const WithoutRounding& shown) {
  report::Table table({"element", "mode", "deformation", "stress resultant"}, 1);
  for (const ModelElement* element : elements_of(page)) {
    const Eigen::VectorXd e = entries_of(*element, page.e),
                          sigma = entries_of(*element, page.sigma);
    for (Index i = 0; i < e.size(); ++i) {
      table.add({i == 0 ? element->name : "", report::cell("%td", i + 1),
                 element->zero[static_cast<size_t>(i)] ? "rigid"
                                                       : report::cell("%.6g", shown.either(e(i))),
                 report::cell("%.6g", sigma(i))});
    }
  }
  std::cout << "\nElements (m, rad; N, N m), stresses of rigid deformations from the balance\n"
            << table.print();
}

void print_page(const Page& page) {
  const Equilibrium& found = page.equilibrium;
  std::cout << page.scene.title << ": "
            << (found.motion.moving() ? "stationary motion" : "equilibrium")
            << report::cell(" found in %d iterations, %d load step(s)\n", found.iterations,
                            found.load_steps)
            << report::cell("Largest force out of balance %.3g, of %.6g\n\n", found.residual,
                            found.reference);
  const WithoutRounding shown(page);
  report::Table dofs({"dof", "unit", "value"}, 2);
  for (size_t i = 0; i < page.linear.q_names.size(); ++i) {
    const double value = found.motion.state.q_d(static_cast<Index>(i));
    const std::string& unit = page.linear.q_units[i];
    dofs.add({page.linear.q_names[i], unit,
              report::cell("%.9g", unit == "m" ? shown.length(value) : shown.turn(value))});
  }
  std::vector<NodeDisplacement> nodes = node_displacements(page.model, found.motion.x);
  for (NodeDisplacement& node : nodes) {
    for (double& value : node.displacement) value = shown.length(value);
    for (double& value : node.rotation) value = shown.turn(value);
  }
  std::cout << dofs.print() << "\nNodes, from the scene as written\n"
            << table_of(page.model, nodes);
  print_elements(page, shown);
  report::Table reactions({"node", "along or about", "unit", "reaction"}, 3);
  for (size_t i = 0; i < page.held.size(); ++i) {
    reactions.add({page.held[i].node, page.held[i].name, page.linear.outputs[i].unit,
                   report::cell("%.6g", page.linear.y_0(static_cast<Index>(i)))});
  }
  if (!page.held.empty()) std::cout << "\nWhat supports and drives exert\n" << reactions.print();
}

void print_json(const Page& page, const Json& stable) {
  const Equilibrium& found = page.equilibrium;
  Json elements = Json::array(), reactions = Json::array();
  for (const ModelElement* element : elements_of(page)) {
    elements.push_back({{"element", element->name},
                        {"deformations", to_json(entries_of(*element, page.e))},
                        {"stress_resultants", to_json(entries_of(*element, page.sigma))}});
  }
  for (size_t i = 0; i < page.held.size(); ++i) {
    reactions.push_back({{"node", page.held[i].node},
                         {"direction", to_json(Eigen::VectorXd(page.held[i].direction))},
                         {"unit", page.linear.outputs[i].unit},
                         {"value", page.linear.y_0(static_cast<Index>(i))}});
  }
  print(
      {{"scene", page.scene.title},
       {"scene_hash", page.scene.hash},
       {"moving", found.motion.moving()},
       {"stable", stable},
       {"dofs", page.linear.q_names},
       {"dof_units", page.linear.q_units},
       {"q", to_json(found.motion.state.q_d)},
       {"nodal_displacements", to_json(page.model, node_displacements(page.model, found.motion.x))},
       {"elements", elements},
       {"reactions", reactions},
       {"residual", found.residual},
       {"reference", found.reference},
       {"n_iterations", found.iterations},
       {"n_load_steps", found.load_steps}});
}

int run(const EquilibriumOptions& options) {
  const Page page = solve(options);
  const Json stable =
      warn_unless_stable(page.model, linearise(page.model, page.equilibrium.motion, {}, {}));
  options.json ? print_json(page, stable) : print_page(page);
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

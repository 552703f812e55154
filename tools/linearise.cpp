#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>
#include <numbers>
#include <optional>

#include "core/errors/formatted.hpp"
#include "core/errors/input_error.hpp"
#include "core/mechanics/certificate.hpp"
#include "core/mechanics/frequency_response.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "core/mechanics/state_space.hpp"
#include "report/table.hpp"
#include "tools/given_files.hpp"
#include "tools/linear_form.hpp"
#include "tools/matrix_table.hpp"
#include "tools/operating_point.hpp"
#include "tools/patience.hpp"
#include "tools/reduction_text.hpp"
#include "tools/stability_note.hpp"
#include "tools/unit_hint.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

namespace {

/// A matrix of more columns does not fit on a page.
constexpr Index page_columns = 8;

struct LineariseOptions {
  std::filesystem::path scene;
  std::optional<std::filesystem::path> mat;
  bool json = false, certify = false;
};

void print_signals(const LinearModel& linear, const StateSpace& system) {
  report::Table dofs({"dof", "unit", "q0", "dq0/dt"}, 2);
  for (size_t i = 0; i < linear.q_names.size(); ++i) {
    const auto k = static_cast<Index>(i);
    dofs.add({linear.q_names[i], linear.q_units[i], formatted("%.6g", linear.q_0(k)),
              formatted("%.6g", linear.q_dot_0(k))});
  }
  std::cout << dofs.print();
  const std::vector<ColumnInfo> columns = columns_of(system);
  report::Table inputs({"input", "unit", "columns of B and D", "u0"}, 3);
  for (size_t j = 0; j < system.inputs.size(); ++j) {
    const InputColumns& input = system.columns[j];
    const Index last = input.first + input.width();
    const std::string which =
        input.width() == 1
            ? formatted("%td", last)
            : formatted("%td-%td: acceleration, velocity, position", input.first + 1, last);
    inputs.add({system.inputs[j].name, system.inputs[j].unit, which,
                formatted("%.6g", system.u0(static_cast<Index>(j)))});
  }
  report::Table outputs({"output", "unit", "y0"}, 2);
  for (size_t i = 0; i < system.outputs.size(); ++i) {
    outputs.add({system.outputs[i].name, system.outputs[i].unit,
                 formatted("%.6g", system.y0(static_cast<Index>(i)))});
  }
  if (!system.inputs.empty()) std::cout << inputs.print();
  if (!system.outputs.empty()) std::cout << outputs.print();
}

void print_matrix(const std::string& title, const Eigen::MatrixXd& matrix,
                  Units units = Units::as_they_stand) {
  const std::string size = formatted(" (%td x %td)", matrix.rows(), matrix.cols());
  if (matrix.size() == 0) return;
  if (matrix.isZero(0)) {
    std::cout << title << size << " = 0\n";
  } else if (matrix.cols() > page_columns) {
    std::cout << title << size << ": too wide for the page, see --json or --mat\n";
  } else {
    std::cout << matrix_table(title + size, matrix, units);
  }
}

void print_page(const Scene& scene, const LinearModel& linear, const StateSpace& system) {
  std::cout << scene.title << ": linearised about " << operating_point_in_words(scene) << "\n"
            << formatted("degrees of freedom: %zu, inputs: %zu, outputs: %zu\n\n",
                         linear.q_names.size(), system.inputs.size(), system.outputs.size());
  print_signals(linear, system);
  std::cout << "\nM q'' + (C + D) q' + (K + N + G) q = forces of the inputs\n";
  const auto matrices = second_order_matrices(linear);
  for (size_t i = 0; i < 6; ++i) {
    print_matrix(matrices[i].first, *matrices[i].second, Units::of_dofs);
  }
  std::cout << "\nx' = A x + B u, y = C x + D u, x = (q, q')\n";
  print_matrix("A", system.A, Units::of_dofs);
  print_matrix("B", system.B);
  print_matrix("C", system.C);
  print_matrix("D", system.D);
}

Json json_of(const std::vector<BlockCertificate>& certificates) {
  Json list = Json::array();
  for (const BlockCertificate& c : certificates) {
    list.push_back({{"block", c.block},
                    {"difference", c.difference},
                    {"known_to", c.known_to},
                    {"size", c.size}});
  }
  return list;
}

void print_certificates(const std::vector<BlockCertificate>& certificates) {
  std::cout << "\nAgainst differences of the nonlinear equations\n";
  report::Table table({"block", "largest entry", "largest relative difference", "known to"}, 0);
  for (const BlockCertificate& c : certificates) {
    table.add({c.block, formatted("%.3g", c.size), formatted("%.1e", c.difference),
               formatted("%.1e", c.known_to)});
  }
  std::cout << table.print();
}

int run(const LineariseOptions& options) {
  require_own_places({{"the scene", options.scene}}, {{"--mat", options.mat}});
  Patience patience("reading the scene");
  const Scene scene = read_scene(options.scene);
  hint_at_units(scene);
  if (scene.reduction && options.certify) {
    throw InputError(
        scene.reduction->place +
        ": --certify compares the blocks of the whole model; take 'reduce' out for it");
  }
  const Model model = model_of(scene);
  patience.now("linearising");
  std::optional<ReducedModel> reduced;
  if (scene.reduction) reduced = stable_reduced_model(scene, {scene.inputs, scene.outputs});
  const LinearModel linear =
      reduced ? reduced->linear : linearise(model, scene.inputs, scene.outputs);
  const StateSpace system = state_space(linear);
  // What is not stable is not reduced.
  const Json stable = reduced ? Json(true) : warn_unless_stable(model, linear);
  std::vector<BlockCertificate> certificates;
  if (options.certify) {
    certificates = certify(scene, [&](double share) { patience.now("certifying", 100 * share); });
  }
  if (options.mat) write_mat(linear, system, *options.mat);
  if (options.json) {
    Json document{{"scene", scene.title},
                  {"scene_hash", scene.hash},
                  {"operating_point", operating_point_in_words(scene)},
                  {"stable", stable}};
    document.update(to_json(linear, system));
    document["nodal_displacements"] = to_json(model, node_displacements(model, linear.x_0));
    document["reduction"] = reduced ? reduction_json(*reduced) : Json();
    document["certificates"] = options.certify ? json_of(certificates) : Json();
    print(document);
  } else {
    print_page(scene, linear, system);
    if (reduced) std::cout << "\n" << reduction_text(*reduced);
    if (options.certify) print_certificates(certificates);
  }
  if (std::all_of(certificates.begin(), certificates.end(), is_certified)) return exit_done;
  std::cerr << "stillframe: a block is further than 1e-9 from the nonlinear equations, and than "
               "these are known\n";
  return exit_failed;
}

constexpr const char* linearise_footer =
    "M q'' + (C + D) q' + (K + N + G) q = forces, and x' = A x + B u, y = C x + D u with x = (q, "
    "q').\n"
    "A force, torque or stress has one column of B and D; a prescribed motion has three, for its\n"
    "acceleration, velocity and position, whichever of these the input is.\n"
    "Keys of --json, numbers with 17 digits, matrices as lists of rows:\n"
    "  scene, scene_hash, operating_point\n"
    "  stable        whether nothing grows about it, as `modes` judges; null: not known. Where it "
    "is\n"
    "                not stable a warning says so, exit code 0\n"
    "  dofs, dof_units, states, state_units   lists of texts\n"
    "  inputs        {name, unit, kind, columns: [{column, of, unit}]}, column from 0;\n"
    "                kind and of: direct, position, velocity or acceleration\n"
    "  outputs       {name, unit}\n"
    "  second_order  M, C, D, K, N, G, B, M_r ... G_r, Y_p, Y_v, Y_a, R_p, R_v, R_a, D_u\n"
    "  state_space   A, B, C, D\n"
    "  x0, u0, y0    state, inputs and outputs of the operating point\n"
    "  nodal_displacements  {node, displacement (m), rotation (rad, angle times axis)}\n"
    "  reduction     of a scene with `reduce`: {n_modes, n_corrections, to_hz, first_left_out_hz "
    "(null:\n"
    "                no mode is left out), bounds: [{hz, at_most, largest_singular_value}]}: "
    "at_most "
    "is\n"
    "                above the largest singular value of the difference from the whole model\n"
    "  certificates  with --certify: {block, difference, known_to, size}; C_y and D_y are C and D "
    "of the\n"
    "                state space, C and D those of the second-order form\n"
    "Names in --mat: A, B, C, D; M_bar, C_bar, D_bar, K_bar, N_bar, G_bar, B_bar; M_r ... D_u; x0, "
    "u0,\n"
    "y0; cell arrays state_, input_, output_names and _units, column_inputs, column_of, "
    "column_units.\n"
    "Example: stillframe linearise config/scenes/cart.yaml --mat cart.mat\n"
    "         octave --eval \"load cart.mat, eig(A)\"";

}  // namespace

void add_linearise(cli::Command& app, int& exit_code) {
  auto options = std::make_shared<LineariseOptions>();
  cli::Command verb =
      app.verb("linearise",
               "Linear model of a scene about its operating point: A, B, C, D and M, C, D, K, "
               "N, G with names, units and the operating point itself");
  verb.option("scene", options->scene, "Scene file (YAML)").required().type_name("SCENE");
  verb.flag("--json", options->json, "Print JSON (keys below)");
  verb.option("--mat", options->mat, "Write a MATLAB level-5 file too (names below)")
      .type_name("FILE");
  verb.flag("--certify", options->certify,
            "Compare every block with extrapolated differences of the nonlinear equations; "
            "exit code 4 if one is further than 1e-9 from them, and than their rounding lets "
            "them be known");
  verb.footer(linearise_footer);
  verb.runs([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace stillframe::tools

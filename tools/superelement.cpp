#include <Eigen/Geometry>
#include <iostream>
#include <memory>
#include <vector>

#include "core/errors/formatted.hpp"
#include "core/files/matrix_market.hpp"
#include "core/files/whole_file.hpp"
#include "core/mechanics/bodies/reduced_body.hpp"
#include "report/table.hpp"
#include "tools/given_files.hpp"
#include "tools/json.hpp"
#include "tools/patience.hpp"
#include "tools/unit_hint.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

namespace {

namespace fs = std::filesystem;

struct SuperelementOptions {
  fs::path job, out;
  std::vector<std::string> interfaces;
  int n_modes = 12;
  double modes_to_hz = 0;
  bool json = false;
};

/// NAME=SET or NAME=SET@x,y,z.
BodyInterface interface_of(const std::string& text, const FiniteElementBody& body) {
  const auto fail = [&](const std::string& why) {
    return InputError("--interface '" + text + "': " + why +
                      ", allowed is NAME=SET or NAME=SET@x,y,z");
  };
  const auto equals = text.find('='), at = text.find('@');
  if (equals == std::string::npos || equals == 0) throw fail("there is no name before a '='");
  BodyInterface interface;
  interface.name = text.substr(0, equals);
  if (interface.name.find_first_of(" /:#{}[],&*!|>'\"%@`") != std::string::npos) {
    throw fail("a name has letters, digits, '_', '-' and '.'");
  }
  const std::string set = text.substr(equals + 1, at == std::string::npos ? at : at - equals - 1);
  interface.nodes = node_set(body, set, "--interface '" + text + "'");
  if (at == std::string::npos) return interface;
  std::string_view rest = std::string_view(text).substr(at + 1);
  interface.point.emplace();
  for (int i = 0; i < 3; ++i) {
    if (i > 0 && !rest.starts_with(',')) throw fail("the point has not three numbers");
    if (i > 0) rest.remove_prefix(1);
    if (!take_number(rest, (*interface.point)(i))) throw fail("the point has not three numbers");
  }
  if (!rest.empty()) throw fail("something is behind the point");
  return interface;
}

struct BodyFiles {
  fs::path body, mass, stiffness;
};

BodyFiles files_of(const SuperelementOptions& options) {
  BodyFiles files;
  files.body = options.out;
  if (files.body.empty()) {
    files.body = options.job.filename();
    files.body.replace_extension(".body.yaml");
  }
  fs::path stem = files.body;
  stem.replace_extension();
  files.mass = files.stiffness = stem;
  files.mass += ".mass.mtx";
  files.stiffness += ".stiffness.mtx";
  return files;
}

/// The matrices first: a body file without them would be half a body.
void write(const FlexibleBody& body, const std::string& title, const BodyFiles& files) {
  for (const auto& why : {stiffness_fault(body), mass_fault(body)}) {
    if (why.empty()) continue;
    std::string message = title;
    message += ": ";
    throw InputError(message += why);
  }
  const std::string comment = "of " + files.body.filename().string();
  write_whole_file(files.mass, matrix_market(body.M, comment));
  write_whole_file(files.stiffness, matrix_market(body.K, comment));
  write_whole_file(files.body, flexible_body_text(body, title, files.mass.filename().string(),
                                                  files.stiffness.filename().string()));
}

void print_page(const FiniteElementBody& mesh, const ReducedBody& reduced, const BodyFiles& files) {
  const FlexibleBody& body = reduced.body;
  const RigidProperties rigid = rigid_properties(body);
  std::cout << mesh.name
            << formatted(": %td degrees of freedom become %td", mesh.K.rows(), body.M.rows())
            << formatted(" (%zu interfaces, %td modes)\n", body.interfaces.size(), body.n_modes)
            << formatted("mass %.6g kg, centre of mass %.6g, %.6g, %.6g m\n", rigid.mass,
                         rigid.centre.x(), rigid.centre.y(), rigid.centre.z());
  report::Table table({"mode", "Hz, free body"}, 0);
  for (Eigen::Index i = 0; i < reduced.frequencies_hz.size(); ++i) {
    table.add({formatted("%4td", i + 1), formatted("%.6g", reduced.frequencies_hz(i))});
  }
  if (body.n_modes > 0) std::cout << table.print();
  if (reduced.first_left_out_hz) {
    std::cout << formatted("left out from %.6g Hz on", *reduced.first_left_out_hz) << "\n";
  }
  std::cout << "written: " << files.body.string() << ", " << files.mass.string() << ", "
            << files.stiffness.string() << "\n";
}

/// CalculiX has no units: of a mesh in millimetres the mass is a thousandth, and all else looks
/// right.
void hint_at_units(const FiniteElementBody& mesh, const FlexibleBody& body) {
  Eigen::AlignedBox3d box;
  for (const auto& [number, position] : mesh.nodes) box.extend(position);
  for (const auto& point : body.points.colwise()) box.extend(Eigen::Vector3d(point));
  const double length = box.sizes().maxCoeff();
  if (length < longest_likely_m) return;
  std::cerr << formatted(
      "stillframe: note: mesh and interfaces are %.4g m long; if that is millimetres, mesh in "
      "metres, kilograms and pascals: every number of a body is in SI units\n",
      length);
}

int run(const SuperelementOptions& options) {
  if (options.interfaces.empty()) {
    throw InputError("--interface NAME=SET is needed at least once: where the body is held");
  }
  const BodyFiles files = files_of(options);
  require_own_places({{"the job", options.job}}, {{"--out", files.body},
                                                  {"the mass matrix", files.mass},
                                                  {"the stiffness matrix", files.stiffness}});
  Patience patience("reading the mesh");
  const auto stage = [&](const std::string& what) { patience.now(what); };
  const FiniteElementBody mesh = read_calculix(options.job, stage);
  std::vector<BodyInterface> interfaces;
  for (const std::string& text : options.interfaces) {
    interfaces.push_back(interface_of(text, mesh));
    for (std::size_t k = 0; k + 1 < interfaces.size(); ++k) {
      if (interfaces[k].name == interfaces.back().name) {
        throw InputError("--interface '" + text + "': there is an interface of that name already");
      }
    }
  }
  KeptModes kept{.n_modes = options.n_modes, .to_hz = {}};
  if (options.modes_to_hz > 0) kept.to_hz = options.modes_to_hz;
  const ReducedBody reduced = reduce_body(mesh, interfaces, kept, stage);
  hint_at_units(mesh, reduced.body);
  write(reduced.body, mesh.name, files);
  const RigidProperties rigid = rigid_properties(reduced.body);
  if (options.json) {
    print({{"body_file", files.body.string()},
           {"mass_file", files.mass.string()},
           {"stiffness_file", files.stiffness.string()},
           {"interfaces", reduced.body.interfaces},
           {"n_mesh_dofs", mesh.K.rows()},
           {"n_dofs", reduced.body.M.rows()},
           {"n_modes", reduced.body.n_modes},
           {"mass_kg", rigid.mass},
           {"centre_of_mass_m", tools::to_json(Eigen::VectorXd(rigid.centre))},
           {"inertia_kg_m2", tools::to_json(Eigen::MatrixXd(rigid.inertia))},
           {"mode_frequencies_hz", tools::to_json(reduced.frequencies_hz)},
           {"first_left_out_hz",
            reduced.first_left_out_hz ? Json(*reduced.first_left_out_hz) : Json(nullptr)}});
  } else {
    print_page(mesh, reduced, files);
  }
  return exit_done;
}

}  // namespace

void add_superelement(cli::Command& app, int& exit_code) {
  auto options = std::make_shared<SuperelementOptions>();
  cli::Command verb =
      app.verb("superelement", "A flexible body for scenes, from a mesh of CalculiX");
  verb.option("job", options->job, "JOB.inp, beside JOB.sti, JOB.mas and JOB.dof")
      .required()
      .type_name("JOB");
  verb.option(
          "--interface", options->interfaces,
          "A set of nodes that moves as one rigid piece, in the order of the scene's nodes; its "
          "point is the middle of the nodes, or x,y,z (m). Repeated")
      .type_name("NAME=SET[@x,y,z]");
  auto n_modes = verb.option("--modes", options->n_modes,
                             "How many modes of the free body are kept, the lowest first")
                     .check(cli::whole_number(0, 90))
                     .show_default();
  verb.option("--modes-to-hz", options->modes_to_hz, "All modes up to a frequency instead (Hz)")
      .check(cli::positive_number())
      .excludes(n_modes);
  verb.option("--out", options->out,
              "The body file (default: JOB.body.yaml here); its matrices are written beside it")
      .type_name("FILE.yaml");
  verb.flag("--json", options->json, "Print JSON (keys below)");
  verb.footer(
      "CalculiX writes the matrices of a free body of solid elements (not C3D8I; no *BOUNDARY) at\n"
      "  *STEP\n  *FREQUENCY, SOLVER=MATRIXSTORAGE\n  10\n  *END STEP\n"
      "They are reduced to static shapes of unit displacements and rotations of the interfaces, "
      "and\n"
      "the lowest modes of the body free in space, its interfaces rigid. Both are exact; what is\n"
      "between them is known up to the first frequency that is left out. A scene takes the file "
      "as\n"
      "  frame: {type: superelement, nodes: [p1, p2], body: frame.body.yaml}\n"
      "and checks it: symmetry, no stiffness against rigid motion, one mass in all directions, "
      "and\n"
      "the mass, centre of mass and inertia that the file states. SI units.\n"
      "Keys of --json:\n"
      "  body_file, mass_file, stiffness_file   what was written\n"
      "  interfaces, n_mesh_dofs, n_dofs, n_modes\n"
      "  mass_kg, centre_of_mass_m, inertia_kg_m2   about the centre of mass\n"
      "  mode_frequencies_hz, first_left_out_hz     of the free body; null: none is left out\n"
      "Example: stillframe superelement frame.inp --interface p1=FOOT1 --interface p2=FOOT2");
  verb.runs([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace stillframe::tools

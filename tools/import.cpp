#include <iostream>
#include <memory>

#include "core/errors/formatted.hpp"
#include "core/files/whole_file.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "tools/json.hpp"
#include "tools/spacar/dat_reader.hpp"
#include "tools/spacar/light_reader.hpp"
#include "tools/spacar/scene_text.hpp"
#include "tools/spacar/source_text.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

namespace {

struct ImportOptions {
  std::filesystem::path file, out;
  std::vector<std::string> given;
  bool json = false;
};

spacar::Model read_model(const ImportOptions& options) {
  const std::filesystem::path& file = options.file;
  const std::string kind = spacar::lower(file.extension().string());
  if (kind != ".dat" && kind != ".m") {
    throw InputError(file.string() +
                     ": found a file of another name, allowed are FILE.dat of "
                     "SPACAR and FILE.m of SPACAR Light");
  }
  if (kind == ".dat" && !options.given.empty()) {
    throw InputError("--set " + options.given.front() +
                     ": is for scripts (FILE.m); a .dat file has no variables");
  }
  const std::vector<std::string> lines = spacar::lines_of_file(file);
  return kind == ".dat" ? spacar::model_of_dat(lines, file.string())
                        : spacar::model_of_light(lines, file.string(), options.given);
}

/// A scene that its own reader would refuse is not written: what it says has its cause in the file.
void require_scene(const std::string& text, const std::filesystem::path& file) {
  try {
    static_cast<void>(parse_scene(text, "scene"));
  } catch (const InputError& error) {
    throw InputError(file.string() + ": makes no sound scene: " + error.what());
  }
}

Json to_json(const std::vector<spacar::Remark>& remarks) {
  Json all = Json::array();
  for (const spacar::Remark& remark : remarks) {
    all.push_back({{"line", remark.line}, {"what", remark.what}, {"why", remark.why}});
  }
  return all;
}

void print_remarks(const char* title, const std::vector<spacar::Remark>& remarks) {
  if (remarks.empty()) return;
  std::cout << title << "\n";
  for (const spacar::Remark& remark : remarks) {
    std::cout << "  line " << remark.line << ": " << spacar::shown(remark.what) << ": "
              << remark.why << "\n";
  }
}

int run(const ImportOptions& options) {
  spacar::Model model = read_model(options);
  const std::string text = spacar::scene_text(model);
  require_scene(text, options.file);
  std::filesystem::path out = options.out;
  if (out.empty()) out = options.file.filename().replace_extension(".yaml");
  std::error_code error;
  if (std::filesystem::equivalent(out, options.file, error)) {
    throw InputError("--out " + out.string() + ": is the file that is read, allowed is another");
  }
  write_whole_file(out, text);
  const spacar::Remarks& remarks = model.remarks;
  if (options.json) {
    print({{"scene", model.title},
           {"scene_file", out.string()},
           {"n_nodes", model.nodes.size()},
           {"n_elements", model.elements.size()},
           {"n_statements", model.n_statements},
           {"left_out", to_json(remarks.left_out)},
           {"approximated", to_json(remarks.approximated)},
           {"no_part", to_json(remarks.no_part)}});
  } else {
    std::cout << model.title << formatted(": %d statements become", model.n_statements)
              << formatted(" %zu nodes and", model.nodes.size())
              << formatted(" %zu elements\n", model.elements.size());
    print_remarks("Not in the scene:", remarks.left_out);
    print_remarks("In another form:", remarks.approximated);
    print_remarks("No part of a model:", remarks.no_part);
    std::cout << "written: " << out.string() << "\n";
  }
  return remarks.left_out.empty() ? exit_done : exit_failed;
}

}  // namespace

void add_import(cli::Command& app, int& exit_code) {
  auto options = std::make_shared<ImportOptions>();
  cli::Command verb = app.verb("import", "A scene, from a model of SPACAR or SPACAR Light");
  verb.option("file", options->file, "FILE.dat of SPACAR, or FILE.m that calls spacarlight")
      .required()
      .type_name("FILE");
  verb.option("--out", options->out, "The scene (default: FILE.yaml here)").type_name("FILE.yaml");
  verb.option("--set", options->given,
              "What a script has from elsewhere, as an argument of its function; may be repeated")
      .one_each_time()
      .type_name("NAME=VALUE");
  verb.flag("--json", options->json, "Print JSON (keys below)");
  verb.footer(
      "Each entry of the scene says from which line it came. What has no place in a scene is named "
      "with\n"
      "its line, in the scene too, and the exit code is 4; 0 if nothing is left out. Loads and\n"
      "displacements are those at the end of SPACAR's load steps. docs/import.md has a table of "
      "what\n"
      "becomes of each keyword, and of public models that were tried.\n"
      "Keys of --json:\n"
      "  scene, scene_file, n_nodes, n_elements, n_statements\n"
      "  left_out      what the scene does not say: line, what, why\n"
      "  approximated  what it says in another form: the same\n"
      "  no_part       pictures, step sizes, file names: the same\n"
      "Example: stillframe import crosshinge.m --out crosshinge.yaml");
  verb.runs([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace stillframe::tools

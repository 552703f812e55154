#include "core/mechanics/buckling.hpp"

#include <iostream>
#include <memory>
#include <optional>

#include "core/errors/formatted.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "core/mechanics/sparse/sparse_buckling.hpp"
#include "core/mechanics/sparse/sparse_scene.hpp"
#include "report/table.hpp"
#include "tools/json.hpp"
#include "tools/largest_parts.hpp"
#include "tools/patience.hpp"
#include "tools/unit_hint.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

namespace {

struct BucklingOptions {
  std::filesystem::path scene;
  int count = 10;
  bool json = false;
};

void print_page(const Scene& scene, const Buckling& result, Index shown) {
  if (shown == 0) {
    std::cout << scene.title << ": no multiple of the load makes it buckle\n";
    return;
  }
  std::cout << scene.title
            << formatted(": it buckles at %.6g times the load\n", result.load_multipliers(0));
  report::Table table({"shape", "load multiplier", "largest parts"}, 3);
  for (Index i = 0; i < shown; ++i) {
    table.add({formatted("%5td", i + 1), formatted("%15.6g", result.load_multipliers(i)),
               largest_parts(result.q_names, result.shapes.col(i))});
  }
  std::cout << table.print();
  if (shown < result.load_multipliers.size()) {
    std::cout << formatted("%td more: see --count\n", result.load_multipliers.size() - shown);
  }
}

Buckling smallest(const Scene& scene, Index count, Patience& patience) {
  const std::optional<Model> large = large_scene(scene, count);
  const bool sparse = large && large->q_r_0.isZero(0);
  if (sparse) {
    patience.now("load multipliers");
    return sparse_buckling(MixedModel(*large), count);
  }
  const Model model = make_model(scene);
  patience.now("load multipliers");
  return buckling(model);
}

int run(const BucklingOptions& options) {
  Patience patience("reading the scene");
  Scene scene = read_scene(options.scene);
  scene.modal_damping.reset();  // what is at rest asks for no modes
  hint_at_units(scene);
  const Buckling result = smallest(scene, options.count, patience);
  const Index shown = std::min<Index>(options.count, result.load_multipliers.size());
  if (options.json) {
    print({{"scene", scene.title},
           {"scene_hash", scene.hash},
           {"dofs", result.q_names},
           {"load_multipliers", to_json(Eigen::VectorXd(result.load_multipliers.head(shown)))},
           {"shapes", to_json(Eigen::MatrixXd(result.shapes.leftCols(shown)))}});
  } else {
    print_page(scene, result, shown);
  }
  return exit_done;
}

}  // namespace

void add_buckling(cli::Command& app, int& exit_code) {
  auto options = std::make_shared<BucklingOptions>();
  cli::Command verb = app.verb(
      "buckling", "Multiples of the scene's loads, gravity and preloads at which it buckles");
  verb.option("scene", options->scene, "Scene file (YAML) with a load")
      .required()
      .type_name("SCENE");
  verb.option("--count", options->count, "How many multipliers, the smallest first")
      .check(cli::whole_number(1, 1000000))
      .show_default();
  verb.flag("--json", options->json, "Print JSON (keys below)");
  verb.footer(
      "Solves (K + lambda G) v = 0 with K of the unloaded scene and G at the stresses that the "
      "load\n"
      "causes to first order. A load that pulls has no multiplier; one that follows its node is "
      "refused. Of a scene with `dofs: auto` and hundreds of beams only those of --count are "
      "looked "
      "for,\n"
      "and dofs are all free coordinates of the nodes.\n"
      "Keys of --json:\n"
      "  scene, scene_hash, dofs\n"
      "  load_multipliers  smallest first\n"
      "  shapes            a row a dof, a column a multiplier, largest entry 1\n"
      "Example: stillframe buckling column.yaml --count 3");
  verb.runs([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace stillframe::tools

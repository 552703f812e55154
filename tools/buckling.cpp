#include "core/buckling.hpp"

#include <algorithm>
#include <iostream>
#include <memory>
#include <numeric>

#include "core/scene/scene_reader.hpp"
#include "report/table.hpp"
#include "tools/json.hpp"
#include "tools/patience.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

namespace {

struct Options {
  std::filesystem::path scene;
  int count = 10;
  bool json = false;
};

/// The three largest entries of a shape: "tip.y 1, middle.y 0.5".
std::string in_words(const Buckling& result, Index mode) {
  const Eigen::VectorXd shape = result.shapes.col(mode);
  std::vector<Index> order(static_cast<size_t>(shape.size()));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](Index a, Index b) { return std::abs(shape(a)) > std::abs(shape(b)); });
  std::string text;
  for (size_t k = 0; k < std::min<size_t>(order.size(), 3); ++k) {
    // What is a thousandth of the largest is not seen in the shape.
    if (std::abs(shape(order[k])) < 1e-3) break;
    text += (text.empty() ? "" : ", ") + result.q_names[static_cast<size_t>(order[k])] +
            report::cell(" %.3g", shape(order[k]));
  }
  return text;
}

void print_page(const Scene& scene, const Buckling& result, Index shown) {
  if (shown == 0) {
    std::cout << scene.title << ": no multiple of the load makes it buckle\n";
    return;
  }
  std::cout << scene.title
            << report::cell(": it buckles at %.6g times the load\n", result.load_multipliers(0));
  report::Table table({"shape", "load multiplier", "largest parts"}, 3);
  for (Index i = 0; i < shown; ++i) {
    table.add({report::cell("%5td", i + 1), report::cell("%15.6g", result.load_multipliers(i)),
               in_words(result, i)});
  }
  std::cout << table.print();
  if (shown < result.load_multipliers.size()) {
    std::cout << report::cell("%td more: see --count\n", result.load_multipliers.size() - shown);
  }
}

int run(const Options& options) {
  Patience patience("reading the scene");
  const Scene scene = read_scene(options.scene);
  const Model model = make_model(scene);
  patience.now("load multipliers");
  const Buckling result = buckling(model);
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

void add_buckling(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<Options>();
  CLI::App* verb = app.add_subcommand(
      "buckling", "Multiples of the scene's loads, gravity and preloads at which it buckles");
  verb->add_option("scene", options->scene, "Scene file (YAML) with a load")
      ->required()
      ->type_name("SCENE");
  verb->add_option("--count", options->count, "How many multipliers, the smallest first")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  verb->add_flag("--json", options->json, "Print JSON (keys below)");
  verb->footer(
      "Solves (K + lambda G) v = 0 with K of the unloaded scene and G at the stresses that the "
      "load\n"
      "causes to first order. A load that pulls has no multiplier; one that follows its node is "
      "refused.\n"
      "Keys of --json:\n"
      "  scene, scene_hash, dofs\n"
      "  load_multipliers  smallest first\n"
      "  shapes            a row a dof, a column a multiplier, largest entry 1\n"
      "Example: stillframe buckling column.yaml --count 3");
  verb->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace stillframe::tools

// Global error against time of every method of the plant simulator on five scenes, each method
// against a reference of another formulation; and whether every method keeps to its tolerance on
// every scene that can be run, from quiet to loud.
#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "bench/machine.hpp"
#include "bench/plant_run.hpp"
#include "bench/work_precision_page.hpp"
#include "core/cli/command.hpp"
#include "core/numerics/two_pi.hpp"
#include "plant_sim/floor/sources.hpp"

namespace {

using namespace stillframe;
using nlohmann::json;

/// The references are a run in nodal coordinates at 1e-12 and one in minimal coordinates, by the
/// method that is the most accurate there: nothing is known below what the two differ by.
struct Case {
  std::string name, file, floor;
  Index samples;
  double force;  ///< N
  PlantMethod minimal = PlantMethod::exponential;
  double minimal_tolerance = 1e-12;
};

const std::vector<Case> cases{
    {"rigid frame", "config/scenes/metrology_frame", "multisine", 2000, 1.0},
    {"frame under gravity", "config/scenes/frame_under_gravity", "multisine", 1000, 1.0},
    {"flexible frame", "config/scenes/frame_flexible", "multisine", 400, 1.0},
    {"large motion", "config/scenes/swinging_boom", "", 4000, 0.5, PlantMethod::dormand_prince},
    {"chain of 50 beams", "bench/scenes/lattice_mast", "", 20, 1.0, PlantMethod::exponential, 1e-8},
};

const std::vector<double> tolerances{1e-3, 1e-5, 1e-7, 1e-9, 1e-11};

struct Options {
  std::string only;
  bool as_json = false, honesty = false;
  std::filesystem::path plots;
  int repeats = 3;
  double limit_s = 20;
};

class Bench {
 public:
  Bench(const Case& of, const Options& options)
      : case_(of),
        options_(options),
        top_(STILLFRAME_SOURCE_DIR),
        scene_(read_scene(top_ / (of.file + ".yaml"))) {}

  json run() {
    std::cerr << case_.name << ": references" << std::flush;
    nodal_ = at(PlantMethod::nodal, 1e-12, 1);
    minimal_ = at(case_.minimal, case_.minimal_tolerance, 1);
    known_acceleration_ = relative_difference(nodal_.acceleration, minimal_.acceleration);
    known_sigma_ = relative_difference(nodal_.sigma, minimal_.sigma);
    json result{{"scene", case_.name},
                {"file", case_.file},
                {"samples", case_.samples},
                {"minimal", method_name(case_.minimal)},
                {"known_acceleration", known_acceleration_},
                {"known_sigma", known_sigma_},
                {"points", json::array()}};
    for (const auto& [name, method] : plant_methods) {
      std::cerr << ", " << name << std::flush;
      bool too_slow = false;
      for (const double tolerance : settings(method)) {
        if (too_slow) break;
        too_slow = !add_point(method, tolerance, result["points"]);
      }
    }
    std::cerr << "\n";
    return result;
  }

 private:
  /// Tolerances; nothing to choose for linear.
  static std::vector<double> settings(PlantMethod method) {
    if (method == PlantMethod::linear) return {1e-5};
    if (method == PlantMethod::automatic) return {1e-5, 1e-8};
    return tolerances;
  }

  PlantRun at(PlantMethod method, double setting, Index part) {
    scene_.simulation.method = method;
    scene_.simulation.relative_tolerance = setting;
    const std::filesystem::path floor =
        case_.floor.empty() ? "" : top_ / "config/floors" / (case_.floor + ".yaml");
    return run_plant(scene_, floor, std::max<Index>(case_.samples / part, 2), case_.force);
  }

  /// Of another formulation than the method; `auto` may be of either, and has the worse of both.
  std::vector<const PlantRun*> references(PlantMethod method) const {
    if (method == PlantMethod::nodal) return {&minimal_};
    if (method == PlantMethod::automatic) return {&nodal_, &minimal_};
    return {&nodal_};
  }

  /// False if it would take longer than there is time for.
  bool add_point(PlantMethod method, double setting, json& points) {
    json point{{"method", method_name(method)}, {"setting", setting}};
    try {
      const double estimate =
          1e-6 * at(method, setting, 50).us_per_sample * static_cast<double>(case_.samples);
      if (estimate * options_.repeats > options_.limit_s) {
        point["skipped"] = "would take " + std::to_string(estimate) + " s";
        points.push_back(point);
        return false;
      }
      std::vector<double> times;
      PlantRun run;
      for (int i = 0; i < options_.repeats; ++i) {
        run = at(method, setting, 1);
        times.push_back(run.us_per_sample);
      }
      std::nth_element(times.begin(), times.begin() + options_.repeats / 2, times.end());
      point["us_per_sample"] = times[static_cast<size_t>(options_.repeats / 2)];
      point["evaluations_per_sample"] = run.evaluations_per_sample;
      // Two references differ by what either is wrong by: no error below that is known.
      double acceleration = known_acceleration_, sigma = known_sigma_;
      for (const PlantRun* reference : references(method)) {
        acceleration =
            std::max(acceleration, relative_difference(run.acceleration, reference->acceleration));
        sigma = std::max(sigma, relative_difference(run.sigma, reference->sigma));
      }
      point["error_acceleration"] = acceleration;
      point["error_sigma"] = sigma;
    } catch (const std::exception& error) {
      point["skipped"] = error.what();
    }
    points.push_back(point);
    return true;
  }

  const Case& case_;
  const Options& options_;
  std::filesystem::path top_;
  Scene scene_;
  PlantRun nodal_, minimal_;
  double known_acceleration_ = 0, known_sigma_ = 0;
};

/// A scene that can be run: with accelerations as inputs and outputs, and a control rate. What has
/// none gets those of its prescribed and of its heaviest nodes along their axes, and 1 kHz.
std::optional<Scene> runnable(const std::filesystem::path& file) {
  Scene scene = read_scene(file);
  const auto is_other = [](const SceneSignal& s) { return s.quantity != Quantity::acceleration; };
  std::erase_if(scene.inputs, is_other);
  std::erase_if(scene.outputs, is_other);
  std::erase_if(scene.monitors, is_other);
  const auto signal = [](const std::string& node, const Eigen::Vector3d& direction) {
    SceneSignal made;
    made.name = node;
    made.node = node;
    made.quantity = Quantity::acceleration;
    made.direction = direction;
    return made;
  };
  for (const SceneConstraint& motion : scene.prescribed) {
    if (!scene.inputs.empty() || motion.directions.empty()) continue;
    scene.inputs.push_back(signal(motion.node, motion.directions.front()));
  }
  if (scene.inputs.empty()) return std::nullopt;
  const auto heaviest =
      std::max_element(scene.masses.begin(), scene.masses.end(),
                       [](const auto& a, const auto& b) { return a.mass < b.mass; });
  if (scene.outputs.empty() && heaviest != scene.masses.end()) {
    scene.outputs = {signal(heaviest->node, Eigen::Vector3d::UnitX()),
                     signal(heaviest->node, Eigen::Vector3d::UnitY())};
  }
  if (scene.outputs.empty()) return std::nullopt;
  if (!scene.controller) {
    scene.controller.emplace();
    scene.controller->sample_rate_hz = 1000;
  }
  return scene;
}

/// Errors of all nonlinear methods on one scene under one drive, in tolerances.
json honesty(Scene scene, double floor, Index samples) {
  const auto n_legs = static_cast<Index>(scene.controller->legs.size());
  const auto n_inputs = static_cast<Index>(scene.inputs.size());
  // A force that moves a leg as the floor does: 1 N on some 10 kg.
  const double force = 10 * floor;
  Eigen::MatrixXd courses(n_inputs, samples);
  for (Index k = 0; k < samples; ++k) {
    const double t = static_cast<double>(k) / scene.controller->sample_rate_hz;
    courses.col(k) = 0.3 * floor * forces_of_sample(n_inputs, k + 1000, 1.0);
    courses.col(k).array() += floor * std::sin(two_pi * 2 * t);
  }
  const auto run = [&](PlantMethod method, double tolerance) {
    scene.simulation.method = method;
    scene.simulation.relative_tolerance = tolerance;
    return run_plant(scene,
                     std::make_unique<floor::TabulatedFloor>(floor::FloorChannels::inputs, courses),
                     samples, n_legs > 0 ? force : 0);
  };
  json result{{"floor", floor}};
  try {
    const PlantRun nodal = run(PlantMethod::nodal, 1e-12);
    // Of all that is in minimal coordinates the one that shares nothing with collocation.
    const PlantRun minimal = run(PlantMethod::dormand_prince, 1e-12);
    const auto error = [](const PlantRun& a, const PlantRun& b) {
      const double sigma = b.sigma.isZero(0) ? 0 : relative_difference(a.sigma, b.sigma);
      return std::max(relative_difference(a.acceleration, b.acceleration), sigma);
    };
    result["known"] = error(nodal, minimal);
    for (const auto& [name, method] : plant_methods) {
      if (method == PlantMethod::linear) continue;
      for (const double tolerance : {1e-5, 1e-8}) {
        const PlantRun found = run(method, tolerance);
        // `auto` may be any of them: the worse of both.
        double worst = 0;
        if (method != PlantMethod::nodal) worst = error(found, nodal);
        if (method == PlantMethod::nodal || method == PlantMethod::automatic) {
          worst = std::max(worst, error(found, minimal));
        }
        result[std::string(name)].push_back(worst / tolerance);
      }
    }
  } catch (const std::exception& why) {
    result["skipped"] = why.what();
  }
  return result;
}

/// Every scene of config/scenes and bench/scenes that can be run, from quiet to loud, and the boom
/// at 100 Hz.
json all_honesty() {
  const std::filesystem::path top(STILLFRAME_SOURCE_DIR);
  std::vector<std::pair<std::string, Scene>> scenes;
  std::set<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(top / "config/scenes")) {
    files.insert(entry.path());
  }
  for (const auto& file : files) {
    if (const auto scene = runnable(file)) scenes.emplace_back(file.stem(), *scene);
  }
  scenes.emplace_back("swinging_boom at 100 Hz",
                      *runnable(top / "config/scenes/swinging_boom.yaml"));
  scenes.back().second.controller->sample_rate_hz = 100;
  json all = json::array();
  for (const auto& [name, scene] : scenes) {
    std::cerr << name << "\n";
    const Index samples = scene.controller->sample_rate_hz < 500 ? 500 : 200;
    for (const double floor : {1e-6, 1e-3, 1.0, 10.0}) {
      json row = honesty(scene, floor, samples);
      row["scene"] = name;
      all.push_back(row);
    }
  }
  return all;
}

}  // namespace

int main(int argc, char** argv) {
  cli::Command app(
      "Error against time of every method of the plant simulator on five scenes.\n"
      "Times are processor time of the one thread, the median of the repeats.",
      "bench_work_precision");
  Options options;
  app.flag("--honesty", options.honesty,
           "Instead: the error of every method in tolerances, on every scene of config/scenes "
           "that can be run, from quiet to loud");
  app.option("--only", options.only, "Only scenes whose name has this in it");
  app.flag("--json", options.as_json, "JSON in the place of Markdown");
  app.option("--plots", options.plots, "Draw a picture of each scene there")
      .check(cli::existing_folder())
      .type_name("DIR");
  app.option("--repeats", options.repeats, "Runs of each point")
      .check(cli::whole_number(1, 100))
      .show_default();
  app.option("--limit", options.limit_s, "Points that would take longer are left out, s")
      .check(cli::positive_number())
      .show_default();
  try {
    if (const auto code = app.parse(argc, argv)) return *code;
    json all{{"machine", machine_line(STILLFRAME_FLAGS)}, {"scenes", json::array()}};
    if (options.honesty) {
      const json rows = all_honesty();
      std::cout << (options.as_json ? rows.dump(1) + "\n" : honesty_markdown(rows));
      return 0;
    }
    for (const Case& of : cases) {
      if (of.name.find(options.only) == std::string::npos) continue;
      all["scenes"].push_back(Bench(of, options).run());
    }
    if (!options.plots.empty()) plot_work_precision(all, options.plots);
    std::cout << (options.as_json ? all.dump(1) + "\n" : work_precision_markdown(all));
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "bench_work_precision: " << error.what() << "\n";
    return 4;
  }
}

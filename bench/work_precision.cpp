// Global error against time of every method of the plant simulator on five scenes. The reference of
// a scene is a run at a tolerance of 1e-13, checked by a run of another formulation or method.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>

#include "bench/machine.hpp"
#include "bench/plant_run.hpp"
#include "bench/work_precision_page.hpp"

namespace {

using namespace stillframe;
using nlohmann::json;

const std::vector<PlantMethod> methods{
    PlantMethod::linear,   PlantMethod::exponential, PlantMethod::dormand_prince,
    PlantMethod::fehlberg, PlantMethod::runge_kutta, PlantMethod::implicit_runge_kutta,
    PlantMethod::adams,    PlantMethod::bdf,         PlantMethod::nodal,
    PlantMethod::ida,      PlantMethod::automatic,
};

struct Case {
  std::string name, file, floor;
  Index samples;
  double force;  ///< N
  PlantMethod reference, check;
  double check_tolerance;
};

const std::vector<Case> cases{
    {"rigid frame", "config/scenes/metrology_frame", "multisine", 2000, 1.0, PlantMethod::fehlberg,
     PlantMethod::nodal, 1e-12},
    {"frame under gravity", "config/scenes/frame_under_gravity", "multisine", 1000, 1.0,
     PlantMethod::fehlberg, PlantMethod::nodal, 1e-12},
    {"flexible frame", "config/scenes/frame_flexible", "multisine", 400, 1.0, PlantMethod::fehlberg,
     PlantMethod::nodal, 1e-12},
    {"large motion", "config/scenes/swinging_boom", "", 4000, 0.5, PlantMethod::fehlberg,
     PlantMethod::nodal, 1e-12},
    {"chain of 50 beams", "bench/scenes/lattice_mast", "", 20, 1.0, PlantMethod::nodal,
     PlantMethod::dormand_prince, 1e-8},
};

const std::vector<double> tolerances{1e-3, 1e-5, 1e-7, 1e-9, 1e-11};

struct Options {
  std::string only;
  bool as_json = false;
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
    std::cerr << case_.name << ": reference" << std::flush;
    const PlantRun reference =
        at(case_.reference, case_.reference == PlantMethod::nodal ? 1e-12 : 1e-13, 1);
    const PlantRun check = at(case_.check, case_.check_tolerance, 1);
    json result{
        {"scene", case_.name},
        {"file", case_.file},
        {"samples", case_.samples},
        {"check_acceleration", relative_difference(check.acceleration, reference.acceleration)},
        {"check_sigma", relative_difference(check.sigma, reference.sigma)},
        {"points", json::array()}};
    for (const PlantMethod method : methods) {
      std::cerr << ", " << method_name(method) << std::flush;
      bool too_slow = false;
      for (const double tolerance : settings(method)) {
        if (too_slow) break;
        too_slow = !add_point(method, tolerance, reference, result["points"]);
      }
    }
    std::cerr << "\n";
    return result;
  }

 private:
  /// Tolerances; of the method of equal steps the numbers of steps; nothing to choose for linear.
  static std::vector<double> settings(PlantMethod method) {
    if (method == PlantMethod::linear) return {1e-5};
    if (method == PlantMethod::automatic) return {1e-5, 1e-8};
    if (method == PlantMethod::runge_kutta) return {1, 2, 4, 8, 16};
    return tolerances;
  }

  PlantRun at(PlantMethod method, double setting, Index part) {
    scene_.simulation.method = method;
    if (method == PlantMethod::runge_kutta) {
      scene_.simulation.steps_per_sample = static_cast<int>(setting);
    } else {
      scene_.simulation.relative_tolerance = setting;
    }
    const std::filesystem::path floor =
        case_.floor.empty() ? "" : top_ / "config/floors" / (case_.floor + ".yaml");
    return run_plant(scene_, floor, std::max<Index>(case_.samples / part, 2), case_.force);
  }

  /// False if it would take longer than there is time for.
  bool add_point(PlantMethod method, double setting, const PlantRun& reference, json& points) {
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
      point["error_acceleration"] = relative_difference(run.acceleration, reference.acceleration);
      point["error_sigma"] = relative_difference(run.sigma, reference.sigma);
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
};

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Error against time of every method of the plant simulator on five scenes.\n"
      "Times are processor time of the one thread, the median of the repeats.",
      "bench_work_precision");
  Options options;
  app.add_option("--only", options.only, "Only scenes whose name has this in it");
  app.add_flag("--json", options.as_json, "JSON in the place of Markdown");
  app.add_option("--plots", options.plots, "Draw a picture of each scene there")
      ->check(CLI::ExistingDirectory)
      ->type_name("DIR");
  app.add_option("--repeats", options.repeats, "Runs of each point")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  app.add_option("--limit", options.limit_s, "Points that would take longer are left out, s")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  try {
    app.parse(argc, argv);
    json all{{"machine", machine_line(STILLFRAME_FLAGS)}, {"scenes", json::array()}};
    for (const Case& of : cases) {
      if (of.name.find(options.only) == std::string::npos) continue;
      all["scenes"].push_back(Bench(of, options).run());
    }
    if (!options.plots.empty()) plot_work_precision(all, options.plots);
    std::cout << (options.as_json ? all.dump(1) + "\n" : work_precision_markdown(all));
    return 0;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    std::cerr << "bench_work_precision: " << error.what() << "\n";
    return 4;
  }
}

// How fast the single-process closed loop of the rigid frame is, at what error, and what each
// fidelity option costs over the bare scene.
#include <algorithm>
#include <functional>
#include <iostream>
#include <nlohmann/json.hpp>

#include "bench/machine.hpp"
#include "bench/plant_run.hpp"
#include "core/cli/command.hpp"
#include "core/errors/formatted.hpp"
#include "judge/loop_design.hpp"
#include "tools/run/closed_loop.hpp"

namespace {

using namespace stillframe;
using nlohmann::json;

const std::filesystem::path config = std::filesystem::path(STILLFRAME_SOURCE_DIR) / "config";

/// A closed loop of so many samples: its signals, and processor time a sample (us).
struct LoopRun {
  Eigen::MatrixXd acceleration, sigma;
  double us = 0;
};

LoopRun run_loop(const judge::LoopDesign& design, const Scene& scene, Index samples) {
  tools::ClosedLoop loop(scene, design.gains, floor_of(scene, config / "floors/multisine.yaml"), 1,
                         true);
  const auto n_y = static_cast<Index>(scene.outputs.size());
  const auto n_legs = static_cast<Index>(scene.controller->legs.size());
  LoopRun run{Eigen::MatrixXd(samples, n_y), Eigen::MatrixXd(samples, n_legs)};
  const double begin = thread_seconds();
  for (Index k = 0; k < samples; ++k) {
    if (const auto reason = loop.step(); !reason.empty()) throw std::runtime_error(reason);
    const auto& read = loop.measurement();
    run.acceleration.row(k) =
        Eigen::Map<const Eigen::RowVectorXd>(read.frame_acceleration.data(), n_y);
    run.sigma.row(k) = Eigen::Map<const Eigen::RowVectorXd>(read.sigma.data(), n_legs);
  }
  run.us = 1e6 * (thread_seconds() - begin) / static_cast<double>(samples);
  return run;
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

Scene with_method(Scene scene, PlantMethod method, double tolerance) {
  scene.simulation.method = method;
  scene.simulation.relative_tolerance = tolerance;
  return scene;
}

json closed_loop(Index samples, int repeats) {
  const auto design = judge::make_loop_design(config / "scenes/metrology_frame.yaml", std::nullopt);
  const Scene& scene = design.scene;
  const LoopRun nodal = run_loop(design, with_method(scene, PlantMethod::nodal, 1e-12), samples);
  const LoopRun minimal =
      run_loop(design, with_method(scene, PlantMethod::exponential, 1e-12), samples);
  const double known_acceleration = relative_difference(nodal.acceleration, minimal.acceleration);
  const double known_sigma = relative_difference(nodal.sigma, minimal.sigma);
  struct Row {
    PlantMethod method;
    double tolerance;
  };
  json rows = json::array();
  for (const Row& row : {Row{PlantMethod::exponential, 1e-5}, Row{PlantMethod::exponential, 1e-8},
                         Row{PlantMethod::linear, 1e-5}, Row{PlantMethod::dormand_prince, 1e-8},
                         Row{PlantMethod::nodal, 1e-5}, Row{PlantMethod::nodal, 1e-8}}) {
    std::vector<double> times;
    LoopRun run;
    for (int i = 0; i < repeats; ++i) {
      run = run_loop(design, with_method(scene, row.method, row.tolerance), samples);
      times.push_back(run.us);
    }
    const double us = median(times);
    const LoopRun& reference = row.method == PlantMethod::nodal ? minimal : nodal;
    rows.push_back(
        {{"method", method_name(row.method)},
         {"tolerance", row.tolerance},
         {"us_per_sample", us},
         {"times_real_time", 1e6 / scene.controller->sample_rate_hz / us},
         {"error_acceleration",
          std::max(relative_difference(run.acceleration, reference.acceleration),
                   known_acceleration)},
         {"error_sigma", std::max(relative_difference(run.sigma, reference.sigma), known_sigma)}});
  }
  return {{"samples", samples}, {"reference_check", known_acceleration}, {"rows", rows}};
}

struct Fidelity {
  std::string name;
  std::function<void(Scene&)> add;
};

std::vector<Fidelity> options() {
  using Errors = ForceSensorErrors;
  const auto sensors = [](Scene& scene) -> Errors& {
    if (!scene.instruments.force_sensors) scene.instruments.force_sensors.emplace();
    return *scene.instruments.force_sensors;
  };
  return {
      {"bare", [](Scene&) {}},
      {"leg damping",
       [](Scene& scene) {
         for (SceneElement& e : scene.elements) {
           if (e.kind == SceneElement::Kind::truss) e.damping(0, 0) = 1000;
         }
       }},
      {"gravity",
       [](Scene& scene) { scene = read_scene(config / "scenes/frame_under_gravity.yaml"); }},
      {"amplifier lag 300 Hz", [](Scene& s) { s.instruments.actuator_lag_hz = 300; }},
      {"sensor filter 300 Hz", [](Scene& s) { s.instruments.sensor_filter_hz = 300; }},
      {"force limit", [](Scene& s) { s.controller->force_limit_n = 0.5; }},
      {"delay of 1.4 samples (two parts)", [](Scene& s) { s.controller->delay_samples = 1.4; }},
      {"hysteresis 10 %",
       [](Scene& s) {
         s.instruments.hysteresis =
             HysteresisLoop{.width = 0.1, .swing_n = 1, .saturation_n = 1, .gamma_over_beta = 0.3};
       }},
      {"force rate limit", [](Scene& s) { s.instruments.force_rate_limit = 2000; }},
      {"sensor noise", [=](Scene& s) { sensors(s).noise = 1e-3; }},
      {"flicker noise",
       [=](Scene& s) {
         sensors(s).noise = 1e-3;
         sensors(s).flicker_below_hz = 10;
       }},
      {"quantisation, offset, drift",
       [=](Scene& s) {
         sensors(s).quantisation = 1e-3;
         sensors(s).offset = {0.1};
         sensors(s).drift = {1e-3};
       }},
      {"floor sensor noise",
       [](Scene& s) { s.instruments.floor_sensors = FloorSensorErrors{.noise = 1e-6, .seed = 1}; }},
      {"a disturbing force",
       [](Scene& s) {
         SceneDisturbance push;
         push.name = "push";
         push.node = "lens";
         push.direction = Eigen::Vector3d::UnitX();
         push.force = ForceSine{.at_s = 0, .amplitude = 1, .frequency_hz = 3};
         s.disturbances = {push};
       }},
      {"flexible arms",
       [](Scene& s) {
         const auto simulation = s.simulation;
         s = read_scene(config / "scenes/frame_flexible.yaml");
         s.simulation = simulation;
       }},
      {"small motion (linear)", [](Scene& s) { s.simulation.method = PlantMethod::linear; }},
  };
}

json fidelity(Index samples, int repeats) {
  const std::vector<Fidelity> all = options();
  std::vector<std::vector<double>> times(all.size());
  std::vector<std::string> methods(all.size());
  // Turn by turn, so that what disturbs the machine meets all alike.
  for (int i = 0; i < repeats; ++i) {
    for (size_t j = 0; j < all.size(); ++j) {
      Scene scene = read_scene(config / "scenes/metrology_frame.yaml");
      all[j].add(scene);
      PlantRun run;
      try {
        run = run_plant(scene, config / "floors/multisine.yaml", samples, 1.0);
      } catch (const std::runtime_error& error) {
        throw std::runtime_error(all[j].name + ": " + error.what());
      }
      times[j].push_back(run.us_per_sample);
    }
  }
  json rows = json::array();
  const double bare = median(times[0]);
  for (size_t j = 0; j < all.size(); ++j) {
    rows.push_back({{"option", all[j].name},
                    {"us_per_sample", median(times[j])},
                    {"over_bare", median(times[j]) / bare}});
  }
  return rows;
}

std::string markdown(const json& all) {
  const json& loop = all.at("closed_loop");
  std::string text =
      "| method | tolerance | us a sample | times real time at 1 kHz | error of accelerations | "
      "error of sigma |\n|---|---|---|---|---|---|\n";
  for (const json& row : loop.at("rows")) {
    text +=
        "| `" + row.at("method").get<std::string>() + "` | " +
        formatted("%g | %.3g | %.0f | %.1e | %.1e |\n", row.at("tolerance").get<double>(),
                  row.at("us_per_sample").get<double>(), row.at("times_real_time").get<double>(),
                  row.at("error_acceleration").get<double>(), row.at("error_sigma").get<double>());
  }
  text += formatted("\nReference and check differ by %.1e.\n\n",
                    loop.at("reference_check").get<double>());
  text += "| option | us a sample | over the bare frame |\n|---|---|---|\n";
  for (const json& row : all.at("fidelity")) {
    text += "| " + row.at("option").get<std::string>() +
            formatted(" | %.3g | %.2f |\n", row.at("us_per_sample").get<double>(),
                      row.at("over_bare").get<double>());
  }
  return text;
}

}  // namespace

int main(int argc, char** argv) {
  cli::Command app(
      "Speed of the single-process closed loop against its error, and the cost of each fidelity\n"
      "option. Times are processor time of the one thread, medians of the repeats.",
      "bench_plant_speed");
  Index samples = 4000;
  int repeats = 5;
  bool as_json = false, machine_only = false;
  app.option("--samples", samples, "Samples of each run")
      .check(cli::whole_number(10, 1'000'000))
      .show_default();
  app.option("--repeats", repeats, "Runs of each").check(cli::whole_number(1, 100)).show_default();
  try {
    app.flag("--json", as_json, "JSON in the place of Markdown");
    app.flag("--machine", machine_only, "Say what it runs on, and nothing else");
    if (const auto code = app.parse(argc, argv)) return *code;
    if (machine_only) {
      std::cout << machine_line(STILLFRAME_FLAGS) << "\n";
      return 0;
    }
    const json all{{"machine", machine_line(STILLFRAME_FLAGS)},
                   {"closed_loop", closed_loop(samples, repeats)},
                   {"fidelity", fidelity(samples, repeats)}};
    std::cout << (as_json ? all.dump(1) + "\n" : markdown(all));
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "bench_plant_speed: " << error.what() << "\n";
    return 4;
  }
}

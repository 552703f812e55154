#include <algorithm>
#include <iostream>
#include <memory>
#include <thread>

#include "msgs/stop_signal.hpp"
#include "report/table.hpp"
#include "tools/exit_code.hpp"
#include "tools/json.hpp"
#include "tools/patience.hpp"
#include "tools/run/study.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

namespace {

struct BatchOptions {
  std::vector<std::filesystem::path> scenes, controllers, floors;
  std::optional<double> duration_s;
  int jobs = 0;
  bool json = false;
};

/// Every scene with every controller and every floor.
std::vector<StudyCase> cases_of(const BatchOptions& options) {
  using Block = std::optional<std::filesystem::path>;
  const auto or_own = [](const std::vector<std::filesystem::path>& files) {
    return files.empty() ? std::vector<Block>{std::nullopt}
                         : std::vector<Block>(files.begin(), files.end());
  };
  std::vector<StudyCase> cases;
  for (const auto& scene : options.scenes) {
    for (const Block& controller : or_own(options.controllers)) {
      for (const Block& floor : or_own(options.floors)) {
        cases.push_back({.scene = scene, .controller = controller, .floor = floor});
      }
    }
  }
  return cases;
}

/// The name of a file without folder and ending, or all of it where another file has that name too.
std::string label(const std::optional<std::filesystem::path>& file,
                  const std::vector<std::filesystem::path>& files) {
  if (!file) return "(scene's)";
  const bool alone = std::none_of(files.begin(), files.end(), [&](const auto& other) {
    return other != *file && other.stem() == file->stem();
  });
  return alone ? file->stem().string() : file->string();
}

Json to_json(const StudyCase& study, const StudyResult& result) {
  Json row{{"scene_file", study.scene.string()},
           {"controller_file", study.controller ? study.controller->string() : ""},
           {"floor_file", study.floor ? study.floor->string() : ""}};
  if (!result.failure.empty()) {
    row["failure"] = result.failure;
    return row;
  }
  row["outcome"] = report::to_text(result.verdict.judgement.outcome);
  row["reason"] = result.verdict.judgement.reason;
  row["method"] = result.method;
  row["n_samples"] = result.n_samples;
  row["peak_force_n"] = result.peak_force;
  row["rms_force_n"] = result.rms_force;
  row["n_saturated"] = result.verdict.runs.back().n_saturated;
  row["real_time_factor"] = result.times_real_time;
  row["axes"] = Json::array();
  for (const auto& axis : result.verdict.axes) {
    row["axes"].push_back(
        {{"axis", axis.axis},
         {"floor_rms_m_s2", axis.floor ? Json(axis.floor->rms_acceleration) : Json(nullptr)},
         {"passive_rms_m_s2", axis.passive->rms_acceleration},
         {"active_rms_m_s2", axis.active->rms_acceleration},
         {"active_vibration_class", axis.active->vibration_class}});
  }
  return row;
}

std::string table_of(const BatchOptions& options, const std::vector<StudyCase>& cases,
                     const std::vector<StudyResult>& results) {
  using report::cell;
  report::Table table({"scene", "controller", "floor", "axis", "floor um/s^2", "passive", "active",
                       "class", "verdict", "peak N", "real time x"},
                      4);
  for (size_t i = 0; i < cases.size(); ++i) {
    std::string scene = label(cases[i].scene, options.scenes),
                controller = label(cases[i].controller, options.controllers),
                floor = label(cases[i].floor, options.floors);
    const StudyResult& result = results[i];
    if (!result.failure.empty()) {
      table.add({scene, controller, floor, "", "", "", "", "", "did not run", "", ""});
      continue;
    }
    std::string outcome(report::to_text(result.verdict.judgement.outcome)),
        peak = cell("%.3g", result.peak_force), speed = cell("%.0f", result.times_real_time);
    for (const auto& axis : result.verdict.axes) {
      table.add({scene, controller, floor, axis.axis,
                 axis.floor ? cell("%.4g", 1e6 * axis.floor->rms_acceleration) : "-",
                 cell("%.4g", 1e6 * axis.passive->rms_acceleration),
                 cell("%.4g", 1e6 * axis.active->rms_acceleration), axis.active->vibration_class,
                 outcome, peak, speed});
      scene = controller = floor = outcome = peak = speed = "";
    }
    // A scene that compares nothing ran all the same.
    if (result.verdict.axes.empty()) {
      table.add({scene, controller, floor, "-", "-", "-", "-", "-", outcome, peak, speed});
    }
  }
  return table.print();
}

int run(const BatchOptions& options) {
  const std::vector<StudyCase> cases = cases_of(options);
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  const int jobs =
      std::min(options.jobs > 0 ? options.jobs : cores, static_cast<int>(cases.size()));
  catch_stop_signals();
  std::vector<StudyResult> results;
  {
    Patience patience("simulating " + std::to_string(cases.size()) + " runs");
    results = run_cases(cases, options.duration_s, jobs, [&](std::size_t n_done) {
      patience.now("simulating " + std::to_string(cases.size()) + " runs",
                   100.0 * static_cast<double>(n_done) / static_cast<double>(cases.size()));
    });
  }
  if (options.json) {
    Json rows = Json::array();
    for (size_t i = 0; i < cases.size(); ++i) rows.push_back(to_json(cases[i], results[i]));
    print(rows);
  } else {
    std::cout << table_of(options, cases, results);
  }
  int code = exit_done;
  for (size_t i = 0; i < cases.size(); ++i) {
    const auto& [outcome, reason, checks] = results[i].verdict.judgement;
    const bool ran = results[i].failure.empty();
    if (ran && exit_code_of(outcome) == exit_done) continue;
    code = exit_failed;
    std::cerr << "stillframe: " << cases[i].scene.string() << ", "
              << label(cases[i].controller, options.controllers) << ", "
              << label(cases[i].floor, options.floors) << ": "
              << (ran ? reason : results[i].failure) << "\n";
  }
  return code;
}

}  // namespace

void add_batch(cli::Command& app, int& exit_code) {
  auto options = std::make_shared<BatchOptions>();
  cli::Command verb = app.verb(
      "batch", "Simulate every scene with every controller and floor, on all cores, without LCM");
  verb.option("scenes", options->scenes, "Scene files (YAML)").required().type_name("SCENE");
  verb.option("--controller", options->controllers,
              "Controller blocks, each in the place of the scene's; may be given again")
      .type_name("FILE");
  verb.option("--floor", options->floors,
              "Floor blocks, each in the place of the scene's; may be given again")
      .type_name("FILE");
  verb.option("--duration", options->duration_s,
              "Seconds of plant time (default: the scene's, or the floor's)")
      .check(cli::positive_number());
  verb.option("--jobs", options->jobs, "Runs at a time; 0: one for each core. Changes no result")
      .check(cli::whole_number(0, 1024));
  verb.flag(
      "--json", options->json,
      "JSON: a row a run, with outcome and reason, axes (rms in 1 to 80 Hz), forces and failures");
  verb.footer(
      "Example: which target frequency isolates best on which floor?\n"
      "  stillframe batch config/scenes/metrology_frame.yaml \\\n"
      "    --controller config/controllers/force_feedback_5hz.yaml \\\n"
      "    --controller config/controllers/force_feedback_8hz.yaml \\\n"
      "    --floor config/floors/vc_d.yaml --floor config/floors/quake.yaml\n"
      "Every run is that of `stillframe run --mode single_process`, passive and active, without a "
      "log.\n"
      "Each is judged as `run` judges it, but for the prediction, which needs a log.\n"
      "Exit code 4: a run failed, or did not meet what its scene accepts; the others are "
      "reported.");
  verb.runs([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace stillframe::tools

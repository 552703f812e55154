#include <algorithm>
#include <iostream>
#include <memory>

#include "core/errors/formatted.hpp"
#include "report/table.hpp"
#include "tools/batch_rows.hpp"
#include "tools/given_files.hpp"
#include "tools/row_place.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

namespace {

struct BatchOptions {
  std::vector<std::filesystem::path> scenes, controllers, floors;
  std::optional<double> duration_s;
  std::optional<std::filesystem::path> out;
  std::string shard, on;
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

/// Of the file that a row tells; none: the scene's own.
std::optional<std::filesystem::path> file_of(const Json& row, const char* key) {
  const auto file = row[key].get<std::string>();
  return file.empty() ? std::nullopt : std::optional<std::filesystem::path>(file);
}

std::string table_of(const BatchOptions& options, const std::vector<Json>& rows) {
  report::Table table({"scene", "controller", "floor", "axis", "floor um/s^2", "passive", "active",
                       "class", "verdict", "peak N", "real time x"},
                      4);
  const auto micro = [](const Json& rms) {
    return rms.is_number() ? formatted("%.4g", 1e6 * rms.get<double>()) : "-";
  };
  for (const Json& row : rows) {
    std::string scene = label(file_of(row, "scene_file"), options.scenes),
                controller = label(file_of(row, "controller_file"), options.controllers),
                floor = label(file_of(row, "floor_file"), options.floors);
    if (row.contains("failure")) {
      table.add({scene, controller, floor, "", "", "", "", "", "did not run", "", ""});
      continue;
    }
    std::string outcome = row["outcome"],
                peak = formatted("%.3g", row["peak_force_n"].get<double>()),
                speed = formatted("%.0f", row["real_time_factor"].get<double>());
    for (const Json& axis : row["axes"]) {
      table.add({scene, controller, floor, axis["axis"], micro(axis["floor_rms_m_s2"]),
                 micro(axis["passive_rms_m_s2"]), micro(axis["active_rms_m_s2"]),
                 axis["active_vibration_class"], outcome, peak, speed});
      scene = controller = floor = outcome = peak = speed = "";
    }
    // A scene that compares nothing ran all the same.
    if (row["axes"].empty()) {
      table.add({scene, controller, floor, "-", "-", "-", "-", "-", outcome, peak, speed});
    }
  }
  return table.print();
}

int run(const BatchOptions& options) {
  std::vector<GivenFile> read;
  for (const auto* files : {&options.scenes, &options.controllers, &options.floors}) {
    for (const auto& file : *files) read.push_back({"a block", file});
  }
  require_own_places(read, {{"--out", options.out}});
  const RowPlace place = row_place(options.shard, options.on, options.out);
  const std::vector<StudyCase> cases = cases_of(options);
  const auto rows =
      rows_at(place, batch_study(cases, options.duration_s), batch_rows, options.jobs);
  if (!rows) return exit_done;
  if (options.json) {
    print(Json(*rows));
  } else {
    std::cout << table_of(options, *rows);
  }
  int code = exit_done;
  for (const Json& row : *rows) {
    const bool ran = !row.contains("failure");
    if (ran && row["outcome"] != report::to_text(report::Outcome::failed)) continue;
    code = exit_failed;
    std::cerr << "stillframe: " << row["scene_file"].get<std::string>() << ", "
              << label(file_of(row, "controller_file"), options.controllers) << ", "
              << label(file_of(row, "floor_file"), options.floors) << ": "
              << row[ran ? "reason" : "failure"].get<std::string>() << "\n";
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
  add_row_place(verb, "Only every N-th run, from the I-th: of one of N jobs", options->shard,
                options->on, options->out);
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
      "--out FILE gets a line of JSON a run, as --json prints it, once it has ended; what stands\n"
      "there already, of files that hold the same, does not run again. --shard, `stillframe "
      "merge`\n"
      "and --on are those of `stillframe sweep --help`.\n"
      "Exit code 4: a run failed, or did not meet what its scene accepts; the others are "
      "reported.");
  verb.runs([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace stillframe::tools

#include <cmath>
#include <iostream>
#include <memory>
#include <optional>

#include "core/errors/formatted.hpp"
#include "core/errors/input_error.hpp"
#include "core/numerics/decibels.hpp"
#include "core/yaml/to_number.hpp"
#include "report/table.hpp"
#include "tools/given_files.hpp"
#include "tools/row_place.hpp"
#include "tools/sweep_rows.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

namespace {

struct SweepOptions {
  std::filesystem::path scene;
  std::optional<std::filesystem::path> controller, out;
  std::vector<std::string> set, at_hz;
  std::string shard, on;
  int jobs = 0;
  bool json = false;
};

SweepQuestion question_of(const SweepOptions& options) {
  std::vector<SweptKey> keys;
  for (const std::string& text : options.set) keys.push_back(parse_swept_key(text));
  SweepQuestion question{
      read_scene_blocks(options.scene, options.controller), SweepGrid(std::move(keys)), {}};
  for (const std::string& text : options.at_hz) {
    const std::optional<double> hz = to_number(text);
    if (!hz || !(*hz > 0)) {
      throw InputError("--at: found '" + text + "', allowed are numbers above 0, as in --at 10,50");
    }
    question.at_hz.push_back(*hz);
  }
  // A path that names nothing is one mistake and not one a point.
  with_values(question.blocks, question.grid.keys(), question.grid.values(0));
  return question;
}

std::string shown(const Json& value, const char* format) {
  return value.is_number() ? formatted(format, value.get<double>()) : "-";
}

std::string in_decibels(double value) {
  // No sign of what is shown as zero.
  return formatted("%.2f", std::abs(value) < 0.005 ? 0.0 : value);
}

/// Of a singular value.
std::string shown_in_decibels(const Json& value) {
  return value.is_number() ? in_decibels(decibels(value.get<double>())) : "-";
}

void print_table(const std::string& title, const SweepQuestion& question,
                 const std::vector<Json>& rows) {
  std::vector<std::string> header;
  for (const SweptKey& key : question.grid.keys()) header.push_back(key.path);
  const auto n_left = header.size();
  header.insert(header.end(), {"radius", "disk", "at Hz", "price dB", "peak dB", "at Hz"});
  for (const double hz : question.at_hz) header.push_back(formatted("%g Hz dB", hz));
  report::Table table(header, n_left);
  for (const Json& row : rows) {
    std::vector<std::string> cells;
    for (const SweptKey& key : question.grid.keys()) cells.push_back(row["set"].at(key.path));
    if (!row["failure"].is_null()) {
      cells.resize(header.size());
      cells[n_left + 1] = "no design";
    } else {
      const Json& price = row["price_of_sampling_db"];
      cells.push_back(shown(row["spectral_radius"], "%.6f"));
      cells.push_back(row["stable"] ? shown(row["disk_margin"], "%.3f") : "not stable");
      cells.push_back(shown(row["disk_margin_hz"], "%.3g"));
      cells.push_back(price.is_number() ? in_decibels(price) : "-");
      cells.push_back(shown_in_decibels(row["peak"]));
      cells.push_back(shown(row["peak_hz"], "%.3g"));
      for (const Json& line : row["transmission"]) {
        cells.push_back(shown_in_decibels(line["singular_value"]));
      }
    }
    table.add(cells);
  }
  std::cout << title << ": " << rows.size() << " of " << question.grid.size()
            << " designs; peak and the last columns: largest singular value of T, floor to "
               "outputs, of the loop that runs\n"
            << table.print();
}

int run(const SweepOptions& options) {
  require_own_places({{"the scene", options.scene}, {"the controller block", options.controller}},
                     {{"--out", options.out}});
  const RowPlace place = row_place(options.shard, options.on, options.out);
  const SweepQuestion question = question_of(options);
  const auto rows = rows_at(place, sweep_study(question), sweep_rows, options.jobs);
  if (!rows) return exit_done;
  const std::string title = question.blocks.scene.require("title").text();
  if (options.json) {
    print(Json{{"scene", title}, {"n_points", question.grid.size()}, {"rows", *rows}});
  } else {
    print_table(title, question, *rows);
  }
  constexpr int most_said = 10;
  int n_failed = 0;
  for (const Json& row : *rows) {
    if (row["failure"].is_null() || ++n_failed > most_said) continue;
    std::cerr << "stillframe:";
    for (const auto& [path, value] : row["set"].items()) {
      std::cerr << " " << path << "=" << value.get<std::string>();
    }
    std::cerr << ": " << row["failure"].get<std::string>() << "\n";
  }
  if (n_failed > most_said) {
    std::cerr << "stillframe: and " << n_failed - most_said << " more without a design\n";
  }
  return n_failed == 0 ? exit_done : exit_failed;
}

constexpr const char* sweep_footer =
    "PATH is the key as the scene has it, with dots: controller.target_hz, controller.legs.1,\n"
    "elements.leg_1.stiffness; of lists the number of the item or the name of its node:\n"
    "masses.table.mass; * stands for any part of a name: elements.leg_*.stiffness, which get one\n"
    "value together. A controller block in a file of its own is read as if it stood in the scene.\n"
    "What is swept has to be written there. Several --set make every combination.\n"
    "\n"
    "A row a design: spectral radius of the loop that runs (below 1: stable), all-leg disk margin\n"
    "and where it is least, price of sampling, and the largest singular value of T, floor to\n"
    "outputs: its peak, and at the frequencies of --at.\n"
    "\n"
    "--out FILE gets a line of JSON a design, as soon as it is done; what stands there already, "
    "of\n"
    "the same scene and version, is not computed again. So an interrupted sweep goes on, and "
    "files\n"
    "of shards are put together by `stillframe merge` or cat. On a cluster with Slurm\n"
    "  stillframe sweep SCENE --set PATH=1:10:500 --out all.jsonl --on slurm:32\n"
    "writes all.jsonl.sbatch and submits it: 32 tasks, and a job that puts their rows together in\n"
    "all.jsonl. What sbatch takes from its environment (SBATCH_PARTITION, SBATCH_TIMELIMIT, ...)\n"
    "holds. With GNU parallel:\n"
    "  seq 100 | parallel stillframe sweep SCENE --set PATH=1:10:500 --shard {}/100 \\\n"
    "    --out part_{}.jsonl\n"
    "  stillframe merge part_*.jsonl --out all.jsonl\n"
    "Then, as after Slurm, the table: the same command without --shard or --on.\n"
    "\n"
    "Keys of --json:\n"
    "  scene, n_points (of all shards)\n"
    "  rows  version, scene_hash (of that point), set (PATH: value, as written), stable,\n"
    "        spectral_radius, disk_margin, disk_margin_hz, price_of_sampling_db, peak, peak_hz,\n"
    "        transmission [{hz, singular_value}], failure; null for what a design has not\n"
    "Exit code 4: a point has no design (ten are said in a line each), or the sweep was "
    "interrupted; a "
    "loop\n"
    "that is not stable is a result.\n"
    "Example: stillframe sweep config/scenes/metrology_frame.yaml --set controller.target_hz=3,5,8 "
    "\\\n"
    "  --set controller.sample_rate_hz=500,1000,2000 --at 10,50";

}  // namespace

void add_sweep(cli::Command& app, int& exit_code) {
  auto options = std::make_shared<SweepOptions>();
  cli::Command verb =
      app.verb("sweep", "Designs of a scene over ranges of any of its keys, as a table");
  verb.option("scene", options->scene, "Scene file (YAML) with a controller block")
      .required()
      .type_name("SCENE");
  verb.option("--set", options->set,
              "PATH=VALUE,VALUE,... or PATH=FROM:TO:COUNT or PATH=FROM:TO:COUNT:log; may be given "
              "again")
      .required()
      .one_each_time()
      .type_name("PATH=VALUES");
  verb.option("--controller", options->controller, "Controller block that replaces the scene's")
      .type_name("FILE");
  verb.option("--at", options->at_hz, "Frequencies, Hz, at which T is told")
      .delimiter(',')
      .type_name("HZ,...");
  add_row_place(verb, "Only every N-th point, from the I-th: of one of N jobs", options->shard,
                options->on, options->out);
  verb.option("--jobs", options->jobs, "Designs at a time; 0: one for each core. Changes no result")
      .check(cli::whole_number(0, 1024));
  verb.flag("--json", options->json, "Print JSON (keys below)");
  verb.footer(sweep_footer);
  verb.runs([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace stillframe::tools

#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>
#include <mutex>
#include <thread>

#include "core/control/robustness/parallel.hpp"
#include "core/errors/input_error.hpp"
#include "core/numerics/decibels.hpp"
#include "msgs/stop_signal.hpp"
#include "report/table.hpp"
#include "tools/given_files.hpp"
#include "tools/patience.hpp"
#include "tools/shard_option.hpp"
#include "tools/sweep_rows.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

namespace {

struct SweepOptions {
  std::filesystem::path scene;
  std::optional<std::filesystem::path> controller, out;
  std::vector<std::string> set, at_hz;
  std::string shard;
  int jobs = 0;
  bool json = false;
};

SweepQuestion question_of(const SweepOptions& options) {
  std::vector<SweptKey> keys;
  for (const std::string& text : options.set) keys.push_back(parse_swept_key(text));
  SweepQuestion question{
      read_scene_blocks(options.scene, options.controller), SweepGrid(std::move(keys)), {}};
  for (const std::string& text : options.at_hz) {
    char* end = nullptr;
    const double hz = std::strtod(text.c_str(), &end);
    if (*end != '\0' || !(hz > 0) || !std::isfinite(hz)) {
      throw InputError("--at: found '" + text + "', allowed are numbers above 0, as in --at 10,50");
    }
    question.at_hz.push_back(hz);
  }
  // A path that names nothing is one mistake and not one a point.
  with_values(question.blocks, question.grid.keys(), question.grid.values(0));
  return question;
}

std::string shown(double value, const char* format) {
  return std::isfinite(value) ? report::cell(format, value) : "-";
}

std::string in_decibels(double value) {
  // No sign of what is shown as zero.
  return shown(std::abs(value) < 0.005 ? 0.0 : value, "%.2f");
}

void print_table(const std::string& title, const SweepQuestion& question,
                 const std::vector<SweepRow>& rows) {
  std::vector<std::string> header;
  for (const SweptKey& key : question.grid.keys()) header.push_back(key.path);
  const auto n_left = header.size();
  header.insert(header.end(), {"radius", "disk", "at Hz", "price dB", "peak dB", "at Hz"});
  for (const double hz : question.at_hz) header.push_back(report::cell("%g Hz dB", hz));
  report::Table table(header, n_left);
  for (const SweepRow& row : rows) {
    std::vector<std::string> cells = row.values;
    if (!row.failure.empty()) {
      cells.resize(header.size());
      cells[n_left + 1] = "no design";
    } else {
      cells.push_back(shown(row.radius, "%.6f"));
      cells.push_back(row.stable ? shown(row.disk, "%.3f") : "not stable");
      cells.push_back(shown(row.disk_hz, "%.3g"));
      cells.push_back(in_decibels(row.price_db));
      cells.push_back(in_decibels(decibels(row.peak)));
      cells.push_back(shown(row.peak_hz, "%.3g"));
      for (const double value : row.transmission) cells.push_back(in_decibels(decibels(value)));
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
  const robustness::Shard shard = parse_shard(options.shard);
  const SweepQuestion question = question_of(options);
  std::optional<SweepFile> file;
  if (options.out) file.emplace(*options.out);
  const std::size_t n = shard.size(question.grid.size());
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  catch_stop_signals();
  std::vector<SweepRow> rows(n);
  std::vector<char> done(n, 0);
  {
    Patience patience("designs");
    std::mutex mutex;
    std::size_t n_done = 0;
    robustness::parallel_for(n, options.jobs > 0 ? options.jobs : cores, [&](std::uint64_t i, int) {
      if (stop_requested()) return;
      const std::size_t point = i * shard.of + shard.number - 1;
      std::optional<SweepRow> known;
      if (file) known = file->find(question, point);
      rows[i] = known ? std::move(*known) : sweep_row(question, point);
      const std::lock_guard lock(mutex);
      if (file && !known) file->add(question, rows[i]);
      done[i] = 1;
      patience.now("designs", 100 * static_cast<double>(++n_done) / static_cast<double>(n));
    });
  }
  if (const auto missing = std::count(done.begin(), done.end(), 0); missing > 0) {
    throw Failure("interrupted with " + std::to_string(missing) + " of " + std::to_string(n) +
                  " designs missing" +
                  (file ? "; the same command goes on with " + options.out->string() : ""));
  }
  const std::string title = question.blocks.scene.require("title").text();
  if (options.json) {
    Json document{{"scene", title}, {"n_points", question.grid.size()}, {"rows", Json::array()}};
    for (const SweepRow& row : rows) document["rows"].push_back(to_json(question, row));
    print(document);
  } else {
    print_table(title, question, rows);
  }
  constexpr int most_said = 10;
  int n_failed = 0;
  for (const SweepRow& row : rows) {
    if (row.failure.empty() || ++n_failed > most_said) continue;
    std::cerr << "stillframe:";
    for (std::size_t k = 0; k < row.values.size(); ++k) {
      std::cerr << " " << question.grid.keys()[k].path << "=" << row.values[k];
    }
    std::cerr << ": " << row.failure << "\n";
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
    "of shards are put together by cat. Many machines, with Slurm or with GNU parallel:\n"
    "  sbatch --array=1-100 --wrap 'stillframe sweep SCENE --set PATH=1:10:500 \\\n"
    "    --shard ${SLURM_ARRAY_TASK_ID}/100 --out part_${SLURM_ARRAY_TASK_ID}.jsonl'\n"
    "  seq 100 | parallel stillframe sweep SCENE --set PATH=1:10:500 --shard {}/100 \\\n"
    "    --out part_{}.jsonl\n"
    "Then\n"
    "  cat part_*.jsonl > all.jsonl\n"
    "  stillframe sweep SCENE --set PATH=1:10:500 --out all.jsonl\n"
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
      .type_name("PATH=VALUES");
  verb.option("--controller", options->controller, "Controller block that replaces the scene's")
      .type_name("FILE");
  verb.option("--at", options->at_hz, "Frequencies, Hz, at which T is told")
      .delimiter(',')
      .type_name("HZ,...");
  verb.option("--shard", options->shard, "Only every N-th point, from the I-th: of one of N jobs")
      .type_name("I/N");
  verb.option("--out", options->out, "File of rows that are kept and need not be computed again")
      .type_name("FILE");
  verb.option("--jobs", options->jobs, "Designs at a time; 0: one for each core. Changes no result")
      .check(cli::whole_number(0, 1024));
  verb.flag("--json", options->json, "Print JSON (keys below)");
  verb.footer(sweep_footer);
  verb.runs([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace stillframe::tools

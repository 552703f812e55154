#include <iostream>
#include <memory>

#include "core/errors/input_error.hpp"
#include "judge/page_of.hpp"
#include "judge/verdict_of.hpp"
#include "report/page/write_page.hpp"
#include "tools/exit_code.hpp"
#include "tools/given_files.hpp"
#include "tools/patience.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

namespace {

struct ReportOptions {
  std::vector<std::filesystem::path> paths;
  std::optional<std::filesystem::path> out, verdict;
  std::optional<std::int64_t> run_id;
  std::optional<int> plant;
  double segment_s = 64;
  report::ComparisonRule comparison = {};
  bool json = false;
};

/// The logs of a run directory, or the log itself.
std::vector<std::filesystem::path> logs_of(const ReportOptions& options) {
  std::vector<std::filesystem::path> logs;
  std::error_code ignored;
  for (const auto& path : options.paths) {
    if (!std::filesystem::is_directory(path, ignored)) {
      logs.push_back(path);
      continue;
    }
    if (options.run_id) {
      throw InputError("--run-id: " + path.string() +
                       " is a folder, whose loops are runs with a number each; allowed is a log");
    }
    const std::size_t before = logs.size();
    for (const char* name : {"passive.lcm", "active.lcm"}) {
      if (std::filesystem::exists(path / name, ignored)) logs.push_back(path / name);
    }
    if (logs.size() == before) {
      throw InputError(path.string() +
                       ": no run directory, it holds neither passive.lcm nor active.lcm");
    }
  }
  return logs;
}

/// Beside what it is made of: report.html in a run directory, NAME.html for NAME.lcm.
std::filesystem::path place_of(const ReportOptions& options) {
  if (options.out) return *options.out;
  std::filesystem::path first = options.paths.front();
  std::error_code ignored;
  if (std::filesystem::is_directory(first, ignored)) return first / "report.html";
  return first.replace_extension(".html");
}

int run(const ReportOptions& options) {
  const std::vector<std::filesystem::path> logs = logs_of(options);
  const std::filesystem::path place = place_of(options);
  std::vector<GivenFile> read;
  for (const auto& log : logs) read.push_back({"the log", log});
  require_own_places(read, {{options.out ? "--out" : "the report without --out", place},
                            {"--verdict", options.verdict}});
  Patience patience("reading");
  std::vector<judge::LogToAnalyse> to_read;
  for (const auto& log : logs) {
    const std::string name = "reading " + log.filename().string();
    to_read.push_back(
        {log,
         {.run_id = options.run_id,
          .plant = options.plant,
          .segment_s = options.segment_s,
          .comparison = options.comparison,
          .progress = [&patience, name](double share) { patience.now(name, 100 * share); }}});
  }
  const judge::RunAnalyses runs = judge::analyse_runs(std::move(to_read));
  patience.now("writing the report");
  const report::Verdict verdict = judge::verdict_of(runs);
  page::write_page(judge::page_of(runs, verdict), place);
  if (options.verdict) report::write_json(verdict, *options.verdict);
  std::cout << (options.json ? report::to_json(verdict) : report::to_text(verdict));
  if (!options.json) std::cout << "Report: " << place.string() << "\n";
  return exit_code_of(verdict.judgement.outcome);
}

}  // namespace

void add_report(cli::Command& app, int& exit_code) {
  auto options = std::make_shared<ReportOptions>();
  cli::Command verb = app.verb(
      "report", "One HTML file that shows what logs say and what was predicted; opens anywhere");
  verb.option("paths", options->paths,
              "Run directory, or one or two LCM logs (passive and active loop of one scene)")
      .required()
      .type_name("DIR|LOG");
  verb.option("--out", options->out,
              "The HTML file (default: report.html in the run directory, NAME.html beside "
              "NAME.lcm)")
      .type_name("FILE");
  verb.option("--verdict", options->verdict, "Write the verdict as JSON too").type_name("FILE");
  verb.option("--run-id", options->run_id,
              "The run to take from a log that holds several; not for a folder");
  verb.option("--plant", options->plant,
              "The plant to take, from 1, of a run that several measured, as one does that "
              "was killed and came back (default: the last)");
  verb.option("--segment", options->segment_s,
              "Broadband identification: s of what is transformed at once; longer is finer")
      .check(cli::positive_number())
      .show_default();
  verb.option("--tolerance-db", options->comparison.tolerance_db,
              "How far a prediction may lie outside the band of a measured value")
      .check(cli::number_from_zero())
      .show_default();
  verb.flag("--json", options->json, "Print the verdict as JSON");
  verb.footer(
      "Reads each log once, in memory that does not grow with it. Predictions and mode shapes are\n"
      "those of the scene and the gains that the log holds; no other file is needed. Damaged logs\n"
      "give what is readable, and the report says what was not.\n"
      "Keys of --json: docs/json/verdict.schema.json.\n"
      "Exit code 4: what the scene accepts (its block `accept`, or the defaults of docs/scene.md) "
      "was\n"
      "not met: a damaged log, limited or lost commands, a frame that moves too much, a loop that\n"
      "is not what was predicted. A log that shows nothing to judge by is \"not judged\", exit 0.\n"
      "Example: stillframe report runs/metrology_frame-20260101-120000");
  verb.runs([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace stillframe::tools

#include <iostream>
#include <memory>

#include "core/errors/formatted.hpp"
#include "core/errors/input_error.hpp"
#include "report/export/log_export.hpp"
#include "tools/given_files.hpp"
#include "tools/json.hpp"
#include "tools/patience.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

namespace {

struct ExportOptions {
  std::filesystem::path log;
  std::optional<std::filesystem::path> csv, mat;
  report::ExportSettings settings;
  bool json = false;
};

Json to_json(const report::ExportSummary& summary, const std::filesystem::path& file,
             const char* format) {
  const auto& info = summary.scan.info;
  Json columns = Json::array();
  for (const report::SignalColumn& column : summary.columns) {
    columns.push_back({{"name", column.label()},
                       {"unit", column.group->unit},
                       {"variable", column.group->variable}});
  }
  return {{"file", file.string()},
          {"format", format},
          {"bytes", summary.n_bytes},
          {"run_id", std::to_string(info.run_id)},
          {"scene", info.scene_name},
          {"loop", info.loop},
          {"sample_rate_hz", info.sample_rate_hz},
          {"n_rows", summary.n_rows},
          {"first_s", summary.first_s},
          {"last_s", summary.last_s},
          {"columns", columns},
          {"n_lost", summary.scan.measurements.n_lost},
          {"n_damaged", summary.scan.n_damaged + summary.scan.n_undecodable},
          {"unread_bytes", summary.scan.unread_bytes}};
}

void print_page(const report::ExportSummary& summary, const std::filesystem::path& file) {
  const report::LogScan& scan = summary.scan;
  std::cout << file.string() << ": "
            << formatted("%lld samples of %zu signals, %.6g to %.6g s of run %lld (%s), %.3g MB",
                         static_cast<long long>(summary.n_rows), summary.columns.size(),
                         summary.first_s, summary.last_s, static_cast<long long>(scan.info.run_id),
                         scan.info.loop.c_str(), 1e-6 * static_cast<double>(summary.n_bytes))
            << "\n";
  if (scan.measurements.n_lost > 0) {
    std::cout << "The whole run has lost " << scan.measurements.n_lost
              << " samples; they have no row, seq and time_s jump there.\n";
  }
  if (scan.n_damaged + scan.n_undecodable + scan.unread_bytes > 0) {
    std::cout << "The log is damaged in " << scan.n_damaged + scan.n_undecodable << " places, and "
              << scan.unread_bytes << " bytes at its end could not be read.\n";
  }
}

int run(const ExportOptions& options) {
  if (!options.csv && !options.mat) {
    throw InputError("export: say where to, --csv FILE or --mat FILE");
  }
  require_own_places({{"the log", options.log}}, {{"--csv", options.csv}, {"--mat", options.mat}});
  Patience patience("reading " + options.log.string());
  report::ExportSettings settings = options.settings;
  Json documents = Json::array(), warnings = Json::array();
  const auto write = [&](const std::filesystem::path& file, const char* format, auto&& how) {
    settings.progress = [&](double share) {
      patience.now("writing " + file.string(), 100 * share);
    };
    const report::ExportSummary summary = how(options.log, settings, file);
    const std::string plants = plants_in_words(summary.scan);
    // The same of every file.
    if (!plants.empty() && warnings.empty()) warnings.push_back(plants);
    if (options.json) {
      documents.push_back(to_json(summary, file, format));
    } else {
      print_page(summary, file);
    }
  };
  if (options.csv) write(*options.csv, "csv", report::export_csv);
  if (options.mat) write(*options.mat, "mat", report::export_mat);
  if (options.json) {
    print({{"files", documents}, {"warnings", warnings}});
  } else {
    for (const auto& warning : warnings) {
      std::cout << "Warning: " << warning.get<std::string>() << "\n";
    }
  }
  return exit_done;
}

constexpr const char* export_footer =
    "Columns: seq and time_s (plant time), then the signals, floor:NAME and frame:NAME in m/s^2\n"
    "(floor: the scene's inputs; frame: its outputs and monitors, those of floor points too),\n"
    "sigma:LEG, applied:LEG and command:LEG in N. A lost sample has no row; a sample without an\n"
    "answer has NaN for its commands. Numbers read back to the same bits. docs/exports.md has the\n"
    "line to load each file in Octave, MATLAB and Python.\n"
    "Keys of --json:\n"
    "  files    a list: file, format, bytes, run_id, scene, loop, sample_rate_hz, n_rows,\n"
    "           first_s, last_s, columns [{name, unit, variable (of the .mat file)}], n_lost,\n"
    "           n_damaged, unread_bytes\n"
    "  warnings a list of texts: that several plants measured the run\n"
    "Example: stillframe export active.lcm --csv active.csv --channels floor,frame --to 10";

}  // namespace

void add_export(cli::Command& app, int& exit_code) {
  auto options = std::make_shared<ExportOptions>();
  cli::Command verb = app.verb(
      "export", "The signals of a log as text or as a MATLAB file, one column each with its unit");
  verb.option("log", options->log, "LCM log").required().type_name("LOG");
  verb.option("--csv", options->csv, "Write RFC 4180 text").type_name("FILE");
  verb.option("--mat", options->mat, "Write a MATLAB level-5 file").type_name("FILE");
  verb.option("--run-id", options->settings.run_id, "Which run, if the log holds several");
  verb.option("--plant", options->settings.plant,
              "Which plant, from 1, if several measured the run, as one does that was killed "
              "and came back (default: the last)");
  verb.option("--from", options->settings.from_s, "First second of plant time")
      .default_text("the first");
  verb.option("--to", options->settings.to_s, "Last second of plant time").default_text("the last");
  verb.option("--channels", options->settings.channels,
              "Only these: floor, sigma, applied, frame, command, excitation, or single ones as in "
              "frame:lens_x")
      .delimiter(',');
  verb.flag("--json", options->json, "Print JSON (keys below)");
  verb.footer(export_footer);
  verb.runs([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace stillframe::tools

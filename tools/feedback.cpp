#include <cmath>
#include <iostream>
#include <memory>
#include <optional>

#include "core/errors/formatted.hpp"
#include "core/errors/input_error.hpp"
#include "core/files/whole_file.hpp"
#include "core/numerics/decibels.hpp"
#include "core/yaml/reader.hpp"
#include "report/plots/plot_margins.hpp"
#include "report/table.hpp"
#include "tools/feedback_study.hpp"
#include "tools/given_files.hpp"
#include "tools/json.hpp"
#include "tools/patience.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

namespace {

struct FeedbackOptions {
  std::filesystem::path scene;
  std::optional<std::filesystem::path> controller, plot, h2, minimax;
  FeedbackWish wish;
  bool json = false;
};

std::string db_cell(double ratio) {
  const double db = decibels(ratio);
  // No minus before nothing.
  return formatted("%.1f", std::abs(db) < 0.05 ? 0.0 : db);
}

std::string page(const judge::LoopDesign& design, const FeedbackStudy& study) {
  std::string text =
      design.scene.title + "\n" +
      formatted(
          "%g Hz, delay %g samples, feedback alone; wished: disk margin %g, isolation to %g Hz\n\n",
          design.gains.sample_rate_hz, design.gains.delay_samples, study.disk, study.to_hz);
  text += "Largest singular value of T, dB, on the whole plant as it is sampled\n";
  std::vector<std::string> header{"method", "lead", "states", "disk", "holds", "peak", "at Hz"};
  for (const double hz : study.frequencies_hz) header.push_back(formatted("%g Hz", hz));
  report::Table table(header, 1);
  const auto add = [&](std::vector<std::string> row, const Eigen::VectorXd& values) {
    for (const double value : values) row.push_back(db_cell(value));
    row.resize(header.size(), "-");
    table.add(row);
  };
  const std::string none = "-";
  add({"passive", none, none, none, none, none, none}, study.passive);
  add({"target", none, none, none, none, none, none}, study.target);
  for (const FeedbackRow& row : study.rows) {
    const std::string lead = row.lead_samples ? formatted("%g", *row.lead_samples) : none;
    if (!row.why_none.empty()) {
      add({row.method, lead}, {});
      continue;
    }
    add({row.method, lead, formatted("%td", row.n_states), formatted("%.3f", row.disk),
         row.radius_off < largest_stable_radius ? "yes" : "no", db_cell(row.peak),
         formatted("%.3g", row.peak_hz)},
        row.largest);
  }
  text += table.print();
  for (const FeedbackRow& row : study.rows) {
    if (!row.why_none.empty()) text += row.method + ": " + row.why_none + "\n";
  }
  text +=
      "disk: margin of all legs; holds: stable with forces of 0.75 and 1.25, and a sample later\n";
  if (study.curve.empty()) return text;
  text += formatted(
      "\nMode of %.4g Hz: largest T over the target's from 1.5 targets to %g Hz, against "
      "margin\n",
      study.stiffest_hz, study.to_hz);
  report::Table curve({"method", "disk", "level dB", "bound dB"}, 1);
  for (const MarginPoint& point : study.curve) {
    curve.add({point.method, formatted("%.3f", point.disk), formatted("%.1f", point.level_db),
               std::isfinite(point.bound_db) ? formatted("%.1f", point.bound_db) : none});
  }
  return text + curve.print() +
         "bound: no feedback of that margin and 40 free terms has less; infinite: not known\n";
}

Json number_or_null(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json json_of(const judge::LoopDesign& design, const FeedbackStudy& study) {
  Json document{{"scene", design.scene.title},
                {"scene_hash", design.scene.hash},
                {"sample_rate_hz", design.gains.sample_rate_hz},
                {"delay_samples", design.gains.delay_samples},
                {"wished_disk", study.disk},
                {"to_hz", study.to_hz},
                {"frequencies_hz", to_json(study.frequencies_hz)},
                {"target", to_json(study.target)},
                {"passive", to_json(study.passive)},
                {"methods", Json::array()},
                {"stiffest_hz", study.stiffest_hz},
                {"curve", Json::array()}};
  for (const FeedbackRow& row : study.rows) {
    const bool found = row.why_none.empty();
    const auto of = [&](const Json& value) { return found ? value : Json(nullptr); };
    document["methods"].push_back(
        {{"method", row.method},
         {"lead_samples", row.lead_samples ? Json(*row.lead_samples) : Json(nullptr)},
         {"why_none", found ? Json(nullptr) : Json(row.why_none)},
         {"n_states", of(row.n_states)},
         {"largest_singular_value", of(to_json(row.largest))},
         {"peak", of(row.peak)},
         {"peak_hz", of(row.peak_hz)},
         {"disk", of(number_or_null(row.disk))},
         {"spectral_radius", of(row.radius)},
         {"spectral_radius_off", of(row.radius_off)},
         {"noise_m_s2_per_n", of(row.noise)}});
  }
  for (const MarginPoint& point : study.curve) {
    document["curve"].push_back({{"method", point.method},
                                 {"disk", number_or_null(point.disk)},
                                 {"level_db", point.level_db},
                                 {"bound_db", number_or_null(point.bound_db)}});
  }
  return document;
}

void draw(const judge::LoopDesign& design, const FeedbackStudy& study,
          const std::filesystem::path& path) {
  report::MarginPlot plot{
      .title = design.scene.title + formatted(": mode of %.4g Hz at %g Hz", study.stiffest_hz,
                                              design.gains.sample_rate_hz),
      .quantity = formatted("largest T over the target's, %.3g to %g Hz",
                            1.5 * design.scene.controller->lowest_target_hz(), study.to_hz),
      .wished_disk = study.disk,
      .curves = {}};
  const auto curve = [&](const char* label, const char* method, double MarginPoint::*value) {
    std::vector<double> disk, level;
    for (const MarginPoint& point : study.curve) {
      if (point.method != method || !std::isfinite(point.*value)) continue;
      disk.push_back(point.disk);
      level.push_back(point.*value);
    }
    plot.curves.push_back({label, Eigen::Map<Eigen::VectorXd>(disk.data(), std::ssize(disk)),
                           Eigen::Map<Eigen::VectorXd>(level.data(), std::ssize(level))});
  };
  curve("PI, by its lead", "pi", &MarginPoint::level_db);
  curve("H2", "h2", &MarginPoint::level_db);
  curve("minimax", "minimax", &MarginPoint::level_db);
  curve("no feedback is below", "minimax", &MarginPoint::bound_db);
  report::plot_margins(plot, path);
}

int run(const FeedbackOptions& options) {
  require_own_places(
      {{"the scene", options.scene}, {"the controller block", options.controller}},
      {{"--plot", options.plot}, {"--h2", options.h2}, {"--minimax", options.minimax}});
  const judge::LoopDesign design = judge::make_loop_design(options.scene, options.controller);
  const SceneController& block = *design.scene.controller;
  if (block.law) {
    throw InputError(block.place + ": law: is a feedback already; take it out to have others made");
  }
  if (block.realisation != Realisation::implicit_feedthrough) {
    throw InputError(block.place +
                     ": realisation: found naive_pi, allowed is implicit_feedthrough");
  }
  FeedbackWish wish = options.wish;
  wish.curve = wish.curve || options.plot;
  if (wish.to_hz > 0 &&
      !(wish.to_hz > 1.5 * block.lowest_target_hz() && wish.to_hz < 0.4 * block.sample_rate_hz)) {
    throw InputError("--to-hz: found " + shortest_digits(wish.to_hz) +
                     ", allowed is from 1.5 targets, " +
                     shortest_digits(1.5 * block.lowest_target_hz()) + ", to 0.4 of the rate, " +
                     shortest_digits(0.4 * block.sample_rate_hz));
  }
  FeedbackStudy study;
  {
    Patience patience("feedback");
    study = feedback_study(design, wish, [&](const std::string& what) { patience.now(what); });
  }
  if (options.json) {
    print(json_of(design, study));
  } else {
    std::cout << page(design, study);
  }
  if (options.plot) draw(design, study, *options.plot);
  const auto place_of = [&](const FeedbackRow& row) {
    return row.method == "h2"        ? options.h2
           : row.method == "minimax" ? options.minimax
                                     : std::nullopt;
  };
  // Both or none.
  for (const FeedbackRow& row : study.rows) {
    if (place_of(row) && !row.why_none.empty()) throw Refusal(row.method + ": " + row.why_none);
  }
  for (const FeedbackRow& row : study.rows) {
    if (const auto place = place_of(row)) write_whole_file(*place, row.law);
  }
  return exit_done;
}

}  // namespace

void add_feedback(cli::Command& app, int& exit_code) {
  auto options = std::make_shared<FeedbackOptions>();
  cli::Command verb = app.verb("feedback",
                               "Compares the PI with feedbacks designed on the sampled loop (H2, "
                               "minimax), at equal margin");
  verb.option("scene", options->scene, "Scene file (YAML) with a controller block")
      .required()
      .type_name("SCENE");
  verb.option("--controller", options->controller, "Controller block that replaces the scene's")
      .type_name("FILE");
  verb.option("--disk", options->wish.disk, "Disk margin to keep, of each mode [0.5]")
      .check(cli::number_between(0.05, 1.9));
  verb.option("--to-hz", options->wish.to_hz,
              "Isolate as the target up to here [rate / 20, at most 20 targets]")
      .check(cli::positive_number());
  verb.option("--h2", options->h2, "Write the H2 law, for `law: FILE` of a controller block")
      .type_name("FILE.yaml");
  verb.option("--minimax", options->minimax, "Write the minimax law").type_name("FILE.yaml");
  verb.flag("--curve", options->wish.curve,
            "Isolation of the stiffest mode against margin, by each method (half a minute)");
  verb.option("--plot", options->plot, "Draw that curve into a PNG file").type_name("FILE");
  verb.flag("--json", options->json, "Print JSON (keys below)");
  verb.footer(
      "Example: stillframe feedback config/scenes/metrology_frame.yaml --minimax law.yaml\n"
      "then a controller block with `law: law.yaml` runs it. A law is made for each virtual mode, "
      "and\n"
      "all are judged together on the whole plant; one that is not stable there is refused (3).\n"
      "Keys of --json:\n"
      "  scene, scene_hash, sample_rate_hz, delay_samples, wished_disk, to_hz\n"
      "  frequencies_hz, target, passive   the target's |T| and T without control, there\n"
      "  methods                     method (pi, h2, minimax), lead_samples, why_none, n_states,\n"
      "                              largest_singular_value of T, peak and peak_hz of it "
      "anywhere,\n"
      "                              disk, spectral_radius, spectral_radius_off (forces of 0.75 "
      "and\n"
      "                              1.25, a sample later), noise_m_s2_per_n; null if why_none\n"
      "  stiffest_hz, curve          of that virtual mode: method, disk, level_db (largest T over "
      "the\n"
      "                              target's from 1.5 targets to to_hz), bound_db (none is "
      "below)");
  verb.runs([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace stillframe::tools

#include "tools/sweep_rows.hpp"

#include <cmath>
#include <limits>

#include "core/control/design/control_loop.hpp"
#include "core/control/design/price_of_sampling.hpp"
#include "core/control/margins.hpp"
#include "judge/loop_design.hpp"
#include "judge/loop_peaks.hpp"
#include "judge/scene_design.hpp"
#include "tools/design_analysis.hpp"

namespace stillframe::tools {

namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(); }

Json identity_of(const std::string& hash, const SweepQuestion& question,
                 const std::vector<std::string>& values) {
  Json set = Json::object();
  for (std::size_t k = 0; k < values.size(); ++k) set[question.grid.keys()[k].path] = values[k];
  return {{"version", STILLFRAME_VERSION}, {"scene_hash", hash}, {"set", set}};
}

/// The figures of a stable loop.
void judge_loop(const judge::LoopDesign& design, Json& row) {
  const auto [disk, disk_hz] = all_leg_disk_margin(design.settings);
  row["disk_margin"] = number(disk);
  row["disk_margin_hz"] = number(disk_hz);
  if (!design.runs_own_law()) {
    row["price_of_sampling_db"] = number(price_of_sampling(
        design.loop, design.scene.controller->lowest_target_hz(), design.settings));
  }
  LargestGain closed(design.closed);
  const FrequencyRange range = judge::axis_of(design, design.scene.controller->target_hz);
  double peak = 0, peak_hz = unknown;
  for (const double hz : judge::picture_frequencies(design, range)) {
    if (const double value = closed(hz); value > peak) {
      peak = value;
      peak_hz = hz;
    }
  }
  row["peak"] = number(peak);
  row["peak_hz"] = number(peak_hz);
  for (Json& line : row["transmission"]) {
    const double hz = line["hz"];
    // What is sampled has no more above half its rate.
    if (hz <= design.gains.sample_rate_hz / 2) line["singular_value"] = number(closed(hz));
  }
}

Json sweep_row(const SweepQuestion& question, std::size_t i) {
  const auto values = question.grid.values(i);
  Json row = identity_of("", question, values);
  for (const char* key : {"stable", "spectral_radius", "disk_margin", "disk_margin_hz",
                          "price_of_sampling_db", "peak", "peak_hz"}) {
    row[key] = nullptr;
  }
  row["transmission"] = Json::array();
  for (const double hz : question.at_hz) {
    row["transmission"].push_back({{"hz", hz}, {"singular_value", nullptr}});
  }
  row["failure"] = nullptr;
  try {
    Scene scene = scene_of(with_values(question.blocks, question.grid.keys(), values));
    row["scene_hash"] = scene.hash;
    require_loop_signals(scene);
    const judge::LoopDesign design = judge::make_loop_design(std::move(scene));
    row["spectral_radius"] = number(design.radius);
    const bool stable = design.radius < largest_stable_radius;
    if (stable) judge_loop(design, row);
    row["stable"] = stable;
  } catch (const std::exception& error) {
    row["failure"] = error.what();
  }
  return row;
}

/// Of no failure, which may have been for want of time or memory, and of the same frequencies.
bool answers(const SweepQuestion& question, const Json& row) {
  const Json& lines = row["transmission"];
  if (!row["failure"].is_null() || !row["stable"].is_boolean()) return false;
  if (lines.size() != question.at_hz.size()) return false;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    if (lines[k].value("hz", unknown) != question.at_hz[k]) return false;
  }
  return true;
}

}  // namespace

const RowKind sweep_rows{"sweep",
                         {"version", "scene_hash", "set"},
                         {"stable", "spectral_radius", "disk_margin", "disk_margin_hz",
                          "price_of_sampling_db", "peak", "peak_hz", "transmission", "failure"}};

RowStudy sweep_study(const SweepQuestion& question) {
  return {.things = "designs",
          .n_points = question.grid.size(),
          .identity = [&](std::size_t i) -> Json {
            const auto values = question.grid.values(i);
            try {
              const Scene scene =
                  scene_of(with_values(question.blocks, question.grid.keys(), values));
              return identity_of(scene.hash, question, values);
            } catch (const std::exception&) {
              return nullptr;  // said again by who designs it
            }
          },
          .answers = [&](const Json& row) { return answers(question, row); },
          .compute = [&](std::size_t i) { return sweep_row(question, i); }};
}

}  // namespace stillframe::tools

#include "tools/sweep_rows.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <sstream>
#include <tuple>

#include "core/control/design/control_loop.hpp"
#include "core/control/margins.hpp"
#include "core/errors/input_error.hpp"
#include "judge/loop_design.hpp"
#include "judge/loop_peaks.hpp"
#include "judge/scene_design.hpp"
#include "tools/design_analysis.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(); }

double number_of(const Json& value) { return value.is_number() ? value.get<double>() : unknown; }

std::string key_of(const Json& row) {
  return row["version"].dump() + row["scene_hash"].dump() + row["set"].dump();
}

/// The figures of a stable loop.
void judge_loop(const judge::LoopDesign& design, const SweepQuestion& question, SweepRow& row) {
  std::tie(row.disk, row.disk_hz) = all_leg_disk_margin(design.settings);
  if (!design.runs_own_law()) {
    row.price_db = price_of_sampling(design.loop, design.scene.controller->lowest_target_hz(),
                                     design.settings);
  }
  LargestGain closed(design.closed);
  const FrequencyRange range = judge::axis_of(design, design.scene.controller->target_hz);
  row.peak = 0;
  for (const double hz : judge::picture_frequencies(design, range)) {
    if (const double value = closed(hz); value > row.peak) {
      row.peak = value;
      row.peak_hz = hz;
    }
  }
  for (std::size_t k = 0; k < question.at_hz.size(); ++k) {
    // What is sampled has no more above half its rate.
    if (question.at_hz[k] > design.gains.sample_rate_hz / 2) continue;
    row.transmission[k] = closed(question.at_hz[k]);
  }
}

}  // namespace

SweepRow sweep_row(const SweepQuestion& question, std::size_t i) {
  SweepRow row;
  row.point = i;
  row.values = question.grid.values(i);
  row.radius = row.disk = row.disk_hz = row.price_db = row.peak = row.peak_hz = unknown;
  row.transmission.assign(question.at_hz.size(), unknown);
  try {
    Scene scene = scene_of(with_values(question.blocks, question.grid.keys(), row.values));
    row.scene_hash = scene.hash;
    require_loop_signals(scene);
    const judge::LoopDesign design = judge::make_loop_design(std::move(scene));
    row.radius = design.radius;
    row.stable = design.radius < largest_stable_radius;
    if (row.stable) judge_loop(design, question, row);
  } catch (const std::exception& error) {
    row.failure = error.what();
  }
  return row;
}

Json to_json(const SweepQuestion& question, const SweepRow& row) {
  Json set = Json::object(), transmission = Json::array();
  for (std::size_t k = 0; k < row.values.size(); ++k) {
    set[question.grid.keys()[k].path] = row.values[k];
  }
  for (std::size_t k = 0; k < row.transmission.size(); ++k) {
    transmission.push_back(
        {{"hz", question.at_hz[k]}, {"singular_value", number(row.transmission[k])}});
  }
  const bool designed = row.failure.empty();
  return {{"version", STILLFRAME_VERSION},
          {"scene_hash", row.scene_hash},
          {"set", set},
          {"stable", designed ? Json(row.stable) : Json()},
          {"spectral_radius", number(row.radius)},
          {"disk_margin", number(row.disk)},
          {"disk_margin_hz", number(row.disk_hz)},
          {"price_of_sampling_db", number(row.price_db)},
          {"peak", number(row.peak)},
          {"peak_hz", number(row.peak_hz)},
          {"transmission", transmission},
          {"failure", designed ? Json() : Json(row.failure)}};
}

SweepFile::SweepFile(std::filesystem::path path) : path_(std::move(path)) {
  std::error_code missing;
  if (!std::filesystem::exists(path_, missing)) return;
  std::ifstream file(path_, std::ios::binary);
  std::stringstream bytes;
  bytes << file.rdbuf();
  if (!file) throw InputError(path_.string() + ": cannot be read");
  const std::string text = bytes.str();
  const auto refuse = [&](std::size_t number) {
    throw InputError(path_.string() + ":" + std::to_string(number) +
                     ": found a line that is no row of a sweep; allowed is a file that `sweep "
                     "--out` wrote, or a new one");
  };
  std::size_t begin = 0, line = 0;
  for (std::size_t end = text.find('\n'); end != std::string::npos;
       begin = end + 1, end = text.find('\n', begin)) {
    ++line;
    Json row = Json::parse(text.substr(begin, end - begin), nullptr, false);
    bool is_row = row.is_object();
    for (const char* key : {"version", "scene_hash", "set", "transmission", "failure", "stable"}) {
      is_row = is_row && row.contains(key);
    }
    if (!is_row) refuse(line);
    // Of a point that was computed twice the last row counts.
    std::string key = key_of(row);
    rows_[std::move(key)] = std::move(row);
  }
  if (begin == text.size()) return;
  // What a killed program left, and nothing else.
  const std::string first = R"({"version":)", rest = text.substr(begin, first.size());
  if (first.compare(0, rest.size(), rest) != 0) refuse(line + 1);
  std::filesystem::resize_file(path_, begin);
}

std::optional<SweepRow> SweepFile::find(const SweepQuestion& question, std::size_t i) const {
  const auto values = question.grid.values(i);
  SweepRow row;
  row.point = i;
  row.values = values;
  try {
    row.scene_hash = scene_of(with_values(question.blocks, question.grid.keys(), values)).hash;
  } catch (const std::exception&) {
    return std::nullopt;  // said again by who designs it
  }
  row.transmission.assign(question.at_hz.size(), unknown);
  const auto known = rows_.find(key_of(to_json(question, row)));
  if (known == rows_.end()) return std::nullopt;
  const Json& found = known->second;
  // What failed for want of time or memory may not fail again.
  if (!found["failure"].is_null() || !found["stable"].is_boolean() ||
      found["transmission"].size() != question.at_hz.size()) {
    return std::nullopt;
  }
  for (std::size_t k = 0; k < question.at_hz.size(); ++k) {
    const Json& line = found["transmission"][k];
    if (line.value("hz", unknown) != question.at_hz[k]) return std::nullopt;
    row.transmission[k] = number_of(line.value("singular_value", Json()));
  }
  row.stable = found["stable"].get<bool>();
  row.radius = number_of(found.value("spectral_radius", Json()));
  row.disk = number_of(found.value("disk_margin", Json()));
  row.disk_hz = number_of(found.value("disk_margin_hz", Json()));
  row.price_db = number_of(found.value("price_of_sampling_db", Json()));
  row.peak = number_of(found.value("peak", Json()));
  row.peak_hz = number_of(found.value("peak_hz", Json()));
  return row;
}

void SweepFile::add(const SweepQuestion& question, const SweepRow& row) {
  // Names and reasons may be bytes that are no UTF-8.
  const std::string line =
      to_json(question, row).dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
  const int file = open(path_.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0666);
  const bool written =
      file >= 0 && write(file, line.data(), line.size()) == static_cast<ssize_t>(line.size());
  const int error = errno;
  if (file >= 0) close(file);
  if (!written) throw Failure(path_.string() + ": cannot be written: " + std::strerror(error));
}

}  // namespace stillframe::tools

#include <algorithm>
#include <cmath>
#include <numeric>

#include "plant_sim/floor/floor_block.hpp"
#include "plant_sim/floor/high_pass.hpp"
#include "plant_sim/floor/recording_file.hpp"
#include "plant_sim/floor/resample.hpp"
#include "plant_sim/floor/sources.hpp"
#include "plant_sim/floor/white.hpp"

namespace stillframe::floor {

namespace {

constexpr double taper_s = 1.0;

/// The recording's samples on the world axes, from start_s to its end, scaled. 3 x samples.
Eigen::MatrixXd cut_and_map(const RecordingSpec& spec, const RecordingFile& recording) {
  const Eigen::Index n = recording.acceleration.cols();
  const double fs = recording.sample_rate_hz;
  const double first = std::round(spec.start_s * fs);
  if (static_cast<double>(n) - first <= 2.0 * std::ceil(taper_s * fs)) {
    const auto start = spec.block.find("start_s");
    (start ? *start : spec.block)
        .fail("found " + std::to_string(static_cast<double>(n) / fs - spec.start_s) + " s of " +
              spec.file.string() + " from start_s on, allowed is more than 2 s");
  }
  const auto begin = static_cast<Eigen::Index>(first);
  Eigen::MatrixXd piece = Eigen::MatrixXd::Zero(3, n - begin);
  for (const auto& [column, axis] : spec.axes) {
    const auto& names = recording.columns;
    const auto found = std::find(names.begin(), names.end(), column);
    if (found == names.end()) {
      const auto join = [](const std::string& list, const std::string& name) {
        return list.empty() ? name : list + ", " + name;
      };
      const std::string near = nearest_name(column, names);
      spec.block.require("axes").require(column).fail(
          "'" + column + "' is no column of " + spec.file.string() +
          (near.empty() ? "" : " (did you mean '" + near + "'?)") +
          "; allowed: " + std::accumulate(names.begin(), names.end(), std::string(), join));
    }
    piece.row(axis) =
        spec.scale * recording.acceleration.row(found - names.begin()).tail(n - begin);
  }
  return piece;
}

std::unique_ptr<FloorSource> make(const FloorSpec& floor, const RecordingSpec& spec) {
  const YamlReader file = spec.block.require("file");
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(spec.file, ignored)) {
    file.fail("found '" + spec.file.string() + "', which is missing or no file");
  }
  const RecordingFile recording = read_recording(spec.file);
  const auto ratio = rational_ratio(recording.sample_rate_hz, floor.sample_rate_hz);
  if (!ratio) {
    file.fail("found a recording at " + std::to_string(recording.sample_rate_hz) +
              " Hz, allowed is a rate whose ratio to the control rate of " +
              std::to_string(floor.sample_rate_hz) + " Hz is one of whole numbers up to 10000");
  }
  Eigen::MatrixXd piece = cut_and_map(spec, recording);
  taper_ends(piece, static_cast<Eigen::Index>(std::ceil(taper_s * recording.sample_rate_hz)));
  Eigen::MatrixXd table = resample(piece, *ratio);
  high_pass_rows(spec.high_pass_hz, floor.sample_rate_hz, table);
  return std::make_unique<TabulatedFloor>(FloorChannels::translations, std::move(table));
}

std::unique_ptr<FloorSource> make(const FloorSpec&, const MultisinePlan& plan) {
  return std::make_unique<TabulatedFloor>(FloorChannels::inputs, multisine_table(plan));
}

std::unique_ptr<FloorSource> make(const FloorSpec& floor, const WhiteSpec& spec) {
  Eigen::MatrixXd table = gaussian_noise(spec.seed, floor.inputs, spec.n_samples);
  table *= spec.rms / white_noise_gain(spec.high_pass_hz, floor.sample_rate_hz);
  high_pass_rows(spec.high_pass_hz, floor.sample_rate_hz, table);
  return std::make_unique<TabulatedFloor>(FloorChannels::inputs, std::move(table));
}

std::unique_ptr<FloorSource> make(const FloorSpec& floor, const StillSpec& spec) {
  return std::make_unique<StillFloor>(floor.inputs, spec.n_samples);
}

}  // namespace

std::unique_ptr<FloorSource> make_floor_source(const FloorSpec& spec) {
  return std::visit([&](const auto& kind) { return make(spec, kind); }, spec.kind);
}

}  // namespace stillframe::floor

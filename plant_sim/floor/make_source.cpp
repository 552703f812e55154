#include <algorithm>
#include <cmath>
#include <numeric>

#include "plant_sim/floor/block_values.hpp"
#include "plant_sim/floor/floor_block.hpp"
#include "plant_sim/floor/held_acceleration.hpp"
#include "plant_sim/floor/high_pass.hpp"
#include "plant_sim/floor/recording_file.hpp"
#include "plant_sim/floor/resample.hpp"
#include "plant_sim/floor/shaped_noise.hpp"
#include "plant_sim/floor/sources.hpp"
#include "plant_sim/floor/white.hpp"

namespace stillframe::floor {

namespace {

constexpr double taper_s = 1.0;

/// High-passes each row; if it shall ring out, goes on with zeros until the filter has come to
/// rest: its slowest pole decays as exp(-2.4 f_c t), to the last bit of a double in 16 / f_c.
void high_pass(Eigen::MatrixXd& table, double corner_hz, double rate, bool ring_out) {
  if (ring_out) {
    const Eigen::Index n = table.cols();
    const auto more = static_cast<Eigen::Index>(std::ceil(16.0 * rate / corner_hz));
    table.conservativeResize(Eigen::NoChange, n + more);
    table.rightCols(more).setZero();
  }
  high_pass_rows(corner_hz, rate, table);
}

/// The recording's samples on the world axes, or on the rotations about them, from start_s to its
/// end, scaled. 3 x samples.
Eigen::MatrixXd cut_and_map(const RecordingSpec& spec, const RecordingFile& recording) {
  const Eigen::Index n = recording.acceleration.cols();
  const double fs = recording.sample_rate_hz;
  const double first = std::round(spec.start_s * fs);
  if (static_cast<double>(n) - first <= 2.0 * std::ceil(taper_s * fs)) {
    const auto start = spec.block.find("start_s");
    (start ? *start : spec.block)
        .fail("found " + text_of(static_cast<double>(n) / fs - spec.start_s) + " s of " +
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
    piece.row(axis % 3) =
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
  const RecordingFile recording = read_recording(spec.file, spec.turns() ? "rad/s^2" : "m/s^2");
  const auto ratio = rational_ratio(recording.sample_rate_hz, floor.sample_rate_hz);
  if (!ratio) {
    file.fail("found a recording at " + text_of(recording.sample_rate_hz) +
              " Hz, allowed is a rate whose ratio to the control rate of " +
              text_of(floor.sample_rate_hz) + " Hz is one of whole numbers up to 10000");
  }
  Eigen::MatrixXd piece = cut_and_map(spec, recording);
  taper_ends(piece, static_cast<Eigen::Index>(std::ceil(taper_s * recording.sample_rate_hz)));
  Eigen::MatrixXd table = resample(piece, *ratio);
  high_pass(table, spec.high_pass_hz, floor.sample_rate_hz, spec.ring_out);
  if (!spec.turns()) {
    return std::make_unique<TabulatedFloor>(FloorChannels::translations, std::move(table));
  }
  Eigen::MatrixXd patterns(6, 3);
  for (Eigen::Index i = 0; i < 3; ++i) patterns.col(i) = rigid_pattern(3 + i, spec.about);
  return std::make_unique<TabulatedFloor>(FloorChannels::rigid, patterns * table);
}

std::unique_ptr<FloorSource> make(const FloorSpec&, const MultisinePlan& plan) {
  return std::make_unique<TabulatedFloor>(FloorChannels::inputs, multisine_table(plan));
}

std::unique_ptr<FloorSource> make(const FloorSpec& floor, const WhiteSpec& spec) {
  Eigen::MatrixXd table = gaussian_noise(spec.seed, first_channels(floor.inputs), spec.n_samples);
  table *= spec.rms / white_noise_gain(spec.high_pass_hz, floor.sample_rate_hz);
  high_pass(table, spec.high_pass_hz, floor.sample_rate_hz, spec.ring_out);
  return std::make_unique<TabulatedFloor>(FloorChannels::inputs, std::move(table));
}

std::unique_ptr<FloorSource> make(const FloorSpec& floor, const NoiseSpec& spec) {
  const double rate = floor.sample_rate_hz;
  const bool rigid = !spec.axes.empty();
  const auto noises = rigid ? static_cast<Eigen::Index>(spec.axes.size()) : floor.inputs;
  Eigen::MatrixXd patterns = Eigen::MatrixXd::Identity(rigid ? 6 : noises, noises);
  for (Eigen::Index i = 0; rigid && i < noises; ++i) {
    patterns.col(i) = rigid_pattern(spec.axes[static_cast<std::size_t>(i)], spec.about);
  }
  NoiseShape shape{.density = spec.density,
                   .seed = spec.seed,
                   .high_pass_hz = spec.high_pass_hz,
                   .rate = rate,
                   .period = std::llround(spec.period_s * rate)};
  shape.period = std::clamp<std::int64_t>(shape.period, 1, spec.n_samples);
  const auto fade = std::min(static_cast<std::int64_t>(std::ceil(2.0 * rate / spec.high_pass_hz)),
                             spec.n_samples / 4);
  return std::make_unique<NoiseFloor>(
      rigid ? FloorChannels::rigid : FloorChannels::inputs, std::move(patterns),
      periodic_noise(shape, rigid ? spec.axes : first_channels(noises), true), rate, spec.n_samples,
      fade);
}

std::unique_ptr<FloorSource> make(const FloorSpec& floor, const CourseSpec& spec) {
  const Eigen::VectorXd course = held_accelerations(
      std::visit([&](const auto& shape) { return positions(shape, floor.sample_rate_hz); },
                 spec.course),
      floor.sample_rate_hz);
  return std::make_unique<PatternFloor>(spec.target.meaning(), spec.target.pattern(floor.inputs),
                                        course, spec.begin, spec.n_samples);
}

/// The first part of a sum keeps its seed, so that it is the noise that it is alone.
FloorSpec with_seed_of_part(FloorSpec part, std::size_t i) {
  const auto make_own = [&](std::uint64_t& seed) {
    if (i > 0) seed = seed_of(seed, "floor part " + std::to_string(i));
  };
  if (auto* noise = std::get_if<NoiseSpec>(&part.kind)) make_own(noise->seed);
  if (auto* white = std::get_if<WhiteSpec>(&part.kind)) make_own(white->seed);
  return part;
}

std::unique_ptr<FloorSource> make(const FloorSpec& floor, const SumSpec& spec) {
  std::vector<std::unique_ptr<FloorSource>> parts;
  std::int64_t longest = 0;
  for (const FloorSpec& part : spec.parts) {
    parts.push_back(make_floor_source(with_seed_of_part(part, parts.size())));
    longest = std::max(longest, parts.back()->n_samples());
  }
  for (std::size_t i = 0; i < parts.size(); ++i) {
    // It does not fade out: behind its end the floor would drift.
    if (std::holds_alternative<MultisinePlan>(spec.parts[i].kind) &&
        parts[i]->n_samples() < longest) {
      spec.blocks[i].fail(
          "ends in the middle of its motion before the others of the sum; allowed "
          "is a multisine that lasts longest");
    }
  }
  return std::make_unique<SumFloor>(std::move(parts), floor.inputs);
}

std::unique_ptr<FloorSource> make(const FloorSpec& floor, const StillSpec& spec) {
  return std::make_unique<StillFloor>(floor.inputs, spec.n_samples);
}

}  // namespace

std::unique_ptr<FloorSource> make_floor_source(const FloorSpec& spec) {
  return std::visit([&](const auto& kind) { return make(spec, kind); }, spec.kind);
}

}  // namespace stillframe::floor

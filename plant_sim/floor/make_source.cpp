#include <algorithm>
#include <cmath>

#include "plant_sim/counter_noise.hpp"
#include "plant_sim/floor/block_values.hpp"
#include "plant_sim/floor/floor_block.hpp"
#include "plant_sim/floor/held_acceleration.hpp"
#include "plant_sim/floor/high_pass.hpp"
#include "plant_sim/floor/recording_file.hpp"
#include "plant_sim/floor/shaped_noise.hpp"
#include "plant_sim/floor/sources.hpp"
#include "plant_sim/floor/white.hpp"

namespace stillframe::floor {

namespace {

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

std::unique_ptr<FloorSource> make(const FloorSpec& floor, const RecordingSpec& spec) {
  RecordingPart part{.file = spec.file,
                     .units = spec.turns() ? "rad/s^2" : "m/s^2",
                     .columns = {},
                     .scale = spec.scale,
                     .start_s = spec.start_s};
  Eigen::MatrixXd patterns(6, static_cast<Eigen::Index>(spec.axes.size()));
  for (const auto& [column, axis] : spec.axes) {
    patterns.col(static_cast<Eigen::Index>(part.columns.size())) = rigid_pattern(axis, spec.about);
    part.columns.push_back(column);
  }
  const auto start = spec.block.find("start_s");
  const RecordingErrors errors{
      .file = [&](const auto& what) { spec.block.require("file").fail(what); },
      .start = [&](const auto& what) { (start ? *start : spec.block).fail(what); },
      .column =
          [&](std::size_t i, const auto& what) {
            spec.block.require("axes").require(part.columns[i]).fail(what);
          }};
  Eigen::MatrixXd table = play_recording(part, floor.sample_rate_hz, errors);
  high_pass(table, spec.high_pass_hz, floor.sample_rate_hz, spec.ring_out);
  const Eigen::Index n = table.cols();
  return std::make_unique<TabulatedFloor>(FloorChannels::rigid, std::move(patterns),
                                          std::move(table), 0, n);
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
  return std::make_unique<TabulatedFloor>(spec.target.meaning(), spec.target.pattern(floor.inputs),
                                          course.transpose(), spec.begin, spec.n_samples);
}

/// The first part of a sum keeps its seed, so that it is the noise that it is alone.
FloorSpec with_seed_of_part(FloorSpec part, std::size_t i) {
  const auto make_own = [&](std::uint64_t& seed) {
    if (i > 0) seed = CounterNoise::seed_of(seed, "floor part " + std::to_string(i));
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
  return std::make_unique<TabulatedFloor>(FloorChannels::inputs,
                                          Eigen::MatrixXd::Zero(floor.inputs, 0), Eigen::MatrixXd(),
                                          0, spec.n_samples);
}

}  // namespace

std::unique_ptr<FloorSource> make_floor_source(const FloorSpec& spec) {
  return std::visit([&](const auto& kind) { return make(spec, kind); }, spec.kind);
}

}  // namespace stillframe::floor

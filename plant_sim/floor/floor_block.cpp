#include "plant_sim/floor/floor_block.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "plant_sim/floor/block_values.hpp"
#include "plant_sim/floor/motion_blocks.hpp"

namespace stillframe::floor {

namespace {

RecordingSpec read_recording_block(const YamlReader& block, double sample_rate_hz) {
  block.allow_only({"file", "scale", "start_s", "high_pass_hz", "axes", "about"});
  RecordingSpec spec{.block = block, .file = block.require("file").text(), .axes = {}};
  if (spec.file.is_relative()) spec.file = (block.folder() / spec.file).lexically_normal();
  spec.scale = value_or(block, "scale", 1.0, &YamlReader::positive);
  spec.start_s = value_or(block, "start_s", 0.0, &YamlReader::non_negative);
  spec.high_pass_hz = read_high_pass(block, sample_rate_hz);
  const YamlReader axes = block.require("axes");
  for (const auto& [column, value] : axes.entries()) {
    const Eigen::Index axis = read_axis(value);
    for (const auto& other : spec.axes) {
      if (other.axis == axis) {
        value.fail("found '" + value.text() + "', which column " + other.column +
                   " already moves; allowed is one column for each axis");
      }
      if ((other.axis >= 3) != (axis >= 3)) {
        value.fail("found '" + value.text() +
                   "' beside translations or rotations: a file is in m/s^2 or in rad/s^2; a sum "
                   "of two recordings has both");
      }
    }
    spec.axes.push_back({column, axis});
  }
  if (spec.axes.empty()) axes.fail("found nothing, allowed is a map as in {ax: x, ay: y, az: z}");
  spec.about = read_about(block, spec.turns());
  return spec;
}

void check_line(const YamlReader& value, const MultisinePlan& plan) {
  const double line = value.positive(), spacing = 4.0 / plan.window_s;
  const std::string found = "found " + text_of(line) + ", allowed is ";
  if (!(line < 0.5 * plan.sample_rate_hz)) {
    value.fail(found + "a line below " + text_of(0.5 * plan.sample_rate_hz) +
               " Hz, half the control rate");
  }
  const double multiple = line / spacing;
  if (std::abs(multiple - std::round(multiple)) > 1e-9 * multiple) {
    value.fail(found + "a whole multiple of " + text_of(spacing) + " Hz (4 / window_s)");
  }
  const auto& lines = plan.frequencies_hz;
  if (std::any_of(lines.begin(), lines.end(),
                  [&](double other) { return std::abs(other - line) < 0.5 * spacing; })) {
    value.fail(found + "each line once");
  }
}

double read_whole_samples(const YamlReader& block, const std::string& key, double otherwise,
                          double sample_rate_hz) {
  const auto value = block.find(key);
  const double seconds = value ? value->positive() : otherwise;
  const double samples = seconds * sample_rate_hz;
  if (samples < 0.5 || std::abs(samples - std::round(samples)) > 1e-9 * samples) {
    const std::string message = "found " + text_of(seconds) +
                                ", allowed is a whole number of samples at the control rate of " +
                                text_of(sample_rate_hz) + " Hz";
    value ? value->fail(message) : block.fail(key + " (default): " + message);
  }
  return seconds;
}

MultisinePlan read_multisine_block(const YamlReader& block, double sample_rate_hz,
                                   Eigen::Index inputs) {
  block.allow_only({"frequencies_hz", "amplitude", "ramp_s", "window_s"});
  MultisinePlan plan;
  plan.sample_rate_hz = sample_rate_hz;
  plan.n_blocks = inputs;
  plan.amplitude = block.require("amplitude").positive();
  plan.ramp_s = read_whole_samples(block, "ramp_s", plan.ramp_s, sample_rate_hz);
  plan.window_s = read_whole_samples(block, "window_s", plan.window_s, sample_rate_hz);
  const YamlReader lines = block.require("frequencies_hz");
  for (const auto& line : lines.items()) {
    check_line(line, plan);
    plan.frequencies_hz.push_back(line.number());
  }
  if (plan.frequencies_hz.empty()) lines.fail("found no line, allowed is one or more");
  std::sort(plan.frequencies_hz.begin(), plan.frequencies_hz.end());
  const double n = static_cast<double>(inputs);
  if (n * n * (plan.ramp_s + plan.window_s) * sample_rate_hz > most_values) {
    block.fail("the experiment is too long: " + text_of(n) + " blocks of " +
               text_of(plan.ramp_s + plan.window_s) + " s on " + text_of(n) +
               " inputs are more than " + text_of(most_values) + " values");
  }
  return plan;
}

WhiteSpec read_white_block(const YamlReader& block, double sample_rate_hz, Eigen::Index inputs) {
  block.allow_only({"seed", "rms", "high_pass_hz", "duration_s"});
  WhiteSpec spec;
  if (const auto seed = block.find("seed")) {
    spec.seed = static_cast<std::uint64_t>(seed->integer(0));
  }
  spec.rms = block.require("rms").positive();
  spec.high_pass_hz = read_high_pass(block, sample_rate_hz);
  spec.n_samples = read_duration(block, sample_rate_hz, inputs);
  return spec;
}

StillSpec read_still_block(const YamlReader& block, double sample_rate_hz, Eigen::Index inputs) {
  block.allow_only({"duration_s"});
  return StillSpec{read_duration(block, sample_rate_hz, inputs)};
}

/// The one kind of a block and its value.
std::pair<std::string, YamlReader> read_kind(const YamlReader& block) {
  block.allow_only(
      {"recording", "multisine", "white", "noise", "step", "impact", "sine_sweep", "still", "sum"});
  const auto kinds = block.entries();
  if (kinds.size() != 1) {
    block.fail("found " + std::to_string(kinds.size()) +
               " kinds of floor, allowed is exactly one of recording, multisine, white, noise, "
               "step, impact, sine_sweep, still, sum");
  }
  return kinds.front();
}

SumSpec read_sum_block(const YamlReader& blocks, double sample_rate_hz, const FloorInputs& inputs) {
  SumSpec spec;
  for (const YamlReader& block : blocks.items()) {
    if (read_kind(block).first == "sum") block.fail("a sum within a sum is not allowed");
    spec.parts.push_back(read_floor_block(block, sample_rate_hz, inputs));
    spec.blocks.push_back(block);
    auto& kind = spec.parts.back().kind;
    if (auto* recording = std::get_if<RecordingSpec>(&kind)) recording->ring_out = true;
    if (auto* white = std::get_if<WhiteSpec>(&kind)) white->ring_out = true;
  }
  if (spec.parts.empty()) blocks.fail("found nothing, allowed is one floor or more");
  return spec;
}

}  // namespace

bool FloorSpec::recorded() const {
  if (const auto* sum = std::get_if<SumSpec>(&kind)) {
    return std::any_of(sum->parts.begin(), sum->parts.end(),
                       [](const FloorSpec& part) { return part.recorded(); });
  }
  return std::holds_alternative<RecordingSpec>(kind);
}

FloorSpec read_floor_block(const YamlReader& block, double sample_rate_hz,
                           const FloorInputs& inputs) {
  if (!(sample_rate_hz > 0.0) || !std::isfinite(sample_rate_hz) || inputs.number < 1) {
    throw std::invalid_argument(
        "read_floor_block: expected a sample rate above 0 and at least one input");
  }
  const auto [kind, value] = read_kind(block);
  FloorSpec spec{.sample_rate_hz = sample_rate_hz, .inputs = inputs.number, .kind = StillSpec{}};
  if (kind == "recording") {
    spec.kind = read_recording_block(value, sample_rate_hz);
  } else if (kind == "multisine") {
    spec.kind = read_multisine_block(value, sample_rate_hz, inputs.number);
  } else if (kind == "white") {
    spec.kind = read_white_block(value, sample_rate_hz, inputs.number);
  } else if (kind == "noise") {
    spec.kind = read_noise_block(value, sample_rate_hz, inputs.number);
  } else if (kind == "still") {
    spec.kind = read_still_block(value, sample_rate_hz, inputs.number);
  } else if (kind == "sum") {
    spec.kind = read_sum_block(value, sample_rate_hz, inputs);
  } else {
    spec.kind = read_course_block(kind, value, sample_rate_hz, inputs);
  }
  return spec;
}

}  // namespace stillframe::floor

#include "plant_sim/floor/motion_blocks.hpp"

#include <algorithm>
#include <cmath>

#include "plant_sim/floor/block_values.hpp"

namespace stillframe::floor {

namespace {

/// A length (s) that is wide enough to be seen in samples and not too long for a table.
double read_seconds(const YamlReader& value, double sample_rate_hz, double least_samples) {
  const double seconds = value.positive(), samples = seconds * sample_rate_hz;
  if (samples < least_samples || samples > most_values) {
    value.fail("found " + value.text() + ", allowed is from " +
               text_of(least_samples / sample_rate_hz) + " (" + text_of(least_samples) +
               " samples) to " + text_of(most_values / sample_rate_hz));
  }
  return seconds;
}

StepCourse read_step(const YamlReader& block, double rate) {
  block.allow_only({"height", "rise_s", "at_s", "axis", "input", "about", "duration_s"});
  return {.height = block.require("height").number(),
          .rise_s = read_seconds(block.require("rise_s"), rate, 4.0)};
}

ImpactCourse read_impact(const YamlReader& block, double rate) {
  block.allow_only({"peak", "width_s", "at_s", "axis", "input", "about", "duration_s"});
  return {.peak = block.require("peak").number(),
          .width_s = read_seconds(block.require("width_s"), rate, 4.0)};
}

SweepCourse read_sweep(const YamlReader& block, double rate) {
  block.allow_only({"from_hz", "to_hz", "amplitude", "sweep_s", "spacing", "at_s", "axis", "input",
                    "about", "duration_s"});
  SweepCourse sweep{.from_hz = read_below_half_rate(block.require("from_hz"), rate),
                    .to_hz = read_below_half_rate(block.require("to_hz"), rate),
                    .amplitude = block.require("amplitude").positive(),
                    .sweep_s = 0.0};
  const auto spacing = block.find("spacing");
  sweep.linear = spacing && spacing->one_of({"logarithmic", "linear"}) == "linear";
  // The logarithm of their ratio stands in a denominator.
  sweep.linear |= sweep.from_hz == sweep.to_hz;
  const double slowest = std::min(sweep.from_hz, sweep.to_hz);
  sweep.sweep_s = read_seconds(block.require("sweep_s"), rate, std::ceil(4.0 * rate / slowest));
  return sweep;
}

double length_s(const StepCourse& step) { return step.rise_s; }
double length_s(const ImpactCourse& impact) { return impact.width_s; }
double length_s(const SweepCourse& sweep) { return sweep.sweep_s; }

PointsDensity read_points(const YamlReader& list, double rate) {
  PointsDensity line;
  for (const YamlReader& item : list.items()) {
    const Eigen::VectorXd point = item.vector(2);
    const double last = line.points.empty() ? 0.0 : line.points.back().first;
    if (!(point(0) > last) || !(point(1) > 0.0)) {
      item.fail("allowed is [frequency, density], both above 0, the frequencies ascending");
    }
    line.points.emplace_back(point(0), point(1));
  }
  if (line.points.size() < 2) list.fail("found fewer than two points [frequency, density]");
  if (!(line.points.front().first < 0.5 * rate)) {
    list.fail("all its frequencies are above " + text_of(0.5 * rate) +
              " Hz, half the control rate");
  }
  return line;
}

std::vector<Eigen::Index> read_axes(const YamlReader& list, bool translations_only) {
  std::vector<Eigen::Index> axes;
  for (const YamlReader& item : list.items()) {
    const Eigen::Index axis = read_axis(item);
    if (std::find(axes.begin(), axes.end(), axis) != axes.end()) item.fail("allowed is each once");
    if (axis >= 3 && translations_only) {
      item.fail(
          "vc and peterson are about translations; allowed for a rotation is psd, in "
          "(rad/s^2)^2/Hz");
    }
    axes.push_back(axis);
  }
  if (axes.empty()) list.fail("found nothing, allowed is a sequence as in [x, y, z]");
  return axes;
}

}  // namespace

Density read_density(const YamlReader& block, double sample_rate_hz) {
  const auto vc = block.find("vc"), peterson = block.find("peterson"), psd = block.find("psd");
  if (vc.has_value() + peterson.has_value() + psd.has_value() != 1) {
    block.fail("needs exactly one of vc, peterson, psd");
  }
  if (vc) {
    const std::string letter = vc->one_of({"A", "B", "C", "D", "E", "F", "G"});
    return VibrationCriterionDensity{letter.front()};
  }
  if (peterson) return PetersonDensity{peterson->one_of({"high", "low"}) == "high"};
  return read_points(*psd, sample_rate_hz);
}

CourseSpec read_course_block(const std::string& kind, const YamlReader& block,
                             double sample_rate_hz, const FloorInputs& inputs) {
  CourseSpec spec;
  if (kind == "step") {
    spec.course = read_step(block, sample_rate_hz);
  } else if (kind == "impact") {
    spec.course = read_impact(block, sample_rate_hz);
  } else {
    spec.course = read_sweep(block, sample_rate_hz);
  }
  spec.target = read_target(block, inputs);
  const double at = value_or(block, "at_s", 0.0, &YamlReader::non_negative);
  if (at * sample_rate_hz > most_samples) block.require("at_s").fail("is too late");
  spec.begin = std::llround(at * sample_rate_hz);
  const double seconds =
      std::visit([](const auto& course) { return length_s(course); }, spec.course);
  const double samples = std::ceil(seconds * sample_rate_hz) + 2.0;
  const double end_s = (static_cast<double>(spec.begin) + samples) / sample_rate_hz;
  spec.n_samples = read_length(block, sample_rate_hz, end_s);
  if (static_cast<double>(spec.n_samples - spec.begin) < samples - 1.0) {
    block.require("duration_s")
        .fail("ends before the " + kind + ", allowed is " + text_of(end_s) + " or more");
  }
  return spec;
}

NoiseSpec read_noise_block(const YamlReader& block, double sample_rate_hz, Eigen::Index inputs) {
  block.allow_only(
      {"vc", "peterson", "psd", "seed", "high_pass_hz", "period_s", "duration_s", "axes", "about"});
  NoiseSpec spec;
  spec.density = read_density(block, sample_rate_hz);
  if (const auto seed = block.find("seed")) {
    spec.seed = static_cast<std::uint64_t>(seed->integer(0));
  }
  spec.high_pass_hz = read_high_pass(block, sample_rate_hz, spec.high_pass_hz);
  if (const auto axes = block.find("axes")) {
    spec.axes = read_axes(*axes, !std::holds_alternative<PointsDensity>(spec.density));
  }
  spec.about = read_about(block, std::any_of(spec.axes.begin(), spec.axes.end(),
                                             [](Eigen::Index axis) { return axis >= 3; }));
  block.require("duration_s");
  spec.n_samples = read_length(block, sample_rate_hz, 0.0);
  const double noises =
      static_cast<double>(spec.axes.empty() ? inputs : static_cast<Eigen::Index>(spec.axes.size()));
  // A transform needs several copies of one noise; 1e7 samples of them are 0.5 GB.
  const double most = std::min(most_values / noises, 1e7) / sample_rate_hz;
  const auto period = block.find("period_s");
  if (period) spec.period_s = period->positive();
  if (spec.period_s > most) {
    if (period) period->fail("found " + period->text() + ", allowed is up to " + text_of(most));
    spec.period_s = most;
  }
  return spec;
}

}  // namespace stillframe::floor

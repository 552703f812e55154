#include "plant_sim/force_courses.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/errors/input_error.hpp"
#include "core/numerics/smooth_step.hpp"
#include "core/numerics/two_pi.hpp"
#include "plant_sim/counter_noise.hpp"
#include "plant_sim/floor/block_values.hpp"
#include "plant_sim/floor/courses.hpp"
#include "plant_sim/floor/recording_file.hpp"
#include "plant_sim/floor/shaped_noise.hpp"

namespace stillframe {

namespace {

/// A transform needs several copies of a period; 1e7 samples of them are 0.5 GB.
constexpr double most_samples = 1e7;

/// Means over t to t + T, from the beginning of the force. Each writes the integral as a difference
/// of antiderivatives, or of cosines as a product, which loses no digits late in a long run.
double mean(const ForceStep& step, double t, double T) noexcept {
  const auto integral = [&](double s) {
    if (s <= 0.0) return 0.0;
    if (s >= step.rise_s) return s - 0.5 * step.rise_s;
    const double p = s / step.rise_s;
    return step.rise_s * p * p * p * p * (2.5 - 3.0 * p + p * p);
  };
  // Where nothing changes any more the two integrals would cancel.
  if (t >= step.rise_s) return step.height;
  return step.height * (integral(t + T) - integral(t)) / T;
}

double mean_of_sine(double omega, double t, double T) noexcept {
  const double half = 0.5 * omega * T;
  return half == 0.0 ? 0.0 : std::sin(omega * (t + 0.5 * T)) * std::sin(half) / half;
}

double mean(const ForceImpact& impact, double t, double T) noexcept {
  const double from = std::max(t, 0.0), to = std::min(t + T, impact.width_s);
  if (!(to > from)) return 0.0;
  const double omega = std::numbers::pi / impact.width_s;
  return impact.peak * mean_of_sine(omega, from, to - from) * (to - from) / T;
}

double mean(const ForceSine& sine, double t, double T) noexcept {
  const double from = std::max(t, 0.0), to = t + T;
  if (!(to > from)) return 0.0;
  // Whole periods are taken off: the sine of a large angle has lost the digits behind the point.
  const double turns = sine.frequency_hz * from;
  const double phase_time = (turns - std::floor(turns)) / sine.frequency_hz;
  return sine.amplitude * mean_of_sine(two_pi * sine.frequency_hz, phase_time, to - from) *
         (to - from) / T;
}

double mean(const ForceSweep& force, double t, double T) noexcept {
  const double middle = t + 0.5 * T;
  if (middle <= 0.0 || middle >= force.sweep_s) return 0.0;
  const floor::SweepCourse sweep{.from_hz = force.from_hz,
                                 .to_hz = force.to_hz,
                                 .amplitude = force.amplitude,
                                 .sweep_s = force.sweep_s,
                                 .linear = force.linear || force.from_hz == force.to_hz};
  return force.amplitude * floor::sweep_fade(sweep, middle) *
         std::sin(floor::sweep_phase(sweep, middle));
}

void require_below(double frequency_hz, double sample_time, const std::string& place) {
  if (frequency_hz * sample_time < 0.5) return;
  throw InputError(place + ": the force has " + floor::text_of(frequency_hz) +
                   " Hz, allowed is below " + floor::text_of(0.5 / sample_time) +
                   " Hz, half the control rate");
}

/// name: of the disturbance; each has a noise of its own.
Eigen::VectorXd noise_table(const ForceNoise& noise, double T, const std::string& name,
                            const std::string& place) {
  require_below(noise.psd.front().first, T, place);
  if (noise.period_s / T > most_samples) {
    throw InputError(place + ": period_s: found " + floor::text_of(noise.period_s) +
                     ", allowed is up to " + floor::text_of(most_samples * T));
  }
  const floor::NoiseShape shape{
      .density = floor::PointsDensity{noise.psd},
      .seed = CounterNoise::seed_of(noise.seed, "disturbance " + name),
      .rate = 1.0 / T,
      .period = std::max<std::int64_t>(1, std::llround(noise.period_s / T))};
  return floor::periodic_noise(shape, {0}, false).col(0);
}

Eigen::VectorXd recording_table(const ForceRecording& force, double T, const std::string& place) {
  const auto fail = [&](const char* key) {
    return [&place, key](const std::string& what) {
      throw InputError(place + ": " + key + ": " + what);
    };
  };
  const floor::RecordingPart part{.file = force.file,
                                  .units = "N",
                                  .columns = {force.column},
                                  .scale = force.scale,
                                  .start_s = force.start_s};
  const floor::RecordingErrors errors{
      .file = fail("file"),
      .start = fail("start_s"),
      .column = [&](std::size_t, const std::string& what) { fail("column")(what); }};
  return floor::play_recording(part, 1.0 / T, errors).row(0).transpose();
}

}  // namespace

ForceCourse::ForceCourse(const SceneDisturbance& disturbance, double sample_time)
    : force_(disturbance.force), sample_time_(sample_time) {
  const std::string place = disturbance.place + ": disturbance '" + disturbance.name + "'";
  begin_ =
      std::visit([&](const auto& force) { return std::llround(force.at_s / sample_time); }, force_);
  if (const auto* sine = std::get_if<ForceSine>(&force_)) {
    require_below(sine->frequency_hz, sample_time, place);
  } else if (const auto* sweep = std::get_if<ForceSweep>(&force_)) {
    require_below(std::max(sweep->from_hz, sweep->to_hz), sample_time, place);
  } else if (const auto* noise = std::get_if<ForceNoise>(&force_)) {
    table_ = noise_table(*noise, sample_time, disturbance.name, place);
  } else if (const auto* recording = std::get_if<ForceRecording>(&force_)) {
    table_ = recording_table(*recording, sample_time, place);
  }
}

double ForceCourse::at(std::int64_t k) const noexcept {
  if (table_.size() > 0) {
    const std::int64_t i = k - begin_;
    if (i < 0) return 0.0;
    if (std::holds_alternative<ForceNoise>(force_)) return table_(i % table_.size());
    return i < table_.size() ? table_(i) : 0.0;
  }
  return std::visit(
      [&](const auto& force) {
        if constexpr (requires { mean(force, 0.0, 1.0); }) {
          return mean(force, static_cast<double>(k) * sample_time_ - force.at_s, sample_time_);
        } else {
          return 0.0;
        }
      },
      force_);
}

}  // namespace stillframe

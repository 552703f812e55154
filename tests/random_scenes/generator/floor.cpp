#include <algorithm>
#include <cmath>

#include "tests/random_scenes/generator/draft.hpp"

namespace stillframe::random_scenes {

namespace {

/// One kind of floor; lasting: as long as the run.
std::string one_floor(Draft& draft, double level) {
  Draws& draws = draft.draws;
  const double T = draft.duration_s, f = draft.frequency_hz, nyquist = draft.rate_hz / 2;
  const std::string duration = "duration_s: " + Draft::number(T), amplitude = Draft::number(level);
  const std::string axis =
      draws.chance(0.5) ? "input: floor_1" : "axis: " + draws.one_of<std::string>({"x", "y"});
  switch (draws.below(6)) {
    case 0:
      return "{still: {" + duration + "}}";
    case 1:
      return "{white: {rms: " + amplitude + ", seed: " + std::to_string(draws.below(1000)) +
             ", high_pass_hz: " + Draft::number(0.1 * f) + ", " + duration + "}}";
    case 2:
      return "{noise: {psd: [[" + Draft::number(0.1 * f) + ", " + Draft::number(level * level / f) +
             "], [" + Draft::number(std::min(10 * f, 0.9 * nyquist)) + ", " +
             Draft::number(level * level / f / 10) + "]], high_pass_hz: " + Draft::number(0.1 * f) +
             ", period_s: " + Draft::number(T) + ", " + duration + "}}";
    case 3:
      return "{step: {height: " + Draft::number(level / (f * f * 40)) +
             ", rise_s: " + Draft::number(0.25 * T) + ", " + axis +
             ", at_s: " + Draft::number(0.1 * T) + ", " + duration + "}}";
    case 4:
      return "{impact: {peak: " + amplitude + ", width_s: " + Draft::number(0.2 * T) + ", " + axis +
             ", at_s: " + Draft::number(0.05 * T) + ", " + duration + "}}";
    default: {
      const double from = std::max(f * draws.scale(0.3, 1), 5 / T);
      return "{sine_sweep: {from_hz: " + Draft::number(from) +
             ", to_hz: " + Draft::number(std::min(4 * from, 0.9 * nyquist)) +
             ", amplitude: " + amplitude + ", sweep_s: " + Draft::number(0.9 * T) + ", " + axis +
             ", " + duration + "}}";
    }
  }
}

}  // namespace

void add_floor(Draft& draft) {
  if (draft.rate_hz == 0) return;
  Draws& draws = draft.draws;
  const int n_samples = draws.whole(60, 200);
  draft.duration_s = n_samples / draft.rate_hz;
  // From what a sensor barely sees to what moves the frame by a hundredth of its size.
  const double omega = 6.28 * draft.frequency_hz;
  const double level = 0.01 * draft.frame.size * omega * omega * draws.scale(1e-7, 0.3);
  const std::string floor = one_floor(draft, level);
  draft.blocks.push_back("floor: " + (draws.chance(0.15) ? "{sum: [" + floor + ", " +
                                                               one_floor(draft, 0.3 * level) + "]}"
                                                         : floor));
  draft.blocks.push_back("simulation: {relative_tolerance: " +
                         std::string(draws.one_of<const char*>({"1e-5", "1e-6", "1e-7"})) +
                         ", duration_s: " + Draft::number(draft.duration_s) + "}");
}

void add_disturbances(Draft& draft) {
  if (draft.rate_hz == 0 || !draft.draws.chance(0.4)) return;
  Draws& draws = draft.draws;
  const double T = draft.duration_s, omega = 6.28 * draft.frequency_hz;
  for (int i = draws.whole(1, 2); i > 0; --i) {
    const double force =
        0.01 * draft.frame.size * draft.frame.mass * omega * omega * draws.scale(1e-7, 0.2);
    const std::string size = Draft::number(force),
                      at = "at_s: " + Draft::number(T * draws.between(0, 0.3));
    const std::vector<std::string> kinds = {
        "step: {height: " + size + ", rise_s: " + Draft::number(draws.chance(0.5) ? 0 : 0.1 * T) +
            ", " + at + "}",
        "impact: {peak: " + size + ", width_s: " + Draft::number(0.05 * T) + ", " + at + "}",
        "sine: {amplitude: " + size + ", frequency_hz: " +
            Draft::number(std::min(draft.frequency_hz * draws.scale(0.3, 3), 0.4 * draft.rate_hz)) +
            ", " + at + "}",
        "noise: {psd: [[" + Draft::number(0.1 * draft.frequency_hz) + ", " +
            Draft::number(force * force / draft.frequency_hz) + "], [" +
            Draft::number(3 * draft.frequency_hz) + ", " +
            Draft::number(force * force / draft.frequency_hz) +
            "]], period_s: " + Draft::number(T) + ", seed: " + std::to_string(i) + "}"};
    const std::string free = draft.frame.turns ? draft.vector(draws.direction(draft.planar))
                             : draft.planar    ? "y"
                                               : "z";
    draft.disturbances.push_back("{name: force_" + std::to_string(i) + ", node: frame, along: " +
                                 free + ", force: {" + draws.one_of(kinds) + "}}");
  }
}

}  // namespace stillframe::random_scenes

#include "plant_sim/run_length.hpp"

#include <cmath>
#include <string>

#include "core/errors/input_error.hpp"
#include "plant_sim/floor/block_values.hpp"

namespace stillframe {

std::int64_t run_length(const Scene& scene, const floor::FloorSpec& spec,
                        std::int64_t floor_samples, std::optional<double> duration_s) {
  // A multisine, noise or a still floor states its own length; a recording is as long as somebody
  // recorded.
  const bool recorded = spec.recorded(), asked_for = duration_s.has_value();
  if (!asked_for && recorded && scene.simulation.duration_s > 0) {
    duration_s = scene.simulation.duration_s;
  }
  // What was held over the last interval stands in the measurement at its end.
  if (!duration_s) return floor_samples + 1;
  const double n = std::round(*duration_s * spec.sample_rate_hz);
  if (!(n >= 1 && n <= static_cast<double>(floor_samples))) {
    throw InputError((asked_for ? "--duration" : scene.file + ": simulation.duration_s") +
                     ": found " + floor::text_of(*duration_s) + " s, allowed is from " +
                     floor::text_of(1 / spec.sample_rate_hz) + " s, one sample, to " +
                     floor::text_of(static_cast<double>(floor_samples) / spec.sample_rate_hz) +
                     " s, the length of the floor");
  }
  return static_cast<std::int64_t>(n) + 1;
}

}  // namespace stillframe

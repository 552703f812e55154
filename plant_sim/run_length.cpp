#include "plant_sim/run_length.hpp"

#include <cmath>
#include <string>

#include "core/yaml/input_error.hpp"

namespace stillframe {

std::int64_t run_length(const Scene& scene, const floor::FloorSpec& spec,
                        std::int64_t floor_samples, std::optional<double> duration_s) {
  // A multisine, noise or a still floor states its own length; a recording is as long as somebody
  // recorded.
  const bool recorded = spec.recorded();
  if (!duration_s && recorded && scene.simulation.duration_s > 0) {
    duration_s = scene.simulation.duration_s;
  }
  // What was held over the last interval stands in the measurement at its end.
  if (!duration_s) return floor_samples + 1;
  const std::int64_t n = std::llround(*duration_s * spec.sample_rate_hz);
  if (n < 1 || n > floor_samples) {
    throw InputError(scene.file + ": duration_s: found " + std::to_string(*duration_s) +
                     ", allowed is up to the length of the floor, " +
                     std::to_string(static_cast<double>(floor_samples) / spec.sample_rate_hz) +
                     " s");
  }
  return n + 1;
}

}  // namespace stillframe

#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "core/model/model.hpp"
#include "core/scene/scene.hpp"
#include "plant_sim/plant.hpp"
#include "tests/faults/trace.hpp"

namespace stillframe::faults {

/// The same frame on the same floor with no force in its actuators: what the active one is compared
/// with. Computed in this process, without any bus.
class PassiveFrame {
 public:
  /// A scene file with a floor. Errors: InputError.
  explicit PassiveFrame(const std::filesystem::path& scene_file);

  /// The first n samples of every run. Errors: std::runtime_error if the motion cannot go on.
  const std::vector<Accelerations>& samples(std::int64_t n);

 private:
  Scene scene_;
  Model model_;
  std::unique_ptr<Plant> plant_;
  std::vector<Accelerations> samples_;
};

/// Largest absolute value of each output over samples [begin, end); what was not seen is left out.
Accelerations peak(const std::vector<Accelerations>& samples, std::int64_t begin, std::int64_t end);

/// Root mean square of each output over all samples.
Accelerations rms(const std::vector<Accelerations>& samples);

/// The largest of a_i / b_i over the outputs.
double largest_ratio(const Accelerations& a, const Accelerations& b);

}  // namespace stillframe::faults

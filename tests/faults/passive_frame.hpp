#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "core/mechanics/model/model.hpp"
#include "core/mechanics/scene/scene.hpp"
#include "plant_sim/floor_motion.hpp"
#include "tests/faults/trace.hpp"
#include "tests/plant_sim/linear_plant.hpp"

namespace stillframe::faults {

/// The same frame on the same floor without control: what the active one is compared with. The
/// linear frame, computed in this process without any bus, and cheap enough for whole tables.
class PassiveFrame {
 public:
  /// A scene file with a floor. Errors: InputError.
  explicit PassiveFrame(const std::filesystem::path& scene_file);

  /// The first n samples with no force at all.
  const std::vector<Accelerations>& samples(std::int64_t n);

  /// The first n samples with the forces `applied` (in sample k: what was held until then) until
  /// sample `from`, and the force of that sample ever after: a frame that is left to itself there.
  std::vector<Accelerations> held_from(const std::vector<Forces>& applied, std::int64_t from,
                                       std::int64_t n);

 private:
  Accelerations advance(test::LinearPlant& plant, std::int64_t k, const Eigen::VectorXd& force);

  Scene scene_;
  Model model_;
  std::unique_ptr<FloorMotion> floor_;
  std::vector<Eigen::VectorXd> floor_samples_;
  test::LinearPlant at_rest_, free_;
  std::vector<Accelerations> samples_;
};

/// Largest absolute value of each output over samples [begin, end); what was not seen is left out.
Accelerations peak(const std::vector<Accelerations>& samples, std::int64_t begin, std::int64_t end);

/// The largest of a_i / b_i over the outputs, NaN if one of them is.
double largest_ratio(const Accelerations& a, const Accelerations& b);

}  // namespace stillframe::faults

#include "tests/faults/passive_frame.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/scene/scene_reader.hpp"
#include "core/yaml/input_error.hpp"
#include "plant_sim/floor/floor_block.hpp"

namespace stillframe::faults {

PassiveFrame::PassiveFrame(const std::filesystem::path& scene_file)
    : scene_(read_scene(scene_file, {})), model_(make_model(scene_)) {
  const auto block = read_floor(scene_file, {});
  if (!block) throw InputError(scene_file.string() + ": no floor");
  const auto spec = floor::read_floor_block(block->reader, scene_.controller->sample_rate_hz,
                                            static_cast<Index>(scene_.inputs.size()));
  plant_ = std::make_unique<Plant>(scene_, model_, floor::make_floor_source(spec));
}

const std::vector<Accelerations>& PassiveFrame::samples(std::int64_t n) {
  const Eigen::VectorXd no_force =
      Eigen::VectorXd::Zero(static_cast<Index>(scene_.controller->legs.size()));
  while (static_cast<std::int64_t>(samples_.size()) < n) {
    const Eigen::VectorXd& frame = plant_->read().frame_acceleration;
    Accelerations& sample = samples_.emplace_back();
    std::copy_n(frame.begin(), sample.size(), sample.begin());
    const std::string reason = plant_->advance(no_force);
    if (!reason.empty()) throw std::runtime_error("the passive frame: " + reason);
  }
  return samples_;
}

Accelerations peak(const std::vector<Accelerations>& samples, std::int64_t begin,
                   std::int64_t end) {
  Accelerations largest{};
  for (auto k = std::max<std::int64_t>(begin, 0);
       k < std::min(end, static_cast<std::int64_t>(samples.size())); ++k) {
    const Accelerations& sample = samples[static_cast<std::size_t>(k)];
    for (std::size_t i = 0; i < sample.size(); ++i) {
      largest[i] = std::fmax(largest[i], std::abs(sample[i]));  // leaves NaN out
    }
  }
  return largest;
}

Accelerations rms(const std::vector<Accelerations>& samples) {
  Accelerations result{};
  for (const Accelerations& sample : samples) {
    for (std::size_t i = 0; i < sample.size(); ++i) result[i] += sample[i] * sample[i];
  }
  for (double& value : result) value = std::sqrt(value / static_cast<double>(samples.size()));
  return result;
}

double largest_ratio(const Accelerations& a, const Accelerations& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, a[i] / b[i]);
  return largest;
}

}  // namespace stillframe::faults

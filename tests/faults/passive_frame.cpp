#include "tests/faults/passive_frame.hpp"

#include <algorithm>
#include <cmath>

#include "core/errors/input_error.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "core/numerics/worst.hpp"
#include "plant_sim/floor/floor_block.hpp"

namespace stillframe::faults {

namespace {

std::unique_ptr<FloorMotion> floor_of(const Scene& scene, const Model& model) {
  const auto block = read_floor(scene, {});
  if (!block) throw InputError(scene.file + ": no floor");
  const auto spec = floor::read_floor_block(block->reader, scene.controller->sample_rate_hz,
                                            static_cast<Index>(scene.inputs.size()));
  return std::make_unique<FloorMotion>(floor::make_floor_source(spec), scene, model);
}

}  // namespace

PassiveFrame::PassiveFrame(const std::filesystem::path& scene_file)
    : scene_(read_scene(scene_file, {})),
      model_(make_model(scene_)),
      floor_(floor_of(scene_, model_)),
      at_rest_(scene_, model_),
      free_(at_rest_),
      samples_(1) {}

Accelerations PassiveFrame::advance(test::LinearPlant& plant, std::int64_t k,
                                    const Eigen::VectorXd& force) {
  while (static_cast<std::int64_t>(floor_samples_.size()) <= k) {
    floor_->take(static_cast<std::int64_t>(floor_samples_.size()));
    floor_->along_inputs(floor_samples_.emplace_back(scene_.inputs.size()));
  }
  plant.advance(force, force, 0, floor_samples_[static_cast<std::size_t>(k)]);
  Accelerations sample{};
  const Eigen::VectorXd frame = plant.read().frame_acceleration;
  std::copy_n(frame.begin(), sample.size(), sample.begin());
  return sample;
}

const std::vector<Accelerations>& PassiveFrame::samples(std::int64_t n) {
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(Forces{}.size());
  for (auto k = static_cast<std::int64_t>(samples_.size()); k < n; ++k) {
    samples_.push_back(advance(free_, k - 1, none));
  }
  return samples_;
}

std::vector<Accelerations> PassiveFrame::held_from(const std::vector<Forces>& applied,
                                                   std::int64_t from, std::int64_t n) {
  test::LinearPlant plant = at_rest_;
  Eigen::VectorXd force = Eigen::VectorXd::Zero(Forces{}.size());
  std::vector<Accelerations> result(1);
  for (std::int64_t k = 1; k < n; ++k) {
    if (k <= from) {
      const Forces& now = applied[static_cast<std::size_t>(k)];
      // A sample that was not seen leaves what was before.
      if (std::isfinite(now[0])) force = Eigen::Map<const Eigen::VectorXd>(now.data(), now.size());
    }
    result.push_back(advance(plant, k - 1, force));
  }
  return result;
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

double largest_ratio(const Accelerations& a, const Accelerations& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = worst_of(largest, a[i] / b[i]);
  return largest;
}

}  // namespace stillframe::faults

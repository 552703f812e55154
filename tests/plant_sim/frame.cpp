#include "tests/plant_sim/frame.hpp"

#include <random>

#include "core/mechanics/scene/scene_reader.hpp"
#include "plant_sim/floor/sources.hpp"

namespace stillframe::test {

std::filesystem::path frame_file() {
  return std::filesystem::path(STILLFRAME_SOURCE_DIR) / "config/scenes/metrology_frame.yaml";
}

Scene frame_scene() { return read_scene(frame_file()); }

std::unique_ptr<floor::FloorSource> table(Eigen::MatrixXd samples) {
  return std::make_unique<floor::TabulatedFloor>(floor::FloorChannels::inputs, std::move(samples));
}

std::unique_ptr<floor::FloorSource> translations(Eigen::MatrixXd samples) {
  const Eigen::Index n = samples.cols();
  return std::make_unique<floor::TabulatedFloor>(
      floor::FloorChannels::rigid, Eigen::MatrixXd::Identity(6, 3), std::move(samples), 0, n);
}

Eigen::MatrixXd noise(Eigen::Index rows, Eigen::Index cols, unsigned seed) {
  std::mt19937 engine(seed);  // its output is fixed by the standard, that of distributions is not
  Eigen::MatrixXd values(rows, cols);
  for (double& value : values.reshaped()) value = 2.0 * engine() / 4294967295.0 - 1.0;
  return values;
}

}  // namespace stillframe::test

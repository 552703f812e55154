// Speed against error of the plant's integrator: the undamped metrology frame on multisines, one
// row a tolerance. The error is that of the first frame acceleration over the whole run, relative,
// against the first row.
#include <chrono>
#include <iostream>

#include "bench/machine.hpp"
#include "core/scene/scene_reader.hpp"
#include "plant_sim/floor/floor_block.hpp"
#include "plant_sim/plant.hpp"
#include "report/table.hpp"

namespace {

using namespace stillframe;

constexpr int samples = 4000;

struct Run {
  Eigen::VectorXd acceleration;
  double microseconds, evaluations;
};

Run run(Scene scene, const Model& model, const std::filesystem::path& floor, double tolerance) {
  scene.simulation.relative_tolerance = tolerance;
  const auto block = read_floor(scene.file, floor);
  const auto spec = floor::read_floor_block(block->reader, scene.controller->sample_rate_hz,
                                            static_cast<Index>(scene.inputs.size()));
  Plant plant(scene, model, floor::make_floor_source(spec));
  const Eigen::VectorXd force =
      Eigen::VectorXd::Zero(static_cast<Index>(scene.controller->legs.size()));
  Run result{Eigen::VectorXd(samples), 0, 0};
  const auto begin = std::chrono::steady_clock::now();
  for (Index k = 0; k < samples; ++k) {
    if (const std::string reason = plant.advance(force); !reason.empty()) {
      throw std::runtime_error(reason);
    }
    result.acceleration(k) = plant.read().frame_acceleration(0);
  }
  const std::chrono::duration<double, std::micro> time = std::chrono::steady_clock::now() - begin;
  result.microseconds = time.count() / samples;
  result.evaluations = static_cast<double>(plant.evaluations()) / samples;
  return result;
}

}  // namespace

int main() try {
  const std::filesystem::path config = std::filesystem::path(STILLFRAME_SOURCE_DIR) / "config";
  const Scene scene = read_scene(config / "scenes/metrology_frame.yaml");
  const Model model = make_model(scene);
  std::cout << machine_line(STILLFRAME_FLAGS) << "\n";
  report::Table table({"tolerance", "us a sample", "evaluations", "relative error"}, 0);
  Eigen::VectorXd reference;
  for (const double tolerance : {1e-12, 1e-10, 1e-8, 1e-7, 1e-6, 1e-5}) {
    const Run result = run(scene, model, config / "floors/multisine.yaml", tolerance);
    if (reference.size() == 0) reference = result.acceleration;
    table.add({report::cell("%g", tolerance), report::cell("%.1f", result.microseconds),
               report::cell("%.1f", result.evaluations),
               report::cell("%.2e", (result.acceleration - reference).norm() / reference.norm())});
  }
  std::cout << table.print();
} catch (const std::exception& error) {
  std::cerr << error.what() << "\n";
  return 2;
}

#pragma once

#include <cmath>
#include <ctime>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/mechanics/scene/scene_reader.hpp"
#include "plant_sim/floor/floor_block.hpp"
#include "plant_sim/plant.hpp"

namespace stillframe {

/// Processor time of the calling thread, s: what others do on a shared machine hardly shows in it.
inline double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// A plant under forces that jump at every sample, and what came of it.
struct PlantRun {
  Eigen::MatrixXd acceleration, sigma;  ///< samples x outputs (m/s^2), x legs (N)
  double us_per_sample = 0, evaluations_per_sample = 0;
};

/// Forces of a scene's legs, the same numbers everywhere: in [-1, 1] times the amplitude (N).
inline Eigen::VectorXd forces_of_sample(Index n_legs, std::int64_t k, double amplitude) {
  Eigen::VectorXd force(n_legs);
  std::uint64_t state = 0x9e3779b97f4a7c15ull * static_cast<std::uint64_t>(k + 1);
  for (double& value : force) {
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    value = amplitude * (static_cast<double>(state >> 11) * 0x1p-52 - 1.0);
  }
  return force;
}

inline std::unique_ptr<floor::FloorSource> floor_of(const Scene& scene,
                                                    const std::filesystem::path& file) {
  const auto block = read_floor(scene, file.empty() ? std::nullopt : std::optional(file));
  return floor::make_floor_source(floor::read_floor_block(
      block->reader, scene.controller->sample_rate_hz, floor_input_names(scene)));
}

/// Runs a scene's plant for so many samples. Throws std::runtime_error with the plant's reason.
inline PlantRun run_plant(const Scene& scene, std::unique_ptr<floor::FloorSource> floor,
                          Index samples, double force_amplitude) {
  Plant plant(scene, std::move(floor));
  const auto n_legs = static_cast<Index>(scene.controller->legs.size());
  const auto n_y = static_cast<Index>(scene.outputs.size());
  PlantRun run{Eigen::MatrixXd(samples, n_y), Eigen::MatrixXd(samples, n_legs)};
  const double delay = scene.controller->delay_samples, fraction = delay - std::floor(delay);
  Eigen::VectorXd before = Eigen::VectorXd::Zero(n_legs);
  const double begin = thread_seconds();
  for (Index k = 0; k < samples; ++k) {
    const Eigen::VectorXd force = forces_of_sample(n_legs, k, force_amplitude);
    const auto reason = plant.advance(before, force, fraction);
    before = force;
    if (!reason.empty()) throw std::runtime_error(reason);
    const Reading& reading = plant.read();
    run.acceleration.row(k) = reading.frame_acceleration.head(n_y).transpose();
    run.sigma.row(k) = reading.sigma.transpose();
  }
  run.us_per_sample = 1e6 * (thread_seconds() - begin) / static_cast<double>(samples);
  run.evaluations_per_sample =
      static_cast<double>(plant.evaluations()) / static_cast<double>(samples);
  return run;
}

inline PlantRun run_plant(const Scene& scene, const std::filesystem::path& floor, Index samples,
                          double force_amplitude) {
  return run_plant(scene, floor_of(scene, floor), samples, force_amplitude);
}

/// |a - b| / |b| over all entries.
inline double relative_difference(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return (a - b).norm() / b.norm();
}

}  // namespace stillframe

#pragma once

#include <filesystem>
#include <memory>

#include "core/mechanics/model/model.hpp"
#include "core/mechanics/scene/scene.hpp"
#include "plant_sim/plant.hpp"

namespace stillframe::test {

/// The metrology frame of config/scenes.
std::filesystem::path frame_file();
Scene frame_scene();

/// A floor whose samples are given: inputs x samples, m/s^2.
std::unique_ptr<floor::FloorSource> table(Eigen::MatrixXd samples);
/// The same for three translations.
std::unique_ptr<floor::FloorSource> translations(Eigen::MatrixXd samples);

/// Fixed pseudo-random numbers in [-1, 1], the same everywhere.
Eigen::MatrixXd noise(Eigen::Index rows, Eigen::Index cols, unsigned seed);

}  // namespace stillframe::test

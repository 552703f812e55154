#pragma once

#include "core/control/fitting/rig_record.hpp"
#include "core/systems/sampled_plant.hpp"

namespace stillframe::fitting {

/// How a rig that is not there is driven and what disturbs it.
struct Drive {
  Eigen::Index n_window = 1000;
  int n_windows = 4, n_rest = 4;
  std::vector<int> lines;
  double force = 4;          ///< N, peak
  double floor_noise = 0;    ///< m/s^2, of each sample of each acceleration of the floor
  double sigma_noise = 0;    ///< N, likewise of the force sensors
  double applied_noise = 0;  ///< N, of what is read back
  double frame_noise = 0;    ///< m/s^2, likewise of the accelerometers of the frame
  unsigned seed = 1;
  bool floor_is_measured = false;
};

struct Simulated {
  RigRecord record;
  std::vector<bool> driven;
};

/// A plant that is stepped sample by sample while one leg after the other is driven; y is the
/// frame.
Simulated simulate(const SampledPlant& plant, const Drive& drive);

}  // namespace stillframe::fitting

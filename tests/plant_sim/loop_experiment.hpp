#pragma once

#include <Eigen/Core>

#include "report/identification/multisine.hpp"
#include "tests/plant_sim/random_settings.hpp"

// Experiments on the nonlinear plant under the law of a setting, in one process. Nothing here looks
// at the prediction, but for how long the loop is left to ring.
namespace stillframe::test {

/// How a loop rings on a floor that stands still again after a kick.
struct Ringing {
  double growth = 0;  ///< mean logarithmic growth of a sample, of forces and accelerations
  int samples = 0;    ///< that it took: fewer than asked for if the loop ran away

  bool stable() const { return growth < 0; }
};

Ringing ring(const RandomSetting& setting, int samples);

/// The multisine experiment of a setting: some 20 lines from 1 Hz (2 Hz from a rate of 450 Hz on, 4
/// Hz from 700 Hz on) to 0.4 of the rate.
MultisinePlan experiment_of(const RandomSetting& setting);

/// T from floor to frame accelerations at the lines of the plan.
report::FrequencyResponse measure(const RandomSetting& setting, const MultisinePlan& plan);

}  // namespace stillframe::test

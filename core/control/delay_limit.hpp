#pragma once

#include <Eigen/Core>

#include "core/control/discrete_law.hpp"
#include "core/systems/sampled_plant.hpp"

namespace stillframe {

/// How far a stable loop is from instability by delay, and how well that is known.
struct DelayLimit {
  double samples = 0;  ///< infinite: none that was looked for
  bool proven = true;  ///< that the loop is stable at every delay below; else at 64 of each sample
  int n_centres = 0;   ///< loops about which delays were proven
};

/// The least delay (samples, up to `longest`) at which a stable loop is not stable any more whose
/// legs of `mask` (ones and zeros) have their commands that much later, to 1e-6 of it or of a
/// quarter of a sample, whichever is less; the law does not know. From one delay to the next the
/// search goes only as far as DelayCentre proves that no pole reaches the unit circle. Set-up.
/// Errors: as close_loop; Refusal where poles are not found.
DelayLimit delay_limit(const LoopPlant& plant, const Sampling& sampling, const DiscreteLaw& law,
                       const Eigen::VectorXd& mask, double longest);

}  // namespace stillframe

#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "core/control/loop_settings.hpp"

namespace stillframe {

/// Factors between which the force that acts may be off the reported one with the loop still
/// stable; lowest 0 and highest infinite where no limit was found between 1e-3 and 1e3.
struct GainRange {
  double lowest = 0, highest = 0;
};

/// Samples up to which a delay margin is looked for: what is on its way is states of the loop.
inline constexpr double longest_delay = 20;

/// Distance of a sampled loop from instability.
struct Margins {
  std::vector<GainRange> leg_gain;  ///< m, each leg alone
  GainRange all_gain;               ///< all legs by the same factor
  Eigen::VectorXd leg_delay;        ///< m, s, that one leg's command may come later
  double all_delay = 0;             ///< s, that all may; infinite: more than longest_delay
  bool delays_proven = true;        ///< all of them (DelayLimit::proven)
  /// Balanced disk margin alpha: any factors (2 + alpha d) / (2 - alpha d), |d| < 1 complex, on the
  /// forces leave the loop stable: real ones between (2 - alpha) / (2 + alpha) and its inverse,
  /// lags up to 2 atan(alpha / 2). One leg at a time, and all at once with a d of their own each (a
  /// lower bound).
  Eigen::VectorXd leg_disk;
  double all_disk = 0;
  double all_disk_hz = 0;  ///< frequency at which all_disk is least
};

/// Margins of a stable loop: gains by bisection on the spectral radius, to 1e-6 of the distance to
/// the limit, delays by delay_limit, disk margins by 1 / max over omega of |S_ii - 1/2| and of the
/// structured singular value of S - I/2, S = (I + L)^-1, L the return ratio at the actuators, the
/// maximum found and, for one leg, proven by DiskSearch. A disk margin that could not be computed
/// is NaN.
/// The delay is added to the command, and what is reported as applied follows it. Source: Seiler,
/// Packard and Gahinet, IEEE Control Systems Magazine 40 (2020) 78-95. Errors: Refusal if the loop
/// is not stable to begin with.
Margins margins(const LoopSettings& settings);

/// all_disk and all_disk_hz alone, with `at_least` as for DiskSearch::of_all. Errors: as
/// close_loop; the loop is taken to be stable.
std::pair<double, double> all_leg_disk_margin(const LoopSettings& settings, double at_least = 0);

}  // namespace stillframe

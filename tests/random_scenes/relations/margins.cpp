#include "core/linear/margins.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/random_scenes/generator/draws.hpp"
#include "tests/random_scenes/relation.hpp"

namespace stillframe::random_scenes {

namespace {

using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Stability with factors on the legs' forces, and with additional delays, samples.
bool stable(const LoopSettings& settings, const VectorXd& gains, const VectorXd& delays) {
  LoopSettings changed = settings;
  Sampling& sampling = changed.sampling;
  sampling.leg_gains =
      sampling.leg_gains.size() > 0 ? VectorXd(sampling.leg_gains.cwiseProduct(gains)) : gains;
  sampling.leg_delays =
      sampling.leg_delays.size() > 0 ? VectorXd(sampling.leg_delays + delays) : delays;
  return spectral_radius(changed) < largest_stable_radius;
}

/// Gains are found to a part of 1e-6, delays to 1e-6 of a sample, so that some ten or a hundred of
/// these are on the right side. A delay may have a limit 1e-3 before a whole sample and none behind.
constexpr double beside_gain = 1e-4, beside_delay = 1e-5;

/// Checks a limit on the way from `from` to it: stable at random places before it and just inside,
/// not stable just outside. at(x): the loop x of the way.
template <class Stable>
void check_limit(Draws& draws, const Stable& at, double beside, const std::string& what,
                 Finding& finding) {
  for (int i = 0; i < 4; ++i) {
    finding.take(at(draws.between(0, 1 - beside)) ? 0 : 1, 0.5, what + ": not stable inside");
  }
  finding.take(at(1 - beside) ? 0 : 1, 0.5, what + ": not stable just inside");
  finding.take(at(1 + beside) ? 1 : 0, 0.5, what + ": stable just outside");
}

/// 1 / max |S_ii - 1/2| of one leg over the angles of all poles, and about them as far as they are
/// from the unit circle: where a peak is, a pole is near.
double disk_margin(const LoopSettings& settings, Index leg, const Eigen::VectorXcd& poles) {
  const SampledPlant plant = sample_and_hold(feedback_part(settings.plant), settings.sampling);
  const DiscreteLaw law = law_of(settings);
  const auto value = [&](double angle) {
    const MatrixXcd L = return_ratio(plant, law, angle / plant.sample_time);
    const MatrixXcd I = MatrixXcd::Identity(L.rows(), L.rows());
    return std::abs((I + L).partialPivLu().inverse()(leg, leg) - 0.5);
  };
  double largest = value(std::numbers::pi);
  for (const auto& pole : poles) {
    const double distance = std::abs(1 - std::abs(pole));
    for (const double offset : {0.0, 0.3, -0.3, 1.0, -1.0, 3.0, -3.0}) {
      const double angle = std::abs(std::arg(pole)) + offset * distance;
      if (angle > 1e-7 && angle < std::numbers::pi) largest = std::max(largest, value(angle));
    }
  }
  return 1 / largest;
}

}  // namespace

std::optional<Finding> check_margins(Case& scene, std::uint64_t seed) {
  if (!scene.has_loop()) return std::nullopt;
  const tools::LoopDesign& design = scene.design();
  if (!(design.radius < largest_stable_radius)) return std::nullopt;  // it has no margins
  Draws draws(seed);
  const LoopSettings& settings = design.settings;
  const Margins found = margins(settings);
  const Index m = settings.plant.B_u.cols();
  const VectorXd ones = VectorXd::Ones(m), zero = VectorXd::Zero(m);
  Finding finding;
  const auto check_gains = [&](const GainRange& range, const VectorXd& legs,
                               const std::string& what) {
    for (const double limit : {range.lowest, range.highest}) {
      const bool none = limit == 0 || std::isinf(limit);
      const double end = std::log(none ? (limit == 0 ? 1e-3 : 1e3) : limit);
      const auto at = [&](double x) {
        return stable(settings, (x * end * legs).array().exp(), zero);
      };
      if (!none) {
        check_limit(draws, at, beside_gain, what, finding);
      } else {
        for (int i = 0; i < 4; ++i)
          finding.take(at(draws.between(0, 1)) ? 0 : 1, 0.5, what + ": has a limit");
      }
    }
  };
  const auto check_delay = [&](double delay, const VectorXd& legs, const std::string& what) {
    const double samples = delay / settings.sampling.sample_time;
    const auto at = [&](double x) {
      return stable(settings, ones, x * (std::isinf(delay) ? longest_delay : samples) * legs);
    };
    if (!std::isinf(delay)) {
      check_limit(draws, at, std::min(0.5, beside_delay / samples), what, finding);
    } else {
      for (int i = 0; i < 2; ++i)
        finding.take(at(draws.between(0, 1)) ? 0 : 1, 0.5, what + ": has a limit");
    }
  };
  const Index leg = draws.below(static_cast<int>(m));
  check_gains(found.leg_gain[static_cast<size_t>(leg)], VectorXd::Unit(m, leg), "gain of a leg");
  check_gains(found.all_gain, ones, "gain of all legs");
  check_delay(found.leg_delay(leg), VectorXd::Unit(m, leg), "delay of a leg");
  check_delay(found.all_delay, ones, "delay of all legs");
  const Index n = design.closed.A.rows() - design.closed.n_exogenous;
  const double disk =
      disk_margin(settings, leg, design.closed.A.bottomRightCorner(n, n).eigenvalues());
  // A part of 1e-6 is what the margin is found to.
  finding.take(found.leg_disk(leg), disk * (1 + 1e-6), "disk margin of a leg");
  finding.take(found.all_disk, found.leg_disk.minCoeff() * (1 + 1e-6), "disk margin of all legs");
  // What the disk promises of gains is no more than what there is; one leg may have just that.
  const double alpha = found.all_disk;
  finding.take((2 - alpha) / (2 + alpha) < found.all_gain.lowest * (1 - 1e-5) ? 1 : 0, 0.5,
               "disk margin beside gain down");
  return finding;
}

}  // namespace stillframe::random_scenes

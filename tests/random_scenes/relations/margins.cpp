#include "core/control/margins.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

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
/// these are on the right side. A delay may have a limit 1e-3 before a whole sample and none
/// behind.
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

/// S - I/2 over the unit circle, by the return ratio: neither the system that the margins are of
/// nor their search is asked.
class Sensitivity {
 public:
  /// On angles about those of all poles, as far as they are from the unit circle (where a narrow
  /// peak is, a pole is near; of a slow one at almost no angle), and on a grid of thirty a decade.
  Sensitivity(const LoopSettings& settings, const Eigen::VectorXcd& poles)
      : plant_(sample_and_hold(feedback_part(settings.plant), settings.sampling)),
        law_(law_of(settings)) {
    for (const auto& pole : poles) {
      const double distance = std::abs(1 - std::abs(pole));
      for (const double offset : {0.0, 1e-3, 0.3, -0.3, 1.0, -1.0, 3.0, -3.0}) {
        angles_.push_back(std::abs(std::arg(pole)) + offset * distance);
      }
    }
    for (int i = 0; i <= 180; ++i) angles_.push_back(std::numbers::pi * std::pow(10, -i / 30.0));
    std::erase_if(angles_, [](double angle) { return angle < 1e-12 || angle > std::numbers::pi; });
    std::sort(angles_.begin(), angles_.end());
    keep_apart(poles);
    for (const double angle : angles_) values_.push_back(at(angle));
  }

  /// The largest size(S - I/2), to rounding: what is highest on the grid, and refined between its
  /// neighbours by the golden section.
  template <class Size>
  double peak(const Size& size) const {
    std::vector<double> sizes;
    for (const MatrixXcd& value : values_) sizes.push_back(size(value));
    // Of the grid's hills the three that are highest there: the highest may be between its angles.
    std::vector<size_t> hills;
    for (size_t i = 0; i < sizes.size(); ++i) {
      if ((i == 0 || sizes[i] >= sizes[i - 1]) &&
          (i + 1 == sizes.size() || sizes[i] >= sizes[i + 1])) {
        hills.push_back(i);
      }
    }
    const auto n = std::min<std::ptrdiff_t>(3, std::ssize(hills));
    std::partial_sort(hills.begin(), hills.begin() + n, hills.end(),
                      [&](size_t i, size_t j) { return sizes[i] > sizes[j]; });
    double largest = 0;
    for (auto hill = hills.begin(); hill != hills.begin() + n; ++hill) {
      double low = angles_[std::max<size_t>(*hill, 1) - 1],
             high = angles_[std::min(*hill + 1, sizes.size() - 1)];
      largest = std::max(largest, sizes[*hill]);
      // The section shrinks by 1e-8, and the value is as flat as its square.
      const double golden = (std::sqrt(5.0) - 1) / 2;
      double a = high - golden * (high - low), b = low + golden * (high - low);
      double left = size(at(a)), right = size(at(b));
      for (int i = 0; i < 40; ++i) {
        largest = std::max({largest, left, right});
        if (left > right) {
          high = b, b = a, right = left;
          left = size(at(a = high - golden * (high - low)));
        } else {
          low = a, a = b, left = right;
          right = size(at(b = low + golden * (high - low)));
        }
      }
    }
    return largest;
  }

 private:
  /// Leaves one of angles that their values cannot tell apart. About a peak of half-width w, the
  /// distance of its pole, values fall as 1 - (x / w)^2 / 2 and carry the rounding of z over w, so
  /// that they order angles down to the root of 2 eps w and not below. Conjugates lie at one angle,
  /// poles of legs that are alike at one but for rounding: the neighbours of a hill among them
  /// would be a bracket of no width, or one of which rounding has chosen the side, the peak outside
  /// it, and all hills that are looked at might be this one. Without them every bracket is wider
  /// than what is not known of where its peak is.
  void keep_apart(const Eigen::VectorXcd& poles) {
    // A sum of n terms and the solutions of systems of n: about a hundred roundings.
    constexpr double rounding = 100 * std::numeric_limits<double>::epsilon();
    const auto distance = [&](double angle) {
      return (poles.array() - std::polar(1.0, angle)).abs().minCoeff();
    };
    const auto same = [&](double a, double b) {
      return b - a <= std::sqrt(2 * rounding * distance(a));
    };
    angles_.erase(std::unique(angles_.begin(), angles_.end(), same), angles_.end());
  }

  MatrixXcd at(double angle) const {
    const MatrixXcd L = return_ratio(plant_, law_, angle / plant_.sample_time);
    const MatrixXcd I = MatrixXcd::Identity(L.rows(), L.rows());
    return (I + L).partialPivLu().inverse() - 0.5 * I;
  }

  SampledPlant plant_;
  DiscreteLaw law_;
  std::vector<double> angles_;
  std::vector<MatrixXcd> values_;
};

}  // namespace

std::optional<Finding> check_margins(Case& scene, std::uint64_t seed) {
  if (!scene.has_loop()) return std::nullopt;
  const judge::LoopDesign& design = scene.design();
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
  const Sensitivity sensitivity(settings, design.closed.A.bottomRightCorner(n, n).eigenvalues());
  const double disk =
      1 / sensitivity.peak([&](const MatrixXcd& Z) { return std::abs(Z(leg, leg)); });
  // A part of 1e-6 is what the margin is found to, and ten times that what a peak nearer to a pole
  // than its rounding may lose.
  finding.take(std::abs(found.leg_disk(leg) - disk), 1e-5 * disk, "disk margin of a leg", disk);
  finding.take(found.all_disk, found.leg_disk.minCoeff() * (1 + 1e-6), "disk margin of all legs");
  // The structured singular value lies between the spectral radius and the norm.
  const double all = 1 / sensitivity.peak([](const MatrixXcd& Z) {
    return Z.eigenvalues().cwiseAbs().maxCoeff();
  });
  const double least = 1 / sensitivity.peak([](const MatrixXcd& Z) { return Z.operatorNorm(); });
  finding.take(found.all_disk, all * (1 + 1e-5), "disk margin of all legs beside what breaks it");
  finding.take(least, found.all_disk * (1 + 1e-5), "disk margin of all legs beside the norm");
  // What the disk promises of gains is no more than what there is; one leg may have just that.
  const double alpha = found.all_disk;
  finding.take((2 - alpha) / (2 + alpha) < found.all_gain.lowest * (1 - 1e-5) ? 1 : 0, 0.5,
               "disk margin beside gain down");
  return finding;
}

}  // namespace stillframe::random_scenes

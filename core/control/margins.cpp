#include "core/control/margins.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "core/control/close_loop.hpp"
#include "core/control/delay_limit.hpp"
#include "core/control/disk_margin.hpp"
#include "core/errors/input_error.hpp"
#include "core/numerics/infinity.hpp"

namespace stillframe {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// The value at which `stable` first fails on the way from `from` (stable) through `values`, halved
/// down to 1e-6 of the step and of the distance from `from`, which for a loop that is nearly
/// unstable is the smaller of the two; infinity if it does not fail.
double first_failure(const std::function<bool(double)>& stable, double from,
                     const std::vector<double>& values) {
  constexpr double part = 1e-6;
  constexpr int most = 50;  // then two numbers are next to each other, or the distance is none
  double good = from;
  for (double bad : values) {
    if (stable(bad)) {
      good = bad;
      continue;
    }
    const double step = std::abs(bad - good);
    for (int j = 0; j < most; ++j) {
      if (std::abs(bad - good) <= part * std::min(step, std::abs(good - from))) break;
      const double middle = (good + bad) / 2;
      (stable(middle) ? good : bad) = middle;
    }
    return good;
  }
  return infinity;
}

/// From `from` (not with it) to `to` in steps of `step`.
std::vector<double> steps(double from, double to, double step) {
  const int n = static_cast<int>(std::ceil(std::abs((to - from) / step)));
  std::vector<double> values;
  for (int i = 1; i <= n; ++i) values.push_back(from + (to - from) * i / n);
  return values;
}

/// Tries perturbed loops with one law; the law does not know of the perturbation.
class Perturbed {
 public:
  explicit Perturbed(const LoopSettings& settings)
      : plant_(feedback_part(settings.plant)),
        sampling_(settings.sampling),
        law_(law_of(settings)),
        m_(plant_.B_u.cols()) {}

  bool stable_with_gains(const VectorXd& factors) const {
    Sampling sampling = sampling_;
    sampling.leg_gains = sampling_.leg_gains.size() > 0
                             ? VectorXd(sampling_.leg_gains.cwiseProduct(factors))
                             : factors;
    return stable(sampling);
  }
  /// Factors 10^x on the legs of `mask` (ones and zeros).
  GainRange gain_range(const VectorXd& mask) const {
    const auto stable = [&](double x) {
      return stable_with_gains((std::log(10.0) * x * mask).array().exp());
    };
    const double down = first_failure(stable, 0, steps(0, -3, 0.05)),
                 up = first_failure(stable, 0, steps(0, 3, 0.05));
    return {down == infinity ? 0.0 : std::pow(10, down),
            up == infinity ? infinity : std::pow(10, up)};
  }
  /// Seconds by which the legs of `mask` (one, or all) may be late; clears `proven` if that is not.
  double delay_limit(const VectorXd& mask, bool& proven) const {
    const DelayLimit limit = stillframe::delay_limit(plant_, sampling_, law_, mask, longest_delay);
    proven = proven && limit.proven;
    return limit.samples * sampling_.sample_time;
  }
  Index n_legs() const { return m_; }

 private:
  bool stable(const Sampling& sampling) const {
    const double radius = spectral_radius(close_loop(sample_and_hold(plant_, sampling), law_));
    return radius < largest_stable_radius;
  }

  LoopPlant plant_;
  Sampling sampling_;
  DiscreteLaw law_;
  Index m_;
};

}  // namespace

std::pair<double, double> all_leg_disk_margin(const LoopSettings& settings, double at_least) {
  const DiskMargin margin = DiskSearch(settings).of_all(at_least);
  return {margin.alpha, margin.hz};
}

Margins margins(const LoopSettings& settings) {
  const double radius = spectral_radius(settings);
  if (!(radius < largest_stable_radius)) {
    throw Refusal("a loop of spectral radius " + std::to_string(radius) + " has no margins");
  }
  const Perturbed loop(settings);
  const Index m = loop.n_legs();
  Margins out;
  out.leg_delay.resize(m);
  for (Index i = 0; i < m; ++i) {
    out.leg_gain.push_back(loop.gain_range(VectorXd::Unit(m, i)));
    out.leg_delay(i) = loop.delay_limit(VectorXd::Unit(m, i), out.delays_proven);
  }
  out.all_gain = loop.gain_range(VectorXd::Ones(m));
  out.all_delay = loop.delay_limit(VectorXd::Ones(m), out.delays_proven);
  DiskSearch search(settings);
  DiskMargin least = search.of_all();
  out.leg_disk.resize(m);
  for (Index i = 0; i < m; ++i) {
    const DiskMargin leg = search.of_leg(i);
    out.leg_disk(i) = leg.alpha;
    if (std::isnan(least.alpha)) continue;
    // All legs at once have no more than each, and what is not known of one is not of all.
    if (std::isnan(leg.alpha) || leg.alpha < least.alpha) least = leg;
  }
  out.all_disk = least.alpha;
  out.all_disk_hz = least.hz;
  return out;
}

}  // namespace stillframe

#include "core/linear/margins.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "core/linear/disk_margin.hpp"
#include "core/linear/eigenvalues.hpp"
#include "core/linear/sampled_loop.hpp"
#include "core/yaml/input_error.hpp"

namespace stillframe {

using Eigen::Index;
using Eigen::VectorXcd;
using Eigen::VectorXd;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

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

/// Where a loop without known poles may fail nobody can say.
VectorXcd known(const std::optional<VectorXcd>& values) {
  if (!values) throw Refusal("the poles of a perturbed loop are not found: it has no margins");
  return *values;
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
  bool stable_with_delays(const VectorXd& samples) const {
    Sampling sampling = sampling_;
    sampling.leg_delays =
        sampling_.leg_delays.size() > 0 ? VectorXd(sampling_.leg_delays + samples) : samples;
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
  /// Seconds by which the legs of `mask` (one, or all) may be late: looked for in quarters of a
  /// sample up to 4, in halves up to longest_delay, and at each delay that turns a resonance into
  /// the worst phase, as the loop may be unstable there alone. Just before a delay of whole samples
  /// as well: a force that changes with the measurement is measured as it was before, so that
  /// stability jumps there.
  double delay_limit(const VectorXd& mask) const {
    constexpr double just = 1e-3;
    std::vector<double> samples = steps(0, 4, 0.25);
    for (const double half : steps(4, longest_delay, 0.5)) samples.push_back(half);
    for (Index i = 0; i < m_; ++i) {
      if (mask(i) == 0) continue;
      const double own = sampling_.delay_samples +
                         (sampling_.leg_delays.size() > 0 ? sampling_.leg_delays(i) : 0.0);
      for (const double whole : steps(std::floor(own), std::floor(own) + longest_delay, 1)) {
        if (whole - own > 2 * just) samples.push_back(whole - own - just);
      }
    }
    for (const double worst : worst_delays(mask)) samples.push_back(worst);
    std::sort(samples.begin(), samples.end());
    const auto stable = [&](double late) { return stable_with_delays(late * mask); };
    return first_failure(stable, 0, samples) * sampling_.sample_time;
  }
  Index n_legs() const { return m_; }

 private:
  /// The delays (samples) at which what goes round through the commands of the legs of `mask`, the
  /// others closed, comes back in antiphase and no smaller, at the frequencies of the poles. A mode
  /// of the plant turns by its own frequency, also where that is above half the rate: within a
  /// sample it may turn more than once. Every mode is damped by as little as divides stable from
  /// unstable: at that of an undamped one the return ratio has no value, and beside it not the
  /// phase of its peak.
  std::vector<double> worst_delays(const VectorXd& mask) const {
    LoopPlant damped = plant_;
    damped.A.diagonal().array() += std::log(largest_stable_radius) / sampling_.sample_time;
    const SampledPlant plant = sample_and_hold(damped, sampling_);
    std::vector<double> angles;  // per sample
    for (const std::complex<double> pole :
         known(eigenvalues(close_loop(sample_and_hold(plant_, sampling_), law_).A))) {
      angles.push_back(std::arg(pole));
    }
    std::vector<double> delays;
    for (const std::complex<double> mode : known(eigenvalues(plant_.A))) {
      // What has died away after a sample is no resonance.
      const std::complex<double> turn = mode * sampling_.sample_time;
      if (turn.real() > -3) angles.push_back(turn.imag());
      // One that a small push makes unstable: what the loop does to it is known to first order.
      if (turn.real() > -0.1 && turn.imag() > slowest) add_driven(turn, mask, delays);
    }
    constexpr double turn = 2 * std::numbers::pi, nearly_one = 0.9;
    for (const double angle : angles) {
      if (!(angle > slowest)) continue;
      for (const std::complex<double> round : round_trips(plant, mask, angle)) {
        if (!(std::abs(round) >= nearly_one)) continue;
        double phase = std::arg(round) - turn / 2;
        if (phase <= 0) phase += turn;
        for (; phase <= angle * longest_delay; phase += turn) delays.push_back(phase / angle);
      }
    }
    return delays;
  }
  /// Adds the delays at which the loop drives a mode of the plant (its exponent over a sample) the
  /// hardest. About its pole p the return ratio is R / (z - p) + L_0, and the loop moves p by
  /// -trace((I + E_0 L_0)^-1 E R), to first order, with the delays E of the mode's own turn and E_0
  /// of the turn that the samples see: above half the rate these go round at different paces.
  void add_driven(std::complex<double> turn, const VectorXd& mask,
                  std::vector<double>& delays) const {
    constexpr double two_pi = 2 * std::numbers::pi;
    // Far beyond what p is known to, far below what L_0 changes in.
    constexpr double beside = 1e-4;
    const auto at = [&](double growth) {
      LoopPlant moved = plant_;
      moved.A.diagonal().array() += (growth - turn.real()) / sampling_.sample_time;
      return return_ratio(sample_and_hold(moved, sampling_), law_,
                          turn.imag() / sampling_.sample_time, Cut::command);
    };
    const Eigen::MatrixXcd inside = at(-beside), outside = at(beside);
    const Eigen::MatrixXcd R = beside / 2 * (inside - outside), L_0 = (inside + outside) / 2;
    const double seen = std::remainder(turn.imag(), two_pi);
    const auto growth = [&](double samples) {
      const auto late = [&](double angle) {
        return VectorXcd((std::complex<double>(0, -angle * samples) * mask).array().exp());
      };
      Eigen::MatrixXcd closed = late(seen).asDiagonal() * L_0;
      closed.diagonal().array() += 1;
      return -closed.partialPivLu().solve(late(turn.imag()).asDiagonal() * R).trace().real();
    };
    // Twelve a turn: the highest of these is within 4 % of the peak.
    const double step = two_pi / turn.imag() / 12;
    double before = growth(0), here = growth(step);
    for (double samples = step; samples < longest_delay; samples += step) {
      const double next = growth(samples + step);
      if (here > before && here >= next && here > -turn.real() / 2) delays.push_back(samples);
      before = here, here = next;
    }
  }
  /// Of all legs the eigenvalues of the return ratio; of one leg its own with the others closed.
  Eigen::VectorXcd round_trips(const SampledPlant& plant, const VectorXd& mask,
                               double angle) const {
    const Eigen::MatrixXcd L = return_ratio(plant, law_, angle / plant.sample_time, Cut::command);
    if (mask.sum() > 1) return known(eigenvalues(L));
    Index leg = 0;
    mask.maxCoeff(&leg);
    const Eigen::MatrixXcd I = Eigen::MatrixXcd::Identity(m_, m_);
    const std::complex<double> S = (I + L).partialPivLu().inverse()(leg, leg);
    return Eigen::VectorXcd::Constant(1, 1.0 / S - 1.0);
  }
  static constexpr double slowest = 1e-3;  ///< rad per sample

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
    out.leg_delay(i) = loop.delay_limit(VectorXd::Unit(m, i));
  }
  out.all_gain = loop.gain_range(VectorXd::Ones(m));
  out.all_delay = loop.delay_limit(VectorXd::Ones(m));
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

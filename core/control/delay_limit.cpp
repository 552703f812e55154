#include "core/control/delay_limit.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/control/close_loop.hpp"
#include "core/control/delay_centre.hpp"
#include "core/errors/input_error.hpp"
#include "core/numerics/eigenvalues.hpp"
#include "core/numerics/infinity.hpp"

namespace stillframe {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// Then the rest is looked at: most limits of random loops take one a sample, some 170 in all.
constexpr int most_centres = 300;

/// rad, by which the fastest mode may turn from one step of a centre to the next, and how many
/// steps there may be.
constexpr double resolved = 0.5;
constexpr int fewest_steps = 8, most_steps = 400;

/// To which a limit is found.
double known_to(double samples) { return 1e-6 * std::min(0.25, std::max(samples, 1e-9)); }

class Search {
 public:
  Search(const LoopPlant& plant, const Sampling& sampling, const DiscreteLaw& law,
         const VectorXd& mask)
      : plant_(plant), sampling_(sampling), law_(law), mask_(mask) {
    if (sampling_.leg_delays.size() == 0) sampling_.leg_delays = VectorXd::Zero(mask.size());
    for (Index i = 0; i < mask.size(); ++i) {
      if (mask(i) != 0) legs_.push_back(i);
    }
    const auto modes = eigenvalues(plant.A);
    if (!modes) throw Refusal("the modes of a plant are not found: its loop has no delay margin");
    for (const std::complex<double> mode : *modes) {
      const std::complex<double> turn = mode * sampling_.sample_time;
      // What has died away after a sample turns nothing.
      if (turn.real() > -5) fastest_ = std::max(fastest_, std::abs(turn.imag()));
    }
  }

  DelayLimit run(double longest) {
    // Where a leg's delay passes a whole sample the loop gets a state more, and a force that
    // changes with the measurement is measured as it is after: each piece is one with its ends.
    std::vector<double> ends{longest};
    for (const Index i : legs_) {
      const double own = sampling_.delay_samples + sampling_.leg_delays(i);
      for (double whole = std::floor(own) + 1; whole - own < longest; ++whole) {
        ends.push_back(whole - own);
      }
    }
    std::sort(ends.begin(), ends.end());
    double from = 0;
    out_.samples = infinity;
    for (const double to : ends) {
      if (to - from < 1e-9) continue;
      out_.samples = first_in(from, to);
      if (out_.samples < infinity) break;
      from = to;
    }
    return out_;
  }

 private:
  Sampling at(double samples) const {
    Sampling out = sampling_;
    out.leg_delays += samples * mask_;
    return out;
  }
  bool stable(double samples) const {
    return spectral_radius(close_loop(sample_and_hold(plant_, at(samples)), law_)) <
           largest_stable_radius;
  }
  /// A limit between `low` (stable) and `high` (not), from below.
  double halved(double low, double high) const {
    while (high - low > known_to(low)) {
      const double middle = (low + high) / 2;
      if (middle == low || middle == high) break;
      (stable(middle) ? low : high) = middle;
    }
    return low;
  }

  /// The first limit between `from` and `to`, infinite if there is none. What was found is an end
  /// to which all before it is proven in turn.
  double first_in(double from, double to) {
    double good = from, end = to, width = to - from;
    bool limited = false;
    const auto ends_before = [&](double bad) {
      end = halved(good, bad);
      limited = true;
    };
    while (end - good > known_to(good)) {
      width = std::min({width, end - good, 2 * most_steps * resolved / fastest_});
      if (width < 1e-7 * (end - from) || out_.n_centres >= most_centres) {
        out_.proven = false;
        const double next = std::min(end, good + 1.0 / 64);
        if (next < end && !stable(next)) {
          ends_before(next);
        } else {
          good = next;
        }
        width = 1.0 / 64;
        continue;
      }
      const double half = width / 2, middle = good + half;
      const DelayCentre centre(plant_, at(middle), law_, legs_);
      ++out_.n_centres;
      if (!centre.stable()) {
        if (!stable(good + known_to(good) / 2)) return good;  // since the whole sample
        ends_before(middle);
        continue;
      }
      const int n = static_cast<int>(std::ceil(half * fastest_ / resolved));
      const auto [before, after] = centre.reach(half, std::clamp(n, fewest_steps, most_steps));
      if (before < half) {
        width = std::clamp(1.6 * before, width / 16, width / 2);
        continue;
      }
      good = middle + after;
      if (after == half) width *= 2;
    }
    return limited ? end : infinity;
  }

  const LoopPlant& plant_;
  Sampling sampling_;
  const DiscreteLaw& law_;
  VectorXd mask_;
  std::vector<Index> legs_;
  double fastest_ = 1;  ///< rad per sample, by which a mode of the plant turns
  DelayLimit out_;
};

}  // namespace

DelayLimit delay_limit(const LoopPlant& plant, const Sampling& sampling, const DiscreteLaw& law,
                       const VectorXd& mask, double longest) {
  return Search(plant, sampling, law, mask).run(longest);
}

}  // namespace stillframe

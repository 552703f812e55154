#include "core/control/loop_settings.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/numerics/two_pi.hpp"

namespace stillframe {

using Eigen::Index;
using Eigen::MatrixXd;

LoopPlant feedback_part(const LoopPlant& plant) {
  const Index n = plant.A.rows() - plant.n_exogenous, m = plant.B_u.cols();
  return {.A = plant.A.topLeftCorner(n, n),
          .B_w = MatrixXd::Zero(n, 0),
          .B_u = plant.B_u.topRows(n),
          .C_y = MatrixXd::Zero(0, n),
          .D_yw = MatrixXd::Zero(0, 0),
          .D_yu = MatrixXd::Zero(0, m),
          .C_sigma = plant.C_sigma.leftCols(n)};
}

DiscreteLaw law_of(const LoopSettings& settings) {
  if (settings.own) {
    DiscreteLaw law = *settings.own;
    law.feed_forward = {};
    return law;
  }
  LawSampling sampling = settings.law;
  sampling.sample_time = settings.sampling.sample_time;
  sampling.sensor_filter_hz = settings.sampling.instruments.sensor_filter_hz;
  return sample_law(settings.feedback, sampling);
}

DiscreteLaw whole_law_of(const LoopSettings& settings) {
  if (settings.own) return *settings.own;
  DiscreteLaw law = law_of(settings);
  law.feed_forward = feed_forward_system(settings.feed_forward);
  return law;
}

double lateness(const Sampling& sampling) {
  const double lag = two_pi * sampling.instruments.actuator_lag_hz;
  return sampling.delay_samples + 0.5 + (lag > 0 ? 1 / (lag * sampling.sample_time) : 0.0);
}

double matched_lead(const Sampling& sampling, double roll_off) {
  return lateness(sampling) + (roll_off > 0 ? 1 / (roll_off * sampling.sample_time) : 0.0);
}

LoopSettings with_roll_off(LoopSettings settings, double roll_off) {
  settings.feedback.roll_off = roll_off;
  settings.law.lead_samples = matched_lead(settings.sampling, roll_off);
  return settings;
}

ForceFeedback continuous_law(const LoopSettings& settings) {
  const Sampling& sampling = settings.sampling;
  ForceFeedback law = settings.feedback;
  law.lead = std::max(settings.law.lead_samples - lateness(sampling), 0.0) * sampling.sample_time;
  return law;
}

SampledLoop close_loop(const LoopSettings& settings) {
  return close_loop(sample_and_hold(settings.plant, settings.sampling), whole_law_of(settings));
}

double spectral_radius(const LoopSettings& settings) {
  return spectral_radius(close_loop(
      sample_and_hold(feedback_part(settings.plant), settings.sampling), law_of(settings)));
}

LoopSettings at_rate(LoopSettings settings, double rate_hz) {
  if (settings.own) throw std::invalid_argument("at_rate: a law of one's own has one rate");
  settings.sampling.sample_time = 1 / rate_hz;
  settings.feed_forward = {};
  return settings;
}

std::vector<std::pair<double, double>> stable_rates(const LoopSettings& settings, double lowest_hz,
                                                    double highest_hz) {
  const auto stable = [&](double log_rate) {
    return spectral_radius(at_rate(settings, std::exp(log_rate))) < largest_stable_radius;
  };
  const double from = std::log(lowest_hz), to = std::log(highest_hz);
  const int n = static_cast<int>(std::ceil(30 * (to - from) / std::log(10.0)));
  const auto edge = [&](double good, double bad) {
    while (std::abs(good - bad) > 1e-6) {
      const double middle = (good + bad) / 2;
      (stable(middle) ? good : bad) = middle;
    }
    return std::exp(good);
  };
  std::vector<std::pair<double, double>> found;
  double before = from;
  bool was_stable = false;
  for (int i = 0; i <= n; ++i) {
    const double here = from + (to - from) * i / n;
    const bool is_stable = stable(here);
    if (is_stable && !was_stable) {
      found.emplace_back(i == 0 ? lowest_hz : edge(here, before), highest_hz);
    }
    if (!is_stable && was_stable) found.back().second = edge(before, here);
    was_stable = is_stable;
    before = here;
  }
  return found;
}

}  // namespace stillframe

#include "tests/plant_sim/loop_experiment.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "controller/law.hpp"
#include "plant_sim/command_queue.hpp"
#include "plant_sim/floor/multisine.hpp"
#include "tests/plant_sim/frame.hpp"

namespace stillframe::test {

namespace {

/// m/s^2. Relative to the motion the nonlinearity is as large as the motion is against the metre of
/// the frame (test_prediction.cpp: 1e-2 at 1 m/s^2, proportional), here some 1e-11.
constexpr double amplitude = 1e-9;
constexpr int kick_samples = 50;
/// Growth beyond which no decaying loop comes, whatever it does at first.
constexpr double runaway = 1e6;
/// kg: what turns accelerations into forces of the size of those of the legs.
constexpr double share_of_a_leg = 750.0 / 6;

/// Plant, commands on their way, and law.
class Loop {
 public:
  Loop(const RandomSetting& setting, Eigen::MatrixXd floor)
      : plant_(setting.design.scene, setting.design.model, table(std::move(floor))),
        queue_(setting.design.gains.n_legs(), setting.design.gains.delay_samples),
        law_(setting.law),
        force_(Eigen::VectorXd::Zero(setting.design.gains.n_legs())) {}

  /// One sample; answers what the instruments read at its end.
  const Reading& step() {
    const Reading& reading = plant_.read();
    law_.step(reading.sigma, reading.applied_force, force_);
    if (queue_.needs_answer()) {
      queue_.push(force_);
      advance();
    } else {
      advance();
      queue_.push(force_);
    }
    return plant_.read();
  }

  const Eigen::VectorXd& force() const { return force_; }

 private:
  void advance() {
    ASSERT_EQ(plant_.advance(queue_.before(), queue_.after(), queue_.fraction()), "");
  }

  Plant plant_;
  CommandQueue queue_;
  controller::Law law_;
  Eigen::VectorXd force_;
};

/// Size of all that the instruments see and the law does, N.
double size_of(const Reading& reading, const Eigen::VectorXd& force) {
  return std::sqrt(reading.sigma.squaredNorm() + force.squaredNorm() +
                   std::pow(share_of_a_leg, 2) * reading.frame_acceleration.head(6).squaredNorm());
}

double root_mean_square(const std::vector<double>& sizes, std::size_t begin, std::size_t end) {
  double sum = 0;
  for (std::size_t k = begin; k < end; ++k) sum += sizes[k] * sizes[k];
  return std::sqrt(sum / static_cast<double>(end - begin));
}

}  // namespace

Ringing ring(const RandomSetting& setting, int samples) {
  Loop loop(setting, amplitude * noise(6, kick_samples, 7));
  double kick = 0;
  std::vector<double> sizes;
  for (int k = 0; k < kick_samples; ++k) kick = std::max(kick, size_of(loop.step(), loop.force()));
  while (static_cast<int>(sizes.size()) < samples) {
    sizes.push_back(size_of(loop.step(), loop.force()));
    if (!(sizes.back() < runaway * kick)) break;
  }
  // From the third quarter to the last.
  const std::size_t n = sizes.size(), quarter = std::max<std::size_t>(n / 4, 1);
  const double third = root_mean_square(sizes, n - 2 * quarter, n - quarter);
  const double last = root_mean_square(sizes, n - quarter, n);
  return {.growth = std::log(last / third) / static_cast<double>(quarter),
          .samples = static_cast<int>(n)};
}

MultisinePlan experiment_of(const RandomSetting& setting) {
  constexpr int lines = 25;
  const double rate = setting.design.gains.sample_rate_hz;
  MultisinePlan plan{.sample_rate_hz = rate,
                     .frequencies_hz = {},
                     .n_blocks = 6,
                     .ramp_s = 1,
                     .window_s = 4,
                     .amplitude = amplitude};
  for (int i = 0; i <= lines; ++i) {
    const double wanted = std::pow(0.4 * rate, static_cast<double>(i) / lines);
    const double last = plan.frequencies_hz.empty() ? 0 : plan.frequencies_hz.back();
    plan.frequencies_hz.push_back(std::max(std::floor(wanted), last + 1));
  }
  return plan;
}

report::FrequencyResponse measure(const RandomSetting& setting, const MultisinePlan& plan) {
  const Eigen::MatrixXd floor = floor::multisine_table(plan);
  Loop loop(setting, floor);
  Eigen::MatrixXd outputs(floor.cols(), 6);
  for (Eigen::Index k = 0; k < floor.cols(); ++k) {
    outputs.row(k) = loop.step().frame_acceleration.head(6);
  }
  return report::identify(plan, floor.transpose(), outputs, 0);
}

}  // namespace stillframe::test

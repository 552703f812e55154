#include "tests/plant_sim/loop_experiment.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
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
/// Of the integrator while T is measured. The scene's own, 1e-5 of the largest motion within a
/// sample, is that of 1 Hz here, beside which the motion at 0.4 of the rate is so small that it
/// would be off by up to 0.9 dB; the error falls with the tolerance, to 3e-5 dB at 1e-8.
constexpr double fine_tolerance = 1e-6;
/// Growth beyond which no decaying loop comes, whatever it does at first.
constexpr double runaway = 1e6;
/// kg: what turns accelerations into forces of the size of those of the legs.
constexpr double share_of_a_leg = 750.0 / 6;

/// Plant, commands on their way, and law.
class Loop {
 public:
  Loop(const RandomSetting& setting, const Scene& scene, Eigen::MatrixXd floor)
      : plant_(scene, table(std::move(floor))),
        queue_(setting.gains.n_legs(), setting.gains.delay_samples),
        law_(setting.law),
        force_(Eigen::VectorXd::Zero(setting.gains.n_legs())) {}

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
    const std::string reason = plant_.advance(queue_.before(), queue_.after(), queue_.fraction());
    if (!reason.empty()) throw std::runtime_error(reason);
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
  Loop loop(setting, setting.scene, amplitude * noise(6, 1, 7));  // still behind that sample
  std::vector<double> sizes;
  while (static_cast<int>(sizes.size()) < samples) {
    sizes.push_back(size_of(loop.step(), loop.force()));
    if (!(sizes.back() < runaway * share_of_a_leg * amplitude)) break;
  }
  // From the third quarter to the last.
  const std::size_t n = sizes.size(), quarter = std::max<std::size_t>(n / 4, 1);
  const double third = root_mean_square(sizes, n - 2 * quarter, n - quarter);
  const double last = root_mean_square(sizes, n - quarter, n);
  return {.growth = std::log(last / third) / static_cast<double>(quarter),
          .samples = static_cast<int>(n)};
}

MultisinePlan experiment_of(const RandomSetting& setting) {
  constexpr int steps = 25;
  const double rate = setting.gains.sample_rate_hz;
  // Some thousand to two thousand samples in a window, whatever the rate.
  const double raster = rate < 450 ? 1 : rate < 700 ? 2 : 4;
  MultisinePlan plan{.sample_rate_hz = rate,
                     .frequencies_hz = {},
                     .n_blocks = 6,
                     .ramp_s = 1 / raster,
                     .window_s = 4 / raster,
                     .amplitude = amplitude};
  const double highest = std::floor(0.4 * rate / raster);
  for (int i = 0; i <= steps; ++i) {
    const double line = raster * std::round(std::pow(highest, static_cast<double>(i) / steps));
    if (i == 0 || line > plan.frequencies_hz.back()) plan.frequencies_hz.push_back(line);
  }
  return plan;
}

report::FrequencyResponse measure(const RandomSetting& setting, const MultisinePlan& plan) {
  const Eigen::MatrixXd floor = floor::multisine_table(plan);
  Scene scene = setting.scene;
  scene.simulation.relative_tolerance = fine_tolerance;
  Loop loop(setting, scene, floor);
  Eigen::MatrixXd outputs(floor.cols(), 6);
  for (Eigen::Index k = 0; k < floor.cols(); ++k) {
    outputs.row(k) = loop.step().frame_acceleration.head(6);
  }
  return report::identify(plan, floor.transpose(), outputs, 0);
}

}  // namespace stillframe::test

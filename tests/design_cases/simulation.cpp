#include "tests/design_cases/simulation.hpp"

#include <cmath>
#include <stdexcept>

#include "controller/law.hpp"
#include "plant_sim/command_queue.hpp"
#include "plant_sim/floor/multisine.hpp"
#include "plant_sim/plant.hpp"
#include "report/identification/multisine.hpp"
#include "tests/plant_sim/frame.hpp"

namespace stillframe::test {

namespace {

/// m/s^2 in an experiment. Relative to the motion the nonlinearity is 1e-2 at 1 m/s^2 and in
/// proportion (test_prediction.cpp), here 1e-6; the rounding of a weight of 7 kN is 1e-15 m/s^2.
constexpr double amplitude = 1e-4;
/// kg: what turns accelerations into forces of the size of those of the legs.
constexpr double share_of_a_leg = 750.0 / 6;
/// N: beyond it a loop has run away; 1e5 times the kick or more. A leg of 4e6 N/m gives 25 um.
constexpr double runaway = 100;

/// Plant, commands on their way, and law.
class Loop {
 public:
  Loop(const Case& made, Eigen::MatrixXd floor)
      : plant_(made.scene, table(std::move(floor))),
        queue_(made.loop.n_legs, made.settings.sampling.delay_samples),
        law_(law_of(made.settings)),
        force_(Eigen::VectorXd::Zero(made.loop.n_legs)) {}

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

  /// Of all that the instruments see and the law does, N.
  double size() {
    const Reading& reading = plant_.read();
    const double inertia = share_of_a_leg * reading.frame_acceleration.head(6).norm();
    return std::hypot(reading.sigma.norm(), force_.norm(), inertia);
  }

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

double root_mean_square(const std::vector<double>& sizes, std::size_t begin, std::size_t end) {
  double sum = 0;
  for (std::size_t k = begin; k < end; ++k) sum += sizes[k] * sizes[k];
  return std::sqrt(sum / static_cast<double>(end - begin));
}

}  // namespace

Aftermath kick(const Case& made, double seconds) {
  // m/s^2. Small against the linear range, large against the rounding of the weight.
  const double kick = made.scene.gravity.isZero() ? 1e-9 : 1e-6;
  const double rate = made.scene.controller->sample_rate_hz;
  // The floor comes back to where it was: displaced, it would leave a frame with a weight tilted.
  const Eigen::RowVector3d and_back(1, -2, 1);
  Loop loop(made, kick * noise(6, 1, 7) * and_back);  // still behind these samples
  std::vector<double> sizes;
  while (static_cast<double>(sizes.size()) < seconds * rate) {
    loop.step();
    sizes.push_back(loop.size());
    if (!(sizes.back() < runaway)) break;
  }
  // From the third quarter to the last.
  const std::size_t n = sizes.size(), quarter = std::max<std::size_t>(n / 4, 1);
  const double third = root_mean_square(sizes, n - 2 * quarter, n - quarter);
  const double last = root_mean_square(sizes, n - quarter, n);
  return {.growth = std::log(last / third) / static_cast<double>(quarter) * rate,
          .seconds = static_cast<double>(n) / rate};
}

Eigen::MatrixXd measure(const Case& made, const std::vector<double>& frequencies_hz) {
  const MultisinePlan plan{.sample_rate_hz = made.scene.controller->sample_rate_hz,
                           .frequencies_hz = frequencies_hz,
                           .n_blocks = 6,
                           .ramp_s = 0.4,
                           .window_s = 0.4,
                           .amplitude = amplitude};
  Eigen::MatrixXd floor = floor::multisine_table(plan);
  // A plan begins at rest, where nothing but the rounding of a preload moves the frame; no error
  // can be small against that. The free motion that this sets off is over before the first window.
  floor.col(0) += amplitude * noise(floor.rows(), 1, 7);
  Loop loop(made, floor);
  Eigen::MatrixXd outputs(floor.cols(), 6);
  for (Eigen::Index k = 0; k < floor.cols(); ++k) {
    outputs.row(k) = loop.step().frame_acceleration.head(6);
  }
  return report::identify(plan, floor.transpose(), outputs, 0).singular_values;
}

}  // namespace stillframe::test

#include <algorithm>

#include "core/numerics/worst.hpp"
#include "tests/random_scenes/answers.hpp"
#include "tests/random_scenes/generator/draws.hpp"
#include "tests/random_scenes/loop_run.hpp"
#include "tests/random_scenes/relation.hpp"

namespace stillframe::random_scenes {

namespace {

/// Largest difference of two runs, relative to the largest of each kind of signal; none where
/// rounding may be all of it.
double difference(const Signals& a, const Signals& b, const RunRounding& rounding) {
  const auto relative = [](const Eigen::MatrixXd& p, const Eigen::MatrixXd& q, double noise) {
    const double largest = worst_of(p - q);
    return largest <= 10 * noise ? 0.0 : largest / worst_of(q);
  };
  return worst_of(relative(a.sigma, b.sigma, rounding.sigma),
                  relative(a.acceleration, b.acceleration, rounding.acceleration));
}

}  // namespace

std::optional<Finding> check_small_motion(Case& scene, std::uint64_t seed) {
  // Linear motion is motion about rest.
  if (!scene.has_loop() || scene.operating_point().moving()) return std::nullopt;
  const Scene ideal = without_nonlinear_instruments(scene.scene());
  const double T = 1 / ideal.controller->sample_rate_hz;
  constexpr Index n = 60;
  Draws draws(seed);
  Eigen::MatrixXd shape(static_cast<Index>(ideal.inputs.size()), n);
  for (double& value : shape.reshaped()) value = draws.between(-1, 1);
  constexpr double tolerance = 1e-9;
  const RunRounding rounding(scene);
  const auto nonlinearity = [&](double size) {
    const Eigen::MatrixXd floor = size / (T * T) * shape;
    Scene exact = ideal, linear = ideal;
    exact.simulation.method = PlantMethod::exponential;
    exact.simulation.relative_tolerance = tolerance;
    linear.simulation.method = PlantMethod::linear;
    return difference(run_loop(exact, scene.design(), floor, false),
                      run_loop(linear, scene.design(), floor, false), rounding);
  };
  // Steps of the floor of a hundred-thousandth of the shortest element, and sixteen times less.
  const double step = 1e-5 * shortest_element(ideal);
  const double large = nonlinearity(step), small = nonlinearity(step / 16);
  Finding finding;
  // What is left of the motion by the first power of its size: a sixteenth, and half as much again
  // for the third power of the motion; beside it the integrator's tolerance in each sample.
  finding.take(small, 1.5 / 16 * large + static_cast<double>(n) * tolerance,
               "nonlinear less linear motion");
  finding.take(large, 1,
               "nonlinear less linear motion at a hundred-thousandth of the shortest length");
  return finding;
}

}  // namespace stillframe::random_scenes

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/systems/sampled_loop.hpp"
#include "tests/random_scenes/generator/draws.hpp"
#include "tests/random_scenes/loop_run.hpp"
#include "tests/random_scenes/relation.hpp"

namespace stillframe::random_scenes {

namespace {

/// A knock of all inputs, each its own, after which the floor is where it was: two differences of a
/// blow have neither velocity nor position left.
Eigen::MatrixXd knock(Draws& draws, Index n_inputs, Index n_samples) {
  Eigen::MatrixXd floor = Eigen::MatrixXd::Zero(n_inputs, n_samples);
  for (Index i = 0; i < n_inputs; ++i) {
    const double blow = draws.between(0.5, 1);
    floor.row(i).head(3) << blow, -2 * blow, blow;
  }
  return floor;
}

/// Logarithm of the size, a quarter of the run.
double level(const Eigen::MatrixXd& signals, Index quarter) {
  const Index n = signals.rows() / 4;
  return std::log(signals.middleRows(quarter * n, n).norm());
}

/// The eigenvalue of largest modulus: its angle, rad a sample, 0 to pi, and how much faster the
/// next one, but for its conjugate, decays in a sample (logarithm).
struct Slowest {
  double angle = 0, lead = std::numeric_limits<double>::infinity();

  explicit Slowest(const Eigen::MatrixXd& A) {
    const Eigen::VectorXcd values = A.eigenvalues();
    Index largest = 0;
    const double radius = values.cwiseAbs().maxCoeff(&largest);
    angle = std::abs(std::arg(values(largest)));
    for (Index i = 0; i < values.size(); ++i) {
      if (i == largest || values(i) == std::conj(values(largest))) continue;
      lead = std::min(lead, std::log(radius / std::abs(values(i))));
    }
  }
};

}  // namespace

std::optional<Finding> check_stability(Case& scene, std::uint64_t seed) {
  // Linear motion is motion about rest.
  if (!scene.has_loop() || scene.operating_point().moving()) return std::nullopt;
  const double rate = std::log(scene.design().radius);
  // What grows has to leave all else behind, whatever small part of the knock it had; what decays
  // has to do so visibly before rounding is all there is.
  const double change = rate > 0 ? 30 : 20, longest = 100'000;
  if (!(std::abs(rate) * longest >= change)) return std::nullopt;
  // Not so long that squares overflow.
  const double shortest = rate > 0 ? std::clamp(300 / rate, 12.0, 100.0) : 100;
  const auto n = static_cast<Index>(std::max(shortest, std::min(longest, change / std::abs(rate))));
  Draws draws(seed);
  Scene linear = without_nonlinear_instruments(scene.scene());
  linear.simulation.method = PlantMethod::linear;
  const auto n_inputs = static_cast<Index>(linear.inputs.size());
  const Signals run = run_loop(linear, scene.design(), knock(draws, n_inputs, n), true);
  // From the third quarter to the last; what has grown by exp(200), or come down to the rounding of
  // the floor, has said what it is.
  const double grows = level(run.sigma, 3) - level(run.sigma, 2);
  const double expected = rate * static_cast<double>(n / 4);
  Finding finding;
  // A quarter's size is that of the samples in which the slowest motion changes by a factor e. If
  // that is less than half a turn of it, they may lie where it passes zero: then it is asked
  // whether the run grows or decays at all. So it is if the next motion, whose part of the knock
  // may be a million times as large, is not left behind by then: the two beat.
  const Slowest slowest(scene.design().closed.A);
  const double turned = slowest.angle / std::abs(rate);
  const bool behind = slowest.lead * static_cast<double>(n / 2) > std::log(1e6);
  const bool by_rate = behind && (turned == 0 || turned >= std::numbers::pi);
  const std::string what = "radius " + std::to_string(scene.design().radius) +
                           ", sigma changes by exp(" + std::to_string(grows) +
                           ") in a quarter of the run, for exp(" + std::to_string(expected) + ")";
  // The slowest motion goes as the radius says, but for how its beats and the powers of a multiple
  // pole lie in the two quarters: 7/5 for a double one, its square for a triple one, and
  // a factor e in all. Where it grows so fast that the last sample is most of a quarter, that
  // sample may be one at which a beat passes zero, and the one before stands for it. What decays
  // faster may have had nothing of the slowest; what grows has it all.
  if (!by_rate) {
    finding.take(std::exp(rate > 0 ? -grows : grows), 1, what);
    return finding;
  }
  const double beats = 1 + std::max(rate, 0.0);
  finding.take(grows - expected, beats, what);
  if (rate > 0) finding.take(expected - grows, beats, what);
  return finding;
}

}  // namespace stillframe::random_scenes

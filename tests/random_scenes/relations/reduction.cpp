#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "core/mechanics/frequency_response.hpp"
#include "core/mechanics/partition/free_model.hpp"
#include "core/mechanics/sparse/reduced_model.hpp"
#include "core/mechanics/sparse/sparse_equilibrium.hpp"
#include "core/mechanics/sparse/sparse_response.hpp"
#include "core/numerics/singular_values.hpp"
#include "tests/random_scenes/answers.hpp"

// Reduced models against the whole one at frequencies of their band, and their bound.
namespace stillframe::random_scenes {

namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;

double largest(const MatrixXcd& G) { return singular_values(G)(0); }

/// How many of the lowest modes, of those that are to be had.
SceneReduction some_modes(Index n_d, std::mt19937_64& random) {
  SceneReduction asked;
  asked.n_modes = 1 + static_cast<Index>(random() % static_cast<std::uint64_t>(n_d));
  return asked;
}

/// What springs carry at most where an input moves one end of them and an output is what they
/// exert: nearly the same forces cancel in a response. N/m or N m/rad times the motion.
double carried_by_springs(const Scene& scene, const MixedModel& mixed, Complex s) {
  const bool exerted =
      std::any_of(scene.outputs.begin(), scene.outputs.end(), [](const SceneSignal& output) {
        return output.quantity == Quantity::stress || output.quantity == Quantity::reaction ||
               output.quantity == Quantity::reaction_moment;
      });
  if (!exerted) return 0;
  double stiffest = 0, position = 0;
  for (const double compliance : mixed.compliance()) {
    if (compliance > 0) stiffest = std::max(stiffest, 1 / compliance);
  }
  for (const SceneSignal& input : scene.inputs) {
    if (is_motion(input.quantity)) {
      position = std::max(position, std::abs(position_of(input.quantity, s)));
    }
  }
  return stiffest * position;
}

}  // namespace

std::optional<Finding> check_reduction(Case& scene, std::uint64_t seed) {
  if (!scene.at_rest() || scene.scene().operating_point != OperatingPoint::equilibrium ||
      scene.scene().inputs.empty() || scene.scene().outputs.empty()) {
    return std::nullopt;
  }
  const Model model = free_model(scene.scene());
  if (!model.turning_loads.empty()) return std::nullopt;
  const MixedModel mixed(model);
  const MixedState state = sparse_equilibrium(mixed).state;
  const Answers& own = own_answers(scene);
  // What nothing resists may be anywhere under loads.
  const double eps = 10 * static_cast<double>(model.n_c) * std::numeric_limits<double>::epsilon();
  if (own.squares.size() == 0) return std::nullopt;
  const bool free = own.squares(0) <= eps * own.squares_rounding(0);
  const bool loaded = !model.load.isZero(0) || !model.gravity.isZero(0) || !model.preload.isZero(0);
  if (free && loaded) return std::nullopt;
  const auto& inputs = scene.scene().inputs;
  const auto& outputs = scene.scene().outputs;
  SparseResponse whole(mixed, state, mixed_signals(mixed, state, inputs, outputs));
  Finding finding;
  std::mt19937_64 random(seed);
  const ReducedModel reduced =
      reduced_model(mixed, state, inputs, outputs, some_modes(own.squares.size(), random));
  // Both ways of computing a natural frequency agree on it to so much, which `sparse` has a bound
  // on.
  const Eigen::VectorXd kept = reduced.linear.stiffness().diagonal().head(reduced.n_modes);
  double detuned = 0;
  for (Index i = 0; i < reduced.n_modes; ++i) {
    if (own.squares(i) > eps * own.squares_rounding(i)) {
      detuned = std::max(detuned, std::abs(kept(i) / own.squares(i) - 1) / 2);
    }
  }
  std::uniform_real_distribution<double> exponent(-2, 0);
  for (int i = 0; i < 5; ++i) {
    const double hz = reduced.to_hz * std::pow(10, exponent(random));
    const double omega = 2 * std::numbers::pi * hz, h = 1e-6;
    const MatrixXcd G = whole({0, omega});
    const double difference = largest(G - transfer_function(reduced.linear, {0, omega})),
                 bound = reduced.bound(omega), size = largest(G);
    // Near a resonance as much as its frequency is known to.
    const double steep = largest(whole({0, omega * (1 + h)}) - G) / h;
    // The whole response is known as well as another way of computing it agrees.
    const double known = largest(G - transfer_function(scene.linear(), {0, omega})),
                 rounding = eps * (size + carried_by_springs(scene.scene(), mixed, {0, omega})) +
                            (eps + detuned) * steep + 20 * own.misplaced * size + 2 * known;
    // What is exact to rounding says nothing of the bound.
    if (difference > rounding) {
      finding.take(difference, bound + rounding, "bound of a reduced model");
    }
    // Of one input to one output, as of the floor to the frame where the legs are there as well.
    ReducedModel part = reduced;
    part.n_in = part.n_out = 1;
    const double of_one =
        largest((G - transfer_function(reduced.linear, {0, omega})).topLeftCorner(1, 1));
    if (of_one > rounding) {
      finding.take(of_one, part.bound(omega) + rounding, "bound of a part of a reduced model");
    }
  }
  if (finding.compared == 0) return std::nullopt;
  return finding;
}

}  // namespace stillframe::random_scenes

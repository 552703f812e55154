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
  if (own.squares.size() == 0 || own.squares(0) <= eps * own.squares_rounding(0)) {
    return std::nullopt;
  }
  const auto& inputs = scene.scene().inputs;
  const auto& outputs = scene.scene().outputs;
  const SparseResponse whole(mixed, state, mixed_signals(mixed, state, inputs, outputs));
  Finding finding;
  // At damped places, where the dense response says what rounding may do to it.
  const auto at = places(scene);
  for (size_t i = 0; i < at.size(); ++i) {
    const Response& dense = own.responses[i];
    const MatrixXcd G = whole(at[i]);
    for (Index k = 0; k < G.size(); ++k) {
      finding.take(std::abs(G(k) - dense.G(k)),
                   eps * dense.rounding(k) + 20 * own.misplaced * std::abs(dense.G(k)),
                   "sparse response", std::abs(dense.G(k)));
    }
  }
  std::mt19937_64 random(seed);
  const ReducedModel reduced = reduced_model(mixed, state, inputs, outputs,
                                             some_modes(own.squares.size(), random));
  std::uniform_real_distribution<double> exponent(-2, 0);
  for (int i = 0; i < 5; ++i) {
    const double hz = reduced.to_hz * std::pow(10, exponent(random));
    const double omega = 2 * std::numbers::pi * hz, h = 1e-6;
    const MatrixXcd G = whole({0, omega});
    const double difference = largest(G - transfer_function(reduced.linear, {0, omega})),
                 bound = reduced.bound(omega), size = largest(G);
    // Near a resonance as much as its frequency is known to, twice a hundred roundings.
    const double steep = largest(whole({0, omega * (1 + h)}) - G) / h;
    finding.take(difference, bound + eps * (10 * size + steep), "bound of a reduced model");
  }
  return finding;
}

}  // namespace stillframe::random_scenes

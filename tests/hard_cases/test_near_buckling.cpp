#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "core/errors/input_error.hpp"
#include "core/mechanics/buckling.hpp"
#include "core/mechanics/equilibrium.hpp"
#include "core/mechanics/modes.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "tests/hard_cases/reached.hpp"

namespace stillframe::test {
namespace {

std::string pinned_beam(double load) {
  char text[64];
  std::snprintf(text, sizeof text, "%.17g", load);
  return std::string(R"(title: Pinned beam under an axial load
planar: true
nodes:
  left: {position: [0, 0]}
  right: {position: [1, 0]}
masses: []
elements:
  beam: {type: beam, nodes: [left, right], EA: 1e9, EI: 1, mass_per_length: 1, divide: 8,
    second_order: true}
supports:
  - {nodes: [left], fix: [x, y]}
  - {nodes: [right], fix: [y]}
dofs: auto
loads:
  - {node: right, force: [-)") +
         text + ", 0]}\n";
}

// At 99 % of the buckling load of the same mesh the stiffness that is left is 1 %: the first
// frequency falls to sqrt(1 - 0.99) = 0.1 of the unloaded one, and errors of the geometric
// stiffness count a hundred times. The shape of the mode of the mesh is nearly, not exactly, that
// of the buckling: both are half sines to the 1e-5 of eight cubic elements, which enters squared
// and enlarged by 100.
TEST(NearBuckling, TheFrequencyFallsAsTheRootOfTheLoadThatIsLeft) {
  const Buckling critical = buckling(make_model(parse_scene(pinned_beam(1), "critical")));
  const double P = critical.load_multipliers(0);
  const auto first = [](double load) {
    const Model model = make_model(parse_scene(pinned_beam(load), "loaded"));
    const Equilibrium at = solve_equilibrium(model);
    EXPECT_LE(at.residual, 1e-9 * at.reference);
    const LinearModel linear = linearise(model, at.motion, {}, {});
    return std::pair(modes(linear).natural_frequencies_hz(0), condition_number(linear.stiffness()));
  };
  const auto [unloaded, condition_unloaded] = first(0);
  for (const double share : {0.5, 0.9, 0.99}) {
    const auto [loaded, condition] = first(share * P);
    const double error = std::abs(loaded / unloaded / std::sqrt(1 - share) - 1);
    char what[64];
    std::snprintf(what, sizeof what, "first frequency at %.0f %% of the buckling load",
                  100 * share);
    reached(what, error, condition);
    // 2e-8: shortening of the beam by P / EA = 1e-8 changes its length and hence P_cr, twice that
    // in the frequency's square, enlarged by 1 / (1 - share); 1e-6 for the mode shapes.
    EXPECT_LE(error, (2e-8 + 1e-6) / (1 - share)) << share;
  }
  EXPECT_LT(condition_unloaded, 1e14);
}

TEST(NearBuckling, BeyondItTheStraightBeamIsCalledUnstable) {
  const Model model = make_model(parse_scene(pinned_beam(1.001 * M_PI * M_PI), "beyond"));
  EXPECT_THROW(modes(linearise(model, solve_equilibrium(model).motion, {}, {})), Refusal);
}

}  // namespace
}  // namespace stillframe::test

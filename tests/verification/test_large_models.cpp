#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/errors/input_error.hpp"
#include "core/mechanics/buckling.hpp"
#include "core/mechanics/equilibrium.hpp"
#include "core/mechanics/frequency_response.hpp"
#include "core/mechanics/modes.hpp"
#include "core/mechanics/node_displacements.hpp"
#include "core/mechanics/partition/free_model.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "core/mechanics/sparse/damped_modes.hpp"
#include "core/mechanics/sparse/sparse_buckling.hpp"
#include "core/mechanics/sparse/sparse_equilibrium.hpp"
#include "core/mechanics/sparse/sparse_scene.hpp"
#include "core/mechanics/unstable.hpp"
#include "core/numerics/worst.hpp"
#include "tests/verification/closed_forms.hpp"
#include "tests/verification/scene_text.hpp"

// Models that are large for dense matrices: the sparse way against closed forms where there is no
// other, and against the dense way where both run. Random scenes: the relation `sparse`.
namespace stillframe::verification {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double two_pi = 2 * std::numbers::pi, mu = 0.78, EI_y = 174.3, EI_z = 252;

struct Chain {
  int n = 10;
  double EI_z = verification::EI_z;
  std::string supports = "supports:\n  - {nodes: [a], fix: [x, y, z, rotation]}\n";
  std::string keys = "", rest = "";  ///< of the beam; of the scene

  std::string text() const {
    return "title: chain\nnodes:\n  a: {position: [0, 0, 0]}\n  b: {position: [1, 0, 0]}\n"
           "masses: []\nelements:\n  beam: {type: beam, nodes: [a, b], EA: 2.1e7, GJ: 112, "
           "EI_y: 174.3, EI_z: " +
           number(EI_z) +
           ", orientation: [0, 1, 0], mass_per_length: 0.78, inertia_per_length: 1.5834e-5, "
           "divide: " +
           std::to_string(n) + keys + "}\ndofs: auto\n" + supports + rest;
  }
  /// Hz, of an a^2 = omega sqrt(mu L^4 / EI).
  static double hz(double a, double EI) { return a * a * std::sqrt(EI / mu) / two_pi; }
};

struct Large {
  Model model;
  MixedModel mixed;
  explicit Large(const std::string& text)
      : model(free_model(parse_scene(text, "s"))), mixed(model) {}
  Modes modes(Index n) const { return sparse_modes(mixed, sparse_equilibrium(mixed).state, n); }
};

VectorXd lowest_hz(const std::string& text, Index n) {
  return Large(text).modes(n).natural_frequencies_hz;
}

/// What a cubic between the nodes leaves out is (a h)^4 / 1440 of a frequency: 3e-13 of the second
/// ones of a thousand beams. A stiffness matrix of a thousand beams has its lowest modes to
/// eps n^4 = 2e-4, its elements' deformations to eps n^2 = 2e-10 of the worst shape.
TEST(LargeModels, AThousandBeamsHaveTheFrequenciesOfTheContinuousOne) {
  const VectorXd f = lowest_hz(Chain{.n = 1000}.text(), 20);
  ASSERT_EQ(f.size(), 20);
  for (int k = 1; k <= 2; ++k) {
    const double a = beam_root(k, -1);
    EXPECT_NEAR(f(2 * k - 2) / Chain::hz(a, EI_y), 1, 1e-11) << k;
    EXPECT_NEAR(f(2 * k - 1) / Chain::hz(a, EI_z), 1, 1e-11) << k;
  }
}

TEST(LargeModels, WhatIsFreeHasSixFrequenciesOfZeroAndThenThoseOfTheContinuousOne) {
  for (const int n : {60, 600}) {
    const VectorXd f = lowest_hz(Chain{.n = n, .supports = ""}.text(), 12);
    ASSERT_EQ(f.size(), 12);
    EXPECT_EQ(f.head(6).norm(), 0) << n;
    const double a = beam_root(1, 1), cubic = std::pow(a / n, 4) / 1440;
    EXPECT_NEAR(f(6) / Chain::hz(a, EI_y) - 1, cubic, 0.01 * cubic + 1e-10) << n;
    EXPECT_NEAR(f(7) / Chain::hz(a, EI_z) - 1, cubic, 0.01 * cubic + 1e-10) << n;
  }
}

/// A Krylov space of one start has one vector of each multiple frequency.
TEST(LargeModels, FrequenciesThatRepeatAreAllFound) {
  const VectorXd f = lowest_hz(Chain{.n = 200, .EI_z = EI_y}.text(), 9);
  for (int k = 1; k <= 4; ++k) {
    EXPECT_NEAR(f(2 * k - 1) / f(2 * k - 2), 1, 1e-10) << k;
    EXPECT_NEAR(f(2 * k - 1) / Chain::hz(beam_root(k, -1), EI_y), 1, 1e-7) << k;
  }
}

/// Twelve cantilevers that have nothing to do with each other, each a little stiffer than the one
/// before and as stiff both ways: close pairs, of which rounding alone does not find both.
TEST(LargeModels, ClosePairsAreAllFound) {
  const auto EI = [](int i) { return EI_y * (1 + 0.002 * i); };
  std::string nodes, elements, clamped;
  for (int i = 0; i < 12; ++i) {
    const std::string k = std::to_string(i), stiffness = number(EI(i));
    nodes += "  a" + k + ": {position: [0, " + k + ", 0]}\n  b" + k + ": {position: [1, " + k +
             ", 0]}\n";
    elements += "  beam" + k + ": {type: beam, nodes: [a" + k + ", b" + k +
                "], EA: 2.1e7, GJ: 112, EI_y: " + stiffness + ", EI_z: " + stiffness +
                ", orientation: [0, 1, 0], mass_per_length: 0.78, inertia_per_length: 1.5834e-5, "
                "divide: 8}\n";
    clamped += (i > 0 ? ", a" : "a") + k;
  }
  const std::string text = "title: twelve\nnodes:\n" + nodes + "masses: []\nelements:\n" +
                           elements + "dofs: auto\nsupports:\n  - {nodes: [" + clamped +
                           "], fix: [x, y, z, rotation]}\n";
  for (const Index n : {2, 5, 10, 24}) {
    const VectorXd f = lowest_hz(text, n);
    ASSERT_EQ(f.size(), n);
    for (Index i = 0; i < n; ++i) {
      // The cubic leaves out (1.9 / 8)^4 / 1440 = 2e-6 of each, a hundredth of their distance.
      EXPECT_NEAR(f(i) / Chain::hz(beam_root(1, -1), EI(static_cast<int>(i / 2))), 1, 3e-6)
          << i << " of " << n;
    }
  }
}

/// Dense matrices of thirty beams know their lowest squares to eps n^4 = 2e-10 of them, those of
/// ten to 2e-12.
void expect_dense(const std::string& text, Index n, double tolerance) {
  const Modes dense = modes(linear_model(text)), sparse = Large(text).modes(n);
  ASSERT_EQ(sparse.natural_frequencies_hz.size(), n);
  for (Index i = 0; i < n; ++i) {
    const double f = dense.natural_frequencies_hz(i);
    EXPECT_NEAR(sparse.natural_frequencies_hz(i), f, tolerance * f) << i;
    const std::complex<double> p = sparse.eigenvalues(2 * i);
    Index nearest = 0;
    const double off = (dense.eigenvalues.array() - p).abs().minCoeff(&nearest);
    EXPECT_LE(off, 10 * tolerance * std::abs(p) + dense.known_to(nearest)) << p;
  }
}

TEST(LargeModels, DampedAsTheirStiffnessIs) {
  expect_dense(Chain{.n = 30, .keys = ", damping_time: 1e-4"}.text(), 12, 1e-9);
  const Modes found = Large(Chain{.n = 300, .keys = ", damping_time: 1e-4"}.text()).modes(6);
  for (Index i = 0; i < 6; ++i) {
    const double omega = two_pi * found.natural_frequencies_hz(i);
    EXPECT_NEAR(found.damping_ratios(i), 0.5e-4 * omega, 1e-12 * omega) << i;
  }
}

TEST(LargeModels, DampedAtOneEndOnly) {
  const std::string dashpots =
      "  x: {type: truss, nodes: [b, wall], stiffness: 0, damping: 40}\n"
      "  stiff: {type: truss, nodes: [b, side], stiffness: 1e4, damping: 3}\n";
  std::string text = with(Chain{.n = 10}.text(), "dofs: auto", dashpots + "dofs: auto");
  text = with(text, "masses: []",
              "  wall: {position: [1, 1, 0]}\n  side: {position: [1.2, 0.3, 1]}\nmasses: []");
  text = with(text, "supports:\n", "supports:\n  - {nodes: [wall, side], fix: [x, y, z]}\n");
  expect_dense(text, 12, 1e-10);
}

TEST(LargeModels, LoadedAndHeavy) {
  const std::string load = "loads:\n  - {node: b, force: [-300, 0, -20]}\ngravity: [0, 0, -9.81]\n";
  const std::string text = Chain{.n = 10, .keys = ", second_order: true", .rest = load}.text();
  expect_dense(text, 12, 1e-9);
  const Scene scene = parse_scene(text, "s");
  const Model model = make_model(scene);
  const Equilibrium dense = solve_equilibrium(model);
  const Large large(text);
  const SparseEquilibrium sparse = sparse_equilibrium(large.mixed);
  // Newton's method ends at rounding: of displacements, 1e-9 of the largest and less.
  const auto dense_nodes = node_displacements(model, dense.motion.x);
  const auto sparse_nodes = node_displacements(large.model, sparse.state.x);
  ASSERT_EQ(dense_nodes.size(), sparse_nodes.size());
  for (size_t i = 0; i < dense_nodes.size(); ++i) {
    const Eigen::Vector3d move = dense_nodes[i].displacement;
    EXPECT_LE((sparse_nodes[i].displacement - move).norm(), 1e-9 * move.norm());
  }
  EXPECT_LE(sparse.residual, 1e-9 * sparse.reference);
}

/// Half as much again as the column bears.
TEST(LargeModels, WhatIsNotStableIsRefused) {
  const double euler = std::numbers::pi * std::numbers::pi * EI_y / 4;
  const auto loaded = [&](double part) {
    return Chain{.n = 100,
                 .rest = "loads:\n  - {node: b, force: [" + number(-part * euler) + ", 0, 0]}\n"}
        .text();
  };
  EXPECT_THROW(Large(loaded(1.5)).modes(4), Unstable);
  EXPECT_THROW(Large(loaded(1.0001)).modes(4), Unstable);
  const double f = lowest_hz(loaded(0.999), 4)(0), alone = lowest_hz(Chain{.n = 100}.text(), 4)(0);
  // Near the critical load the square falls as the distance to it.
  EXPECT_NEAR(f / alone, std::sqrt(0.001), 0.1 * std::sqrt(0.001));
}

/// Six masses on springs swing more slowly than the column falls: what is asked for is stable.
TEST(LargeModels, WhatIsNotStableIsRefusedWhicheverModesAreAskedFor) {
  std::string masses, nodes, elements, held;
  for (int i = 0; i < 6; ++i) {
    const std::string k = std::to_string(i);
    nodes += "  m" + k + ": {position: [3, " + k + ", 0]}\n  w" + k + ": {position: [4, " + k +
             ", 0]}\n";
    masses += (i > 0 ? ", " : "") + ("{node: m" + k + ", mass: 1}");
    elements += "  spring" + k + ": {type: truss, nodes: [m" + k + ", w" + k +
                "], stiffness: " + std::to_string(i + 1) + "}\n";
    held += "  - {nodes: [w" + k + "], fix: [x, y, z]}\n  - {nodes: [m" + k + "], fix: [y, z]}\n";
  }
  const double euler = std::numbers::pi * std::numbers::pi * EI_y / 4;
  const auto loaded = [&](double part) {
    std::string text =
        Chain{.n = 60,
              .rest = "loads:\n  - {node: b, force: [" + number(-part * euler) + ", 0, 0]}\n"}
            .text();
    text = with(text, "masses: []", nodes + "masses: [" + masses + "]");
    text = with(text, "dofs: auto\nsupports:\n", elements + "dofs: auto\nsupports:\n" + held);
    return text;
  };
  EXPECT_NEAR(lowest_hz(loaded(0.5), 4)(0), 1 / two_pi, 1e-10);
  EXPECT_THROW(Large(loaded(3)).modes(4), Unstable);
}

TEST(LargeModels, ColumnsBuckleAtEulersLoads) {
  const int n = 1000;
  const Large large(Chain{.n = n, .rest = "loads:\n  - {node: b, force: [-1, 0, 0]}\n"}.text());
  const VectorXd found = sparse_buckling(large.mixed, 4).load_multipliers;
  ASSERT_EQ(found.size(), 4);
  // Of first order: (k h)^2 / 12 (V6).
  const double pi = std::numbers::pi, EI[] = {EI_y, EI_z, EI_y, EI_z};
  for (Index i = 0; i < 4; ++i) {
    const double k = (i < 2 ? 0.5 : 1.5) * pi, chord = k * k / (12.0 * n * n);
    EXPECT_NEAR(found(i) / (k * k * EI[i]) - 1, chord, 0.01 * chord + 1e-9) << i;
  }
}

TEST(LargeModels, BucklingAsTheDenseWayHasIt) {
  const std::string text =
      Chain{.n = 12,
            .keys = ", preload: [-200, 0, 0, 0, 0, 0], second_order: true",
            .rest = "loads:\n  - {node: b, force: [-3, 1, 40]}\ngravity: [0, 2, -9.81]\n"}
          .text();
  const Buckling dense = buckling(make_model(parse_scene(text, "s")));
  const Large large(text);
  const VectorXd sparse = sparse_buckling(large.mixed, 6).load_multipliers;
  ASSERT_EQ(sparse.size(), 6);
  for (Index i = 0; i < 6; ++i) {
    EXPECT_NEAR(sparse(i) / dense.load_multipliers(i), 1, 1e-9) << i;
  }
}

/// Two parallel rigid beams where one does, and a node that hangs on nothing.
TEST(LargeModels, WhatHasNoAnswerIsRefused) {
  std::string twice = with(Chain{.n = 20}.text(), "dofs: auto",
                           "  one: {type: rigid_beam, nodes: [b, c]}\n"
                           "  two: {type: rigid_beam, nodes: [b, c]}\ndofs: auto");
  twice = with(twice, "masses: []", "  c: {position: [1, 0.2, 0]}\nmasses: []");
  EXPECT_THROW(Large(twice).modes(4), Refusal);
  std::string loose = with(Chain{.n = 20}.text(), "dofs: auto",
                           "  rod: {type: truss, nodes: [b, c], stiffness: 100}\ndofs: auto");
  loose = with(loose, "masses: []", "  c: {position: [1, 0.2, 0]}\nmasses: []");
  EXPECT_THROW(Large(loose).modes(4), Refusal);
  EXPECT_THROW(sparse_buckling(Large(Chain{.n = 20}.text()).mixed, 2), Refusal);
  EXPECT_THROW(
      sparse_buckling(
          Large(Chain{.n = 20, .supports = "", .rest = "loads:\n  - {node: b, force: [1, 0, 0]}\n"}
                    .text())
              .mixed,
          2),
      Refusal);
}

constexpr const char* tip_signals =
    "inputs:\n  - {name: push, force: b, along: y}\noutputs:\n  - {name: tip, position: b, along: "
    "y}\n"
    "  - {name: moment, reaction_moment: a, along: z}\n";

/// Cantilever: L^3 / 3 EI of the force at its end and a moment L, on any number of modes.
TEST(ReducedModels, AreExactAtRest) {
  for (const int modes : {1, 4, 12}) {
    const Scene scene = parse_scene(
        Chain{.n = 30,
              .rest = tip_signals + std::string("reduce: {modes: ") + std::to_string(modes) + "}\n"}
            .text(),
        "s");
    const ReducedModel reduced = reduced_model(scene, scene.inputs, scene.outputs);
    EXPECT_EQ(reduced.n_modes, modes);
    const Eigen::MatrixXcd G = transfer_function(reduced.linear, 0);
    // Bending does not mix with the rest: rounding of a solution and of the modes beside it.
    EXPECT_NEAR(G(0, 0).real() * 3 * EI_z, 1, 1e-10);
    EXPECT_NEAR(std::abs(G(1, 0).real()), 1, 1e-10);
  }
}

/// The closed form of a cantilever driven at its end, by Bernoulli: no model of ours.
TEST(ReducedModels, AreWithinTheirBoundOfTheContinuousBeam) {
  const Scene scene = parse_scene(
      Chain{.n = 60, .rest = tip_signals + std::string("reduce: {modes: 6}\n")}.text(), "s");
  const ReducedModel reduced = reduced_model(scene, scene.inputs, scene.outputs);
  for (const double share : {0.02, 0.1, 0.3, 0.6, 1.0}) {
    const double omega = share * two_pi * reduced.to_hz,
                 b = std::sqrt(omega * std::sqrt(mu / EI_z)),
                 exact = (std::sin(b) * std::cosh(b) - std::cos(b) * std::sinh(b)) /
                         (EI_z * b * b * b * (1 + std::cos(b) * std::cosh(b)));
    const double difference = std::abs(transfer_function(reduced.linear, {0, omega})(0, 0) - exact);
    // Sixty elements of third order are off by (b / 60)^4 / 720 a mode, less than 1e-8 here, and
    // the rotary inertia of the sections by b^2 r^2 / 2.
    const double of_the_elements = (1e-8 + b * b * 1.5834e-5 / mu) * std::abs(exact) * 10;
    EXPECT_LE(difference, reduced.bound(omega) + of_the_elements) << share;
  }
}

TEST(ReducedModels, KeepWhatTheyAreAskedFor) {
  const auto reduced = [](const std::string& reduce) {
    const Scene scene =
        parse_scene(Chain{.n = 30, .rest = tip_signals + ("reduce: " + reduce + "\n")}.text(), "s");
    return reduced_model(scene, scene.inputs, scene.outputs);
  };
  const VectorXd hz = lowest_hz(Chain{.n = 30}.text(), 12);
  const ReducedModel three = reduced("{modes: 3}");
  EXPECT_NEAR(three.first_left_out_hz / hz(3), 1, 1e-10);
  EXPECT_DOUBLE_EQ(three.to_hz, three.first_left_out_hz / 2);
  EXPECT_TRUE(std::isinf(three.bound(two_pi * 1.001 * three.first_left_out_hz)));
  EXPECT_EQ(reduced("{modes_to_hz: " + number((hz(6) + hz(7)) / 2) + "}").n_modes, 7);
  // Twice the band.
  EXPECT_EQ(reduced("{to_hz: " + number((hz(4) + hz(5)) / 4) + "}").n_modes, 5);
}

TEST(ReducedModels, OfWhatDoesNotRestAreRefusedAtTheKey) {
  const auto refusal = [](const std::string& rest) {
    const Scene scene = parse_scene(
        Chain{.n = 30, .rest = tip_signals + std::string("reduce: {modes: 3}\n") + rest}.text(),
        "s");
    try {
      reduced_model(scene, scene.inputs, scene.outputs);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(refusal("operating_point: as_written\n").find("reduced model stands about"),
            std::string::npos);
  EXPECT_NE(refusal("loads:\n  - {node: b, force: [0, 0.1, 0], follows: true}\n")
                .find("turns with its node"),
            std::string::npos);
  EXPECT_EQ(refusal(""), "");
}

}  // namespace
}  // namespace stillframe::verification

#include <cmath>
#include <complex>
#include <fstream>

#include "tests/tools/verb.hpp"

namespace stillframe::test {
namespace {

using Json = nlohmann::json;
using Complex = std::complex<double>;

class ModesVerb : public Verb {
 protected:
  /// The turning table (V10) at another rate, its springs damped; masses and springs are 1.
  std::filesystem::path table(const std::string& rate, const std::string& damping) const {
    std::ifstream stream(config("scenes/turning_table.yaml"));
    std::string text(std::istreambuf_iterator<char>(stream), {});
    text.replace(text.find("rate: 0.1"), 9, "rate: " + rate);
    for (size_t at = 0; (at = text.find("stiffness: 1}", at)) != std::string::npos; at += 13) {
      text.insert(at + 12, ", damping: " + damping);
    }
    return write("table.yaml", text);
  }

  static std::vector<Complex> eigenvalues(const Json& document) {
    std::vector<Complex> values;
    for (const Json& pair : document["eigenvalues"]) values.emplace_back(pair[0], pair[1]);
    return values;
  }

  /// Of z'' + (d + 2 j W) z' + (1 - W^2) z = 0 and its conjugate, z = x + j y in the table.
  static void expect_table(const Json& document, double W, double d) {
    const std::vector<Complex> found = eigenvalues(document);
    ASSERT_EQ(found.size(), 4u);
    const Complex half(d / 2, W), root = std::sqrt(half * half - (1 - W * W));
    for (const Complex& one : {-half + root, -half - root}) {
      for (const Complex& expected : {one, std::conj(one)}) {
        double least = INFINITY;
        for (const Complex& value : found) least = std::min(least, std::abs(value - expected));
        EXPECT_LE(least, 1e-13) << expected;  // rounding of simple eigenvalues of about 1
      }
    }
  }
};

TEST_F(ModesVerb, TurningTable) {
  const Json document = json({"modes", table("0.1", "0")});
  EXPECT_EQ(document["moving"], true);
  EXPECT_EQ(document["n_growing_eigenvalues"], 0);
  expect_table(document, 0.1, 0);
  // det(-w^2 M + K + N) = 0: w^2 = 1 - W^2.
  ASSERT_EQ(document["natural_frequencies_hz"].size(), 2u);
  EXPECT_NEAR(document["natural_frequencies_hz"][0].get<double>(), std::sqrt(0.99) / (2 * M_PI),
              1e-14);
  expect_documented_keys("modes", document);
}

TEST_F(ModesVerb, LowestOfASmallSceneAreTheFirstOfAll) {
  const auto scene = config("scenes/metrology_frame.yaml");
  const Json all = json({"modes", scene}), lowest = json({"modes", scene, "--lowest", "2"});
  ASSERT_EQ(lowest["natural_frequencies_hz"].size(), 2u);
  EXPECT_EQ(lowest["natural_frequencies_hz"][1], all["natural_frequencies_hz"][1]);
  EXPECT_EQ(lowest["eigenvalues"].size(), 4u);
  EXPECT_EQ(lowest["damping_ratios"].size(), 2u);
  ASSERT_EQ(lowest["mode_shapes"].size(), all["mode_shapes"].size());
  EXPECT_EQ(lowest["mode_shapes"][0].size(), 2u);
  EXPECT_EQ(lowest["dofs"], all["dofs"]);
}

/// A stiffness matrix of n beams has eps n^4 = 6e-10 of its lowest square wrong.
TEST_F(ModesVerb, LowestOfALargeSceneAreThoseOfAllModes) {
  const auto scene = write("chain.yaml", large_chain("loads: [{node: b, force: [-40, 0, 3]}]\n"));
  const Json all = json({"modes", scene}), lowest = json({"modes", scene, "--lowest", "8"});
  expect_documented_keys("modes", lowest);
  EXPECT_EQ(lowest["dofs"].size(), 280u);
  EXPECT_EQ(lowest["mode_shapes"].size(), 280u);
  for (size_t i = 0; i < 8; ++i) {
    const double f = all["natural_frequencies_hz"][i];
    EXPECT_NEAR(lowest["natural_frequencies_hz"][i], f, 1e-9 * f) << i;
    EXPECT_NEAR(lowest["damping_ratios"][i], all["damping_ratios"][i], 1e-9) << i;
  }
  const Json multipliers = json({"buckling", scene, "--count", "3"})["load_multipliers"];
  const Json of_few = json({"buckling", scene, "--count", "100"})["load_multipliers"];
  ASSERT_EQ(multipliers.size(), 3u);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(multipliers[i], of_few[i].get<double>(), 1e-9 * of_few[i].get<double>()) << i;
  }
}

/// A free strip with a mass at its end, or clamped with nothing else that has mass.
std::string loose_strip(const std::string& mass, const std::string& mass_per_length, int n_parts,
                        const std::string& supports = "") {
  return "title: A strip\nplanar: true\nnodes: {a: {position: [0, 0]}, b: {position: [1, 0.3]}}\n"
         "masses: [{node: b, mass: " +
         mass + "}]\nelements: {s: {type: beam, nodes: [a, b], EA: 4e6, EI: 400, divide: " +
         std::to_string(n_parts) + mass_per_length + "}}\n" + supports + "dofs: auto\n";
}

// A stiffness that is singular, with a mass a thousand times that of the strip: rounding beside its
// fastest mode would leave 1e-4 Hz of the free ones, and 3e-5 of the others.
TEST_F(ModesVerb, WhatIsFreeHasZerosAndSpoilsNoOtherMode) {
  const auto scene = write("strip.yaml", loose_strip("1000", ", mass_per_length: 1", 80));
  const Json all = json({"modes", scene}), lowest = json({"modes", scene, "--lowest", "20"});
  for (const Json& document : {all, lowest}) {
    EXPECT_EQ(document["n_growing_eigenvalues"], 0);
    for (size_t i = 0; i < 3; ++i) EXPECT_EQ(document["natural_frequencies_hz"][i], 0) << i;
    for (size_t i = 0; i < 6; ++i) EXPECT_EQ(document["eigenvalues"][i], Json({0.0, 0.0})) << i;
  }
  for (size_t i = 3; i < 20; ++i) {
    const double f = lowest["natural_frequencies_hz"][i];
    // The rounding of 80 beams' stiffness matrix in the lowest one, as of chains, 2e-16 n^4.
    EXPECT_NEAR(all["natural_frequencies_hz"][i], f, 1e-8 * f) << i;
  }
}

// What moves freely answers a million times and more as strongly as what is asked for: how many are
// asked for must not matter.
TEST_F(ModesVerb, AnyNumberOfModesBesideWhatIsFree) {
  const auto scene = write("ball.yaml", R"(title: Two beams on a ball joint
nodes: {a: {position: [0, 0, 0]}, b: {position: [0.772, -0.242, 0.119]}, c: {position: [3.920, 0.057, 0.158]}}
masses: [{node: b, mass: 83.04}, {node: c, mass: 0.533, inertia: [0.0124, 0.0099, 0.00742]}]
elements:
  p: {type: beam, nodes: [a, b], EA: 6.042e+05, orientation: [0.1, 0.2, 1], GJ: 33, EI_y: 27.88, EI_z: 39.93, mass_per_length: 0.4191, inertia_per_length: 0.003272, divide: 40}
  q: {type: beam, nodes: [b, c], EA: 3.141e+07, orientation: [0.1, 0.2, 1], GJ: 218.4, EI_y: 3835, EI_z: 3675, mass_per_length: 0.2168, inertia_per_length: 0.0005175, divide: 40}
supports: [{nodes: [a], fix: [x, y, z]}]
dofs: auto
)");
  const Json all = json({"modes", scene})["natural_frequencies_hz"];
  for (const size_t n : {5, 61, 100}) {
    const Json lowest = json({"modes", scene, "--lowest", std::to_string(n)});
    const Json& hz = lowest["natural_frequencies_hz"];
    ASSERT_EQ(hz.size(), n);
    for (size_t i = 0; i < n; ++i) {
      const double f = all[i];
      // The dense one has the rounding of its stiffness matrix: 5e-9 were seen in the lowest.
      EXPECT_NEAR(hz[i], f, 2e-8 * f) << n << " " << i;
    }
  }
}

// Bending comes in twins, and of all but the slowest modes damping leaves real eigenvalues close
// together. How many are asked for must not matter, wherever that parts twins.
TEST_F(ModesVerb, DampedTwinsAreThoseOfAnyNumberOfModes) {
  const auto scene = write("mast.yaml", R"(title: A mast of threefold symmetry
nodes:
  foot_#: {repeat: 3, about: z, position: [0.4, 0, 0]}
  head_#: {repeat: 3, about: z, position: [0.4, 0, 6]}
  top: {position: [0, 0, 6]}
masses: [{node: top, mass: 25, inertia: [0.6, 0.6, 0.5]}]
elements:
  cap_#: {repeat: 3, type: rigid_beam, nodes: [top, head_#]}
  column_#: {repeat: 3, type: beam, nodes: [foot_#, head_#], orientation: [1, 0.1, 0], EA: 3e7, GJ: 4e3, EI_y: 5e3, EI_z: 5e3, mass_per_length: 1.2, inertia_per_length: 4e-4, damping_time: 0.02, divide: 9}
  a#: {repeat: 8, type: beam, nodes: [column_1/#, column_2/#], orientation: z, EA: 2e7, GJ: 2e3, EI_y: 3e3, EI_z: 3e3, mass_per_length: 0.8, inertia_per_length: 2e-4, damping_time: 0.01}
  b#: {repeat: 8, type: beam, nodes: [column_2/#, column_3/#], orientation: z, EA: 2e7, GJ: 2e3, EI_y: 3e3, EI_z: 3e3, mass_per_length: 0.8, inertia_per_length: 2e-4, damping_time: 0.01}
  c#: {repeat: 8, type: beam, nodes: [column_3/#, column_1/#], orientation: z, EA: 2e7, GJ: 2e3, EI_y: 3e3, EI_z: 3e3, mass_per_length: 0.8, inertia_per_length: 2e-4, damping_time: 0.01}
supports: [{nodes: [foot_1, foot_2, foot_3], fix: [x, y, z, rotation]}]
dofs: auto
)");
  const auto moduli = [](const Json& pair) {
    return pair[0].is_null() ? NAN : std::abs(Complex(pair[0], pair[1]));
  };
  const Json all = json({"modes", scene})["eigenvalues"];
  for (const int n : {4, 6, 7, 12, 20, 23}) {
    const Json found = json({"modes", scene, "--lowest", std::to_string(n)})["eigenvalues"];
    ASSERT_EQ(found.size(), 2u * n);
    int n_ringing = 0;
    for (const Json& pair : found) {
      if (pair[0].is_null()) continue;
      n_ringing += pair[1] != 0 ? 1 : 0;
      double least = INFINITY;
      for (const Json& one : all) {
        least = std::min(least, std::abs(Complex(one[0], one[1]) - Complex(pair[0], pair[1])));
      }
      // Of the dense ones, rounding of the stiffness beside their fastest mode.
      EXPECT_LE(least, 1e-8 * moduli(pair)) << n << " " << pair;
    }
    EXPECT_GE(n_ringing, 6) << n;
    for (size_t i = 0; i < 4; ++i) EXPECT_NEAR(moduli(found[i]) / moduli(all[0]), 1, 1e-9) << n;
  }
}

// A mass on a bar at the end of a chain: nothing resists its swinging across the bar.
TEST_F(ModesVerb, WhatNothingResistsIsNamedInScenesOfAnySize) {
  const auto scene = [&](int n_parts, const std::string& mass) {
    return write("bar.yaml", R"(title: A bar at the end of a chain
nodes: {a: {position: [0, 0, 0]}, b: {position: [10, 0.1, 0]}, p: {position: [10, 1, 0]}}
masses: [)" + mass + R"(]
elements:
  s: {type: beam, nodes: [a, b], orientation: [0, 0.2, 1], EA: 3e7, GJ: 4e3, EI_y: 5e3, EI_z: 6e3, mass_per_length: 1, inertia_per_length: 4e-4, divide: )" +
                                 std::to_string(n_parts) + R"(}
  t: {type: truss, nodes: [b, p], stiffness: 1e6}
supports: [{nodes: [a], fix: [x, y, z, rotation]}]
loads: [{node: p, force: [1, 0, 0.2]}]
operating_point: equilibrium
dofs: auto
)");
  };
  const auto refused = [&](std::vector<std::string> arguments) {
    const Said said = run(arguments);
    EXPECT_EQ(said.exit_code, 3) << said.output;
    return said.error;
  };
  for (const int n_parts : {3, 100, 1000}) {
    const auto heavy = scene(n_parts, "{node: p, mass: 1}");
    for (const char* verb : {"equilibrium", "buckling"}) {
      const std::string error = refused({verb, heavy});
      EXPECT_TRUE(error.find("(p)") != std::string::npos) << n_parts << " " << error;
    }
  }
  std::ifstream stream(scene(100, ""));
  std::string text(std::istreambuf_iterator<char>(stream), {});
  text.erase(text.find("loads:"), text.find("operating_point") - text.find("loads:"));
  const std::string error = refused({"modes", write("light.yaml", text), "--lowest", "6"});
  EXPECT_NE(error.find("(p) can move and has neither stiffness nor mass"), std::string::npos)
      << error;
}

/// A stiff bar of 1 kg/m on a ball joint, held by a spring at its tip or braken by a dashpot. Its
/// stiffness matrix has 0.1 Hz of rounding: the strains of its beams know better, and the page says
/// which are in doubt.
TEST_F(ModesVerb, SlowModesOfStiffBarsAreKnownOrSaidNotToBe) {
  const auto bar = [&](const std::string& law) {
    return write("bar.yaml", R"(title: A stiff bar on a ball joint
nodes: {a: {position: [0, 0, 0]}, b: {position: [1, 0, 0]}, g: {position: [1, 0, -1]}}
masses: []
elements:
  beam: {type: beam, nodes: [a, b], orientation: [0, 1, 0], EA: 1e9, GJ: 1e5, EI_y: 1e5, EI_z: 1e5, mass_per_length: 1, inertia_per_length: 1e-3, divide: 50}
  leg: {type: truss, nodes: [g, b], )" +
                                 law + R"(}
supports: [{nodes: [a, g], fix: [x, y, z]}]
dofs: auto
)");
  };
  const auto braked = bar("stiffness: 0, damping: 0.05");
  const Json slow = json({"modes", braked, "--lowest", "4"})["eigenvalues"];
  double nearest = INFINITY;
  for (const Json& pair : slow) nearest = std::min(nearest, std::abs(pair[0].get<double>() + 0.15));
  EXPECT_LE(nearest, 1e-7);  // c / (m / 3), as far as the bar is rigid
  EXPECT_EQ(json({"modes", braked})["n_growing_eigenvalues"], 0);
  const std::string page = run({"modes", braked}).output;
  EXPECT_NE(page.find("Rounding leaves less than three digits of 3 pair(s)"), std::string::npos);
  const auto sprung = bar("stiffness: 0.01");
  EXPECT_NEAR(json({"modes", sprung, "--lowest", "4"})["natural_frequencies_hz"][2],
              std::sqrt(0.03) / (2 * M_PI), 1e-7);
}

// A mass that nothing holds and nothing pushes stays where it is, beside what is loaded.
TEST_F(ModesVerb, WhatNothingPushesNeedsNothingToHoldIt) {
  const auto scene = write("loose.yaml", R"(title: A loaded cantilever and a loose mass
nodes: {a: {position: [0, 0, 0]}, b: {position: [1, 0, 0]}, q: {position: [2, 0, 0]}}
masses: [{node: q, mass: 1}]
elements:
  s: {type: beam, nodes: [a, b], orientation: [0, 1, 0], EA: 3e6, GJ: 40, EI_y: 50, EI_z: 60, mass_per_length: 1, inertia_per_length: 1e-4, divide: 400}
supports: [{nodes: [a], fix: [x, y, z, rotation]}]
loads: [{node: b, force: [0, 0, 0.5]}]
dofs: auto
)");
  const Json hz = json({"modes", scene, "--lowest", "4"})["natural_frequencies_hz"];
  for (size_t i = 0; i < 3; ++i) EXPECT_EQ(hz[i], 0) << i;
  // The slower bending of 1.8751^2 sqrt(EI / (m l^4)), hardly changed by the load.
  EXPECT_NEAR(hz[3].get<double>(), 3.516 * std::sqrt(50.0) / (2 * M_PI), 0.01);
}

// One answer for few nodes and for many, with --lowest and without: two modes, of a mass on a
// massless cantilever, k = 3 EI / l^3 across and EA / l along it.
TEST_F(ModesVerb, NodesWithoutMassFollow) {
  const double l = std::hypot(1, 0.3);
  for (const int n_parts : {1, 4, 80}) {
    const auto scene = write("light.yaml", loose_strip("2", "", n_parts,
                                                       "supports: [{nodes: [a], fix: [x, y, "
                                                       "rotation]}]\n"));
    const Json all = json({"modes", scene}), lowest = json({"modes", scene, "--lowest", "1"});
    const Json& hz = all["natural_frequencies_hz"];
    ASSERT_EQ(hz.size(), 2u) << n_parts;
    EXPECT_NEAR(hz[0].get<double>() * 2 * M_PI / std::sqrt(3 * 400 / (2 * l * l * l)), 1, 1e-9);
    EXPECT_NEAR(hz[1].get<double>() * 2 * M_PI / std::sqrt(4e6 / (2 * l)), 1, 1e-9);
    ASSERT_EQ(lowest["natural_frequencies_hz"].size(), 1u) << n_parts;
    EXPECT_NEAR(lowest["natural_frequencies_hz"][0].get<double>() / hz[0].get<double>(), 1, 1e-9);
  }
}

// The state matrix is orthogonal but for 2e-10, and Eigen's QR iteration alone does not end.
TEST_F(ModesVerb, TableThatHardlyTurnsHasItsPolesAndItsResponse) {
  const auto scene = table("1e-10", "0");
  expect_table(json({"modes", scene}), 1e-10, 0);
  // From the force in spring_x to that in it, s^2 / (s^2 + 1) but for the turning.
  const Json response = json({"sigma", scene, "--from", "0.3", "--to", "3", "--points", "2"});
  EXPECT_EQ(response["singular_values"].size(), 2u);
  for (const Json& row : response["singular_values"]) {
    for (const Json& value : row) EXPECT_TRUE(value.is_number()) << row;
  }
}

TEST_F(ModesVerb, TableThatThrowsItsMassOutIsPrintedInWords) {
  const auto scene = table("2", "0.1");
  const Json document = json({"modes", scene});
  EXPECT_EQ(document["n_growing_eigenvalues"], 2);
  EXPECT_EQ(document["natural_frequencies_hz"].size(), 0u);
  EXPECT_EQ(document["mode_shapes"].size(), 0u);
  expect_table(document, 2, 0.1);
  const Said said = run({"modes", scene});
  EXPECT_EQ(said.exit_code, 0);
  EXPECT_NE(said.output.find("NOT STABLE: 2 eigenvalue(s)"), std::string::npos) << said.output;
  EXPECT_NE(said.output.find("not positive in motion"), std::string::npos) << said.output;
}

TEST_F(ModesVerb, UnstableAtRestIsRefused) {
  std::string text = hanging_mass;
  // The spring pushes sideways and the mass may leave its line: preload P, length 1, P > k_x.
  text.replace(text.find("damping: 4"), 10, "preload: -5");
  text.replace(text.find("fix: [x, y]}"), 12, "fix: [y]}");
  text.replace(text.find("  - {element: spring}"), 21,
               "  - {element: spring}\n  - {node: mass, along: x}");
  text.replace(text.find("gravity: [0, 0, -9.81]\n"), 23, "operating_point: as_written\n");
  const Said said = run({"modes", write("scene.yaml", text)});
  EXPECT_EQ(said.exit_code, 3) << said.output;
  EXPECT_NE(said.error.find("which moves mass x 1"), std::string::npos) << said.error;
}

TEST_F(ModesVerb, PageHasSixDigitsOfSlowFrequenciesAndTheNodesThatMove) {
  std::string text = hanging_mass;
  text.replace(text.find("gravity: [0, 0, -9.81]\n"), 23, "");
  text.replace(text.find("stiffness: 800"), 14, "stiffness: 2e-6");
  const std::string page = run({"modes", write("scene.yaml", text)}).output;
  // sqrt(2e-6 / 2) / (2 pi)
  EXPECT_NE(page.find("0.000159155  mass z 1\n"), std::string::npos) << page;
}

/// A rigid bar of 2 m on two springs that are alike: it bounces, and turns about its middle.
TEST_F(ModesVerb, PageTellsTranslationsFromTurns) {
  const std::string page = run({"modes", write("scene.yaml", R"(title: A bar on two springs
planar: true
nodes:
  bar: {position: [0, 0]}
  left: {position: [-1, 0]}
  right: {position: [1, 0]}
  floor_left: {position: [-1, -1]}
  floor_right: {position: [1, -1]}
masses: [{node: bar, mass: 3, inertia: 0.5}]
elements:
  arm_left: {type: rigid_beam, nodes: [bar, left]}
  arm_right: {type: rigid_beam, nodes: [bar, right]}
  spring_left: {type: truss, nodes: [floor_left, left], stiffness: 100}
  spring_right: {type: truss, nodes: [floor_right, right], stiffness: 100}
supports:
  - {nodes: [floor_left, floor_right], fix: [x, y]}
  - {nodes: [bar], fix: [x]}
dofs: auto
)")})
                               .output;
  EXPECT_NE(page.find("  bar y 1\n"), std::string::npos) << page;
  EXPECT_NE(page.find("  bar rz 1\n"), std::string::npos) << page;
}

TEST_F(ModesVerb, PageSaysThatShapesOfFastModesAreLeftOut) {
  const std::string page = run({"modes", write("scene.yaml", R"(title: A cantilever
planar: true
nodes: {root: {position: [0, 0]}, tip: {position: [1, 0]}}
masses: []
elements: {beam: {type: beam, nodes: [root, tip], rigid: [1], EI: 1, mass_per_length: 1, divide: 16}}
supports: [{nodes: [root], fix: [x, y, rotation]}]
dofs: [{deformations: beam}]
)")})
                               .output;
  EXPECT_NE(page.find("Shapes of 8 more: see --json\n"), std::string::npos) << page;
}

TEST_F(ModesVerb, OverdampedModeIsAPairOfRealEigenvalues) {
  std::string text = hanging_mass;
  text.replace(text.find("damping: 4"), 10, "damping: 400");
  const Json document = json({"modes", write("scene.yaml", text)});
  // s^2 + 200 s + 400 = 0.
  const std::vector<Complex> values = eigenvalues(document);
  EXPECT_NEAR(values[0].real(), -100 + std::sqrt(9600), 1e-12);
  EXPECT_NEAR(values[1].real(), -100 - std::sqrt(9600), 1e-12);
  EXPECT_EQ(document["damping_ratios"][0], 1.0);
  EXPECT_NEAR(document["natural_frequencies_hz"][0].get<double>(), 20 / (2 * M_PI), 1e-14);
}

TEST_F(ModesVerb, ModesAreThoseOfTheEquilibrium) {
  const Json document = json({"modes", config("scenes/preloaded_frame.yaml")});
  EXPECT_EQ(document["moving"], false);
  EXPECT_EQ(document["natural_frequencies_hz"].size(), 6u);
}

// Damping in proportion to the stiffness, tau: every mode has omega tau / 2, the slow ones beside
// poles 1e7 times as fast too.
TEST_F(ModesVerb, SlowModesOfAStiffStripAreDamped) {
  const auto scene = write("scene.yaml", R"(title: A strip with a mass at its tip
planar: true
nodes: {clamp: {position: [0, 0]}, tip: {position: [0.5, 0]}}
masses: [{node: tip, mass: 0.5}]
elements:
  strip: {type: beam, nodes: [clamp, tip], EA: 4e6, EI: 0.3333, mass_per_length: 0.156,
    damping_time: 5e-3, divide: 16}
supports: [{nodes: [clamp], fix: [x, y, rotation]}]
dofs: [{deformations: strip}]
)");
  const Json document = json({"modes", scene});
  for (const size_t i : {0u, 1u}) {
    const double omega = 2 * M_PI * document["natural_frequencies_hz"][i].get<double>();
    const double expected = omega * 5e-3 / 2;
    // Of K in these dofs 1e-10 is rounding in its softest motion, and little of it is seen.
    EXPECT_NEAR(document["damping_ratios"][i].get<double>() / expected, 1, 1e-9);
    EXPECT_NEAR(eigenvalues(document)[2 * i].real() / (-expected * omega), 1, 1e-9);
  }
  const std::string page = run({"modes", scene}).output;
  EXPECT_NE(page.find("0.625156        0.00982\n"), std::string::npos) << page;
}

// A mass that a weak spring does not hold on a turning table, 0.2^2 - 0.01 = 0.1732^2 1/s^2, beside
// one on a spring of 1e7 rad/s.
TEST_F(ModesVerb, SlowGrowthBesideAFastModeIsSeen) {
  const auto scene = write("scene.yaml", R"(title: A weak spring on a turning table
nodes:
  c: {position: [0, 0, 0]}
  r: {position: [0, 0, 0]}
  m: {position: [1, 0, 0]}
  n: {position: [0, 0, 1]}
masses: [{node: m, mass: 1}, {node: n, mass: 0.001}]
elements:
  h: {type: hinge, nodes: [c, r], axis: z}
  arm: {type: beam, nodes: [r, m], orientation: y, EA: 0.01, rigid: [2, 3, 4, 5, 6]}
  stiff: {type: truss, nodes: [c, n], stiffness: 1e11}
supports: [{nodes: [c], fix: [x, y, z, rotation]}, {nodes: [n], fix: [x, y]}]
prescribed: [{element: h, rate: 0.2}]
dofs: [{element: arm, mode: 1}, {element: stiff}]
operating_point: as_written
)");
  const Json document = json({"modes", scene});
  EXPECT_EQ(document["n_growing_eigenvalues"], 1);
  EXPECT_EQ(document["damping_ratios"][0], -1.0);
  // The rate squared and the stiffness are 15 digits of their difference.
  EXPECT_NEAR(std::abs(eigenvalues(document)[0]), std::sqrt(0.03), 1e-14);
  EXPECT_NE(run({"modes", scene}).output.find("NOT STABLE: 1 eigenvalue"), std::string::npos);
}

TEST_F(ModesVerb, LengthsThatReadLikeMillimetresAreToldOf) {
  const auto scene = [&](double scale) {
    std::ostringstream text;
    text << "title: t\nnodes:\n  a: {position: [0, 0, 0]}\n  b: {position: [0, 0, " << 0.15 * scale
         << "]}\nmasses:\n  - {node: b, mass: 1}\nelements:\n"
            "  leg: {type: truss, nodes: [a, b], stiffness: 1e4}\n"
            "supports:\n  - {nodes: [a], fix: [x, y, z]}\n  - {nodes: [b], fix: [x, y]}\n"
            "dofs: auto\n";
    return write("leg.yaml", text.str());
  };
  EXPECT_EQ(run({"modes", scene(1)}).error, "");
  const Said said = run({"modes", scene(1000)});
  EXPECT_EQ(said.exit_code, 0) << said.error;
  EXPECT_NE(said.error.find("leg.yaml:8:8: leg is 150 m long; if its nodes are in millimetres"),
            std::string::npos)
      << said.error;
}

}  // namespace
}  // namespace stillframe::test

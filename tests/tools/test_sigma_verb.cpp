#include <algorithm>
#include <cmath>
#include <complex>
#include <fstream>
#include <iterator>

#include "core/mechanics/frequency_response.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "core/numerics/singular_values.hpp"
#include "tests/tools/verb.hpp"

namespace stillframe::test {
namespace {

using Json = nlohmann::json;
using Complex = std::complex<double>;

class SigmaVerb : public Verb {
 protected:
  /// |G| of a scene with one input and one output against a closed form of s.
  void expect_curve(const std::filesystem::path& scene, Complex (*G)(Complex s)) const {
    const Json document = json({"sigma", scene, "--from", "0.1", "--to", "100", "--points", "101"});
    ASSERT_EQ(document["frequencies_hz"].size(), 101u);
    for (size_t i = 0; i < 101; ++i) {
      const Complex s(0, 2 * M_PI * document["frequencies_hz"][i].get<double>());
      const double expected = std::abs(G(s));
      // Forces of the spring cancel up to (omega_0 / omega)^2 = 1000 times in those that remain.
      EXPECT_NEAR(document["singular_values"][i][0].get<double>(), expected, 1e-12 * expected) << i;
    }
    expect_documented_keys("sigma", document);
  }

  std::filesystem::path cart(const std::string& input, const std::string& output) const {
    return write("cart.yaml", R"(title: A cart
nodes:
  cart: {position: [0, 0, 0]}
  mass: {position: [1, 0, 0]}
masses:
  - {node: mass, mass: 2}
elements:
  spring: {type: truss, nodes: [cart, mass], stiffness: 800, damping: 4}
supports:
  - {nodes: [cart, mass], fix: [y, z]}
prescribed:
  - {nodes: [cart], move: [x]}
dofs:
  - {node: mass, along: x}
inputs:
  - )" + input + "\noutputs:\n  - " +
                                  output + "\n");
  }
};

/// V1: (d s + k) / (m s^2 + d s + k), m = 2, d = 4, k = 800.
Complex follow(Complex s) { return (4.0 * s + 800.0) / (2.0 * s * s + 4.0 * s + 800.0); }

TEST_F(SigmaVerb, MotionInputsOfAllKinds) {
  expect_curve(cart("{name: u, position: cart, along: x}", "{name: y, position: mass, along: x}"),
               [](Complex s) { return follow(s); });
  expect_curve(cart("{name: u, velocity: cart, along: x}", "{name: y, position: mass, along: x}"),
               [](Complex s) { return follow(s) / s; });
  expect_curve(
      cart("{name: u, acceleration: cart, along: x}", "{name: y, position: mass, along: x}"),
      [](Complex s) { return follow(s) / (s * s); });
}

TEST_F(SigmaVerb, OutputsOfAllKinds) {
  expect_curve(
      cart("{name: u, acceleration: cart, along: x}", "{name: y, reaction: cart, along: x}"),
      [](Complex s) { return 2.0 * follow(s); });
  expect_curve(cart("{name: u, force: mass, along: x}", "{name: y, velocity: mass, along: x}"),
               [](Complex s) { return s / (2.0 * s * s + 4.0 * s + 800.0); });
  expect_curve(cart("{name: u, stress: spring}", "{name: y, stress: spring}"),
               [](Complex s) { return 1.0 - (4.0 * s + 800.0) / (2.0 * s * s + 4.0 * s + 800.0); });
}

TEST_F(SigmaVerb, AboutTheEquilibrium) {
  expect_curve(write("scene.yaml", hanging_mass),
               [](Complex s) { return 1.0 / (2.0 * s * s + 4.0 * s + 800.0); });
}

TEST_F(SigmaVerb, TheClosedLoopIsTheOneThatRuns) {
  const std::filesystem::path frame = config("scenes/metrology_frame.yaml");
  const Json design = json({"design", frame});
  const Json document = json({"sigma", frame, "--from", "20", "--to", "200", "--points", "4"});
  expect_documented_keys("sigma", document);
  // 20, 43, 93, 200 Hz: both ends are lines of the design page.
  for (const auto& [i, hz] : {std::pair(0, 20.0), std::pair(3, 200.0)}) {
    const auto& lines = design["frequencies_hz"];
    const auto line = std::find(lines.begin(), lines.end(), hz) - lines.begin();
    for (const char* key :
         {"singular_values", "closed_singular_values", "continuous_singular_values"}) {
      const double found = document[key][i][0], expected = design[key][line][0];
      EXPECT_NEAR(found, expected, 1e-9 * expected) << key << " " << hz;
    }
  }
  // Above the target the continuous law falls by 40 dB a decade, what runs does not.
  EXPECT_LT(document["continuous_singular_values"][3][0].get<double>(), 1e-3);
  EXPECT_GT(document["closed_singular_values"][3][0].get<double>(), 0.1);
}

// Two legs that stand nearly flat, which the weight flattens more: as written they are stiffer than
// at the equilibrium. The controller does not change about which of the two the model is.
TEST_F(SigmaVerb, IsOfTheSceneAsWrittenWithAControllerToo) {
  const auto scene = [&](const std::string& point, bool controlled) {
    return write(
        "scene.yaml",
        "title: A flat arch\noperating_point: " + point + R"(
gravity: [0, 0, -9.81]
nodes:
  left: {position: [-1, 0, 0]}
  right: {position: [1, 0, 0]}
  top: {position: [0, 0, 0.2]}
masses: [{node: top, mass: 1}]
elements:
  one: {type: truss, nodes: [left, top], stiffness: 5000, damping: 1}
  other: {type: truss, nodes: [right, top], stiffness: 5000, damping: 1}
supports: [{nodes: [left, right, top], fix: [y]}]
prescribed: [{nodes: [left, right], move: [x, z]}]
dofs: [{element: one}, {element: other}]
inputs: [{name: floor, acceleration: left, along: z}]
outputs: [{name: top, acceleration: top, along: z}]
)" +
            (controlled
                 ? "controller: {legs: [one, other], target_hz: 0.5, sample_rate_hz: 1000, "
                   "damping_ratio: 0.7, delay_samples: 1, lead_samples: 1.5, leak_hz: 0.05}\n"
                 : ""));
  };
  const auto open = [&](const std::string& point, bool controlled) {
    // 2 and 20 Hz: lines of the design page too.
    const Said said = run({"sigma", scene(point, controlled), "--from", "2", "--to", "20",
                           "--points", "2", "--json"});
    EXPECT_EQ(said.exit_code, 0) << said.error;
    // The weight on legs that stand so flat makes it one of nothing that lasts, which is said.
    EXPECT_EQ(said.error.find("warning: the loop that runs is not stable (spectral radius 1.0") !=
                  std::string::npos,
              controlled)
        << said.error;
    return Json::parse(said.output)["singular_values"][0][0].get<double>();
  };
  const double as_written = open("as_written", false), balanced = open("equilibrium", false);
  EXPECT_GT(std::abs(as_written / balanced - 1), 0.01);
  // At 2 Hz the floor that is held over a sample of 1 ms takes (0.002 pi)^2 / 3 = 1.3e-5.
  EXPECT_NEAR(open("as_written", true), as_written, 2e-5 * as_written);
  EXPECT_NEAR(open("equilibrium", true), balanced, 2e-5 * balanced);
  for (const auto& [point, expected] :
       {std::pair{"as_written", as_written}, {"equilibrium", balanced}}) {
    const Said said = run({"design", scene(point, true), "--json"});
    const Json design = Json::parse(said.output);
    const auto& lines = design["frequencies_hz"];
    const auto line = std::find(lines.begin(), lines.end(), 2.0) - lines.begin();
    ASSERT_LT(line, static_cast<std::ptrdiff_t>(lines.size()));
    const double found = design["singular_values"][line][0];
    EXPECT_NEAR(found, expected, 2e-5 * expected) << point;
  }
}

// A mirror glued to a puck: 24.8 and 294 Hz with half-widths of 6e-3 and 3e-2 Hz, between any two
// of 600 frequencies. Its page said 32 dB less, and `sigma` another passive frame than the page.
TEST_F(SigmaVerb, ThePageOfARunHasTheSameCurves) {
  const auto scene = write("scene.yaml", R"(title: Mirror on a puck
planar: true
nodes: {base: {position: [0, 0]}, puck: {position: [0, 0.08]}, mirror: {position: [0, 0.12]}}
masses: [{node: puck, mass: 12}, {node: mirror, mass: 0.3}]
elements:
  leg: {type: truss, nodes: [base, puck], stiffness: 3e5, damping: 0.5}
  glue: {type: truss, nodes: [puck, mirror], stiffness: 1e6, damping: 0.05}
supports: [{nodes: [base, puck, mirror], fix: [x]}]
prescribed: [{nodes: [base], move: [y]}]
dofs: [{element: leg}, {element: glue}]
inputs: [{name: base, acceleration: base, along: y}]
outputs: [{name: mirror, acceleration: mirror, along: y}]
controller: {legs: [leg], target_hz: 4, damping_ratio: 0.7, sample_rate_hz: 1000, delay_samples: 1,
  lead_samples: 0.5, leak_hz: 0.05, force_limit_n: 100}
floor: {multisine: {frequencies_hz: [1, 2, 4, 8, 16, 32, 64, 128, 200], amplitude: 0.005}}
)");
  const Said ran = run({"run", scene, "--mode", "single_process", "--out", folder_ / "run"});
  EXPECT_NE(ran.exit_code, 2) << ran.error;
  const std::string page = text_of(folder_ / "run/report.html"), open = "id=\"stillframe-data\">";
  const std::size_t begin = page.find(open) + open.size();
  const Json figure =
      Json::parse(page.substr(begin, page.find("</script>", begin) - begin))["singular_values"];
  const auto highest = [&](const char* curve, double from_hz, double to_hz) {
    double found = 0;
    for (size_t i = 0; i < figure["f"].size(); ++i) {
      const double hz = figure["f"][i];
      if (hz < from_hz || hz > to_hz || figure[curve][0][i].is_null()) continue;
      found = std::max(found, figure[curve][0][i].get<double>());
    }
    return found;
  };
  const Json document = json({"sigma", scene, "--from", "1", "--to", "400", "--points", "3"});
  size_t n = 0;
  for (const Json& peak : document["peaks"]) {
    const double hz = peak["hz"], value = peak["singular_value"];
    // Pictures read a peak 0.07 dB low at most.
    EXPECT_NEAR(highest(peak["of"].get<std::string>().c_str(), hz / 1.02, hz * 1.02) / value, 1,
                0.009)
        << peak;
    ++n;
  }
  EXPECT_GE(n, 3u) << document["peaks"];
  const auto& f = figure["f"];
  for (const double near : {2.0, 100.0, 400.0}) {
    size_t i = 0;
    while (f[i].get<double>() < near) ++i;
    const std::string hz = std::to_string(f[i].get<double>());
    const Json row = json({"sigma", scene, "--from", hz, "--to", "450", "--points", "2"});
    for (const auto& [curve, key] :
         {std::pair("open", "singular_values"), {"closed", "closed_singular_values"}}) {
      const double shown = figure[curve][0][i], said = row[key][0][0];
      // The page keeps six digits of frequencies, in which curves fall as the fourth power at most,
      // and of values.
      EXPECT_NEAR(shown / said, 1, 2e-5) << curve << " " << hz;
    }
  }
}

TEST_F(SigmaVerb, AboveHalfTheRateNothingRuns) {
  const Said said = run({"sigma", config("scenes/metrology_frame.yaml"), "--from", "400", "--to",
                         "600", "--points", "2", "--json"});
  ASSERT_EQ(said.exit_code, 0) << said.error;
  EXPECT_NE(said.error.find("above half the sample rate"), std::string::npos) << said.error;
  const Json document = Json::parse(said.output);
  EXPECT_TRUE(document["closed_singular_values"][0][0].is_number());
  EXPECT_TRUE(document["closed_singular_values"][1][0].is_null());
  EXPECT_TRUE(document["continuous_singular_values"][1][0].is_number());
}

TEST_F(SigmaVerb, TheAxisIsThatOfTheScene) {
  const auto expect_axis = [&](const std::filesystem::path& scene, double lowest, double highest) {
    const Json hz = json({"sigma", scene})["frequencies_hz"];
    EXPECT_NEAR(hz.front().get<double>(), lowest, 1e-9 * lowest) << scene;
    EXPECT_NEAR(hz.back().get<double>(), highest, 1e-9 * highest) << scene;
  };
  expect_axis(write("scene.yaml", hanging_mass), 0.2, 20);  // 3.18 Hz
  expect_axis(config("scenes/metrology_frame.yaml"), 0.5, 200);
  // 13.9 to 49 Hz and 5 Hz at a rate of 250 Hz.
  std::ifstream file(config("controllers/force_feedback_5hz.yaml"));
  std::string block((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  block.replace(block.find("sample_rate_hz: 1000"), 20, "sample_rate_hz: 250 ");
  const Json slow = json(
      {"sigma", config("scenes/metrology_frame.yaml"), "--controller", write("slow.yaml", block)});
  EXPECT_NEAR(slow["frequencies_hz"].back().get<double>(), 125, 1e-9);
}

// 3.183 Hz, damped by 4 / (2 sqrt(800 * 2)) = 0.05 as it is written, by 5e-5 here: between two of
// fifty frequencies.
TEST_F(SigmaVerb, APeakBetweenTheFrequenciesHasARow) {
  std::string text = hanging_mass;
  text.replace(text.find("damping: 4"), 10, "damping: 0.004");
  const auto scene = write("scene.yaml", text);
  const double zeta = 5e-5, peak = 1 / (2 * zeta * std::sqrt(1 - zeta * zeta)) / 800;
  const Json document = json({"sigma", scene});
  double highest = 0;
  for (const Json& row : document["singular_values"]) {
    highest = std::max(highest, row[0].get<double>());
  }
  EXPECT_LT(highest, peak / 10);
  ASSERT_EQ(document["peaks"].size(), 1u);
  EXPECT_EQ(document["peaks"][0]["of"], "open");
  // To what peaks_between refines.
  EXPECT_NEAR(document["peaks"][0]["singular_value"].get<double>() / peak, 1, 1e-6);
  EXPECT_NEAR(document["peaks"][0]["hz"].get<double>(), 20 / (2 * M_PI), 1e-6);
  const std::string page = run({"sigma", scene}).output;
  EXPECT_NE(page.find("3.183  1.2500e+01   open 1\n"), std::string::npos) << page;
  // Nothing damps it: no value, and no picture of one.
  text.replace(text.find(", damping: 0.004"), 16, "");
  const auto undamped = write("undamped.yaml", text);
  EXPECT_TRUE(json({"sigma", undamped})["peaks"][0]["singular_value"].is_null());
  const std::string without = run({"sigma", undamped}).output;
  EXPECT_NE(without.find("no bound"), std::string::npos) << without;
}

const char* const two_by_two = R"(inputs:
  - {name: push, force: b, along: z}
  - {name: shove, force: b, along: y}
outputs:
  - {name: moved, position: b, along: z}
  - {name: shaken, acceleration: b, along: y}
)";

/// Largest singular value of the dense way, which forms all matrices.
double dense_gain(const LinearModel& linear, double hz) {
  return singular_values(transfer_function(linear, {0, 2 * M_PI * hz}))(0);
}

LinearModel dense_model(const std::filesystem::path& file) {
  const Scene scene = read_scene(file);
  return linearise(make_model(scene), scene.inputs, scene.outputs);
}

/// A stiffness matrix of n beams has eps n^4 = 6e-10 of its lowest square wrong, and a resonance
/// that is damped by 3e-4 makes 1e-6 of it.
TEST_F(SigmaVerb, OfALargeSceneIsThatOfItsMatrices) {
  const auto scene = write("chain.yaml", large_chain(two_by_two));
  const Json document = json({"sigma", scene, "--from", "1", "--to", "500", "--points", "7"});
  const LinearModel linear = dense_model(scene);
  EXPECT_EQ(document["stable"], true);
  ASSERT_EQ(document["singular_values"].size(), 7u);
  for (size_t i = 0; i < 7; ++i) {
    const double expected = dense_gain(linear, document["frequencies_hz"][i]);
    EXPECT_NEAR(document["singular_values"][i][0], expected, 1e-7 * expected) << i;
  }
  ASSERT_GE(document["peaks"].size(), 2u);
  for (const Json& peak : document["peaks"]) {
    const double expected = dense_gain(linear, peak["hz"]);
    EXPECT_NEAR(peak["singular_value"], expected, 1e-6 * expected) << peak;
    // The highest of its surroundings: half a per cent beside it is lower.
    EXPECT_LT(dense_gain(linear, peak["hz"].get<double>() * 1.005), expected) << peak;
    EXPECT_LT(dense_gain(linear, peak["hz"].get<double>() * 0.995), expected) << peak;
  }
}

TEST_F(SigmaVerb, OfALargeSceneThatIsNotStableHasNoPeaks) {
  const auto scene = write("chain.yaml", large_chain("loads: [{node: b, force: [-3000, 0, 0]}]\n" +
                                                     std::string(two_by_two)));
  const Said said = run({"sigma", scene, "--json"});
  EXPECT_EQ(said.exit_code, 0) << said.error;
  EXPECT_NE(said.error.find("not stable"), std::string::npos) << said.error;
  EXPECT_NE(said.error.find("which moves b "), std::string::npos) << said.error;
  const Json document = Json::parse(said.output);
  EXPECT_EQ(document["stable"], false);
  EXPECT_EQ(document["peaks"].size(), 0u);
  const double expected = dense_gain(dense_model(scene), document["frequencies_hz"][3]);
  EXPECT_NEAR(document["singular_values"][3][0], expected, 1e-7 * expected);
}

/// The values are those of the reduced model, and the difference from the whole is within the bound
/// (beside what both are known to).
TEST_F(SigmaVerb, OfAReducedSceneComesWithABound) {
  const std::vector<std::string> range{"--from", "1", "--to", "1000", "--points", "25"};
  const auto sigma = [&](const std::string& reduce) {
    std::vector<std::string> call{
        "sigma", write("chain.yaml", large_chain(std::string(two_by_two) + reduce))};
    call.insert(call.end(), range.begin(), range.end());
    return json(call);
  };
  const Json whole = sigma(""), reduced = sigma("reduce: {modes: 4}\n");
  expect_documented_keys("sigma", reduced);
  EXPECT_TRUE(whole["difference_at_most"].is_null());
  int n_bounds = 0, n_apart = 0;
  for (size_t i = 0; i < 25; ++i) {
    const Json& at_most = reduced["difference_at_most"][i];
    if (at_most.is_null()) continue;
    ++n_bounds;
    for (size_t k = 0; k < 2; ++k) {
      const double exact = whole["singular_values"][i][k],
                   off = std::abs(reduced["singular_values"][i][k].get<double>() - exact);
      EXPECT_LE(off, at_most.get<double>() + 1e-7 * whole["singular_values"][i][0].get<double>())
          << i;
      n_apart += off > 1e-6 * exact;
    }
  }
  // Modes beyond the fourth are where no bound is, and below them the model is seen to be reduced.
  EXPECT_GT(n_bounds, 10);
  EXPECT_LT(n_bounds, 25);
  EXPECT_GT(n_apart, 3);
  const Said page = run(
      {"sigma", write("chain.yaml", large_chain(std::string(two_by_two) + "reduce: {modes: 4}\n")),
       "--points", "5"});
  EXPECT_NE(page.output.find("off by at most"), std::string::npos) << page.output;
}

/// The curve of the passive frame is sampled; the lowest of the reduced modes stand far below half
/// the rate, where that is nothing beside what is left out.
TEST_F(SigmaVerb, OfAReducedSceneWithAControllerComesWithABoundToo) {
  std::ifstream stream(config("scenes/frame_flexible.yaml"));
  std::string text(std::istreambuf_iterator<char>(stream), {});
  const std::string key = "controller: ../controllers/";
  const size_t at = text.find(key);
  ASSERT_NE(at, std::string::npos);
  text.replace(at, key.size(), "controller: " + config("controllers/").string());
  const auto scene = write("frame.yaml", text),
             reduced = write("reduced.yaml", text + "reduce: {modes: 3}\n");
  const auto sigma = [&](const std::filesystem::path& file) {
    return json({"sigma", file, "--from", "1", "--to", "25", "--points", "9"});
  };
  const Json whole = sigma(scene), on_modes = sigma(reduced);
  EXPECT_TRUE(whole["difference_at_most"].is_null());
  double nearest = 0;
  for (size_t i = 0; i < 9; ++i) {
    const double largest = whole["singular_values"][i][0],
                 at_most = on_modes["difference_at_most"][i];
    for (size_t k = 0; k < 6; ++k) {
      const double exact = whole["singular_values"][i][k],
                   off = std::abs(on_modes["singular_values"][i][k].get<double>() - exact);
      EXPECT_LE(off, 1.01 * at_most + 1e-9 * largest) << i;
      nearest = std::max(nearest, off / at_most);
    }
  }
  EXPECT_GT(nearest, 0.1);  // nor is it the bound of a model without the legs' corrections
  // All that has mass: what is left of the forces is rounding, and no motion of its own.
  std::ifstream rigid(config("scenes/metrology_frame.yaml"));
  std::string whole_text(std::istreambuf_iterator<char>(rigid), {});
  whole_text.replace(whole_text.find(key), key.size(),
                     "controller: " + config("controllers/").string());
  for (const std::string all : {"modes: 5", "modes: 6", "to_hz: 100"}) {
    const Json of_all = json({"design", write("all.yaml", whole_text + "reduce: {" + all + "}\n")});
    EXPECT_EQ(
        of_all["reduction"]["n_modes"].get<int>() + of_all["reduction"]["n_corrections"].get<int>(),
        6)
        << all;
  }
  const Json design = json({"design", reduced});
  EXPECT_EQ(design["reduction"]["n_modes"], 3);
  EXPECT_GT(design["reduction"]["bounds"].size(), 3u);
  const std::string page = run({"design", reduced}).output;
  EXPECT_NE(page.find("Reduced: 3 modes and "), std::string::npos) << page;
}

TEST_F(SigmaVerb, PictureOfAnyScene) {
  const auto file = folder_ / "curve.png";
  ASSERT_EQ(run({"sigma", config("scenes/spinning_arm.yaml"), "--plot", file}).exit_code, 0);
  EXPECT_GT(std::filesystem::file_size(file), 1000u);
}

TEST_F(SigmaVerb, WithoutInputsIsABadScene) {
  std::string text = hanging_mass;
  text.resize(text.find("inputs:"));
  expect_refused({"sigma", write("scene.yaml", text)}, 2,
                 "singular values need at least one of 'inputs' and of 'outputs'");
}

TEST_F(SigmaVerb, FrequenciesTheWrongWayRound) {
  expect_refused({"sigma", config("scenes/cart.yaml"), "--from", "10", "--to", "1"}, 2, "--from");
}

}  // namespace
}  // namespace stillframe::test

#include <cmath>
#include <complex>

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

TEST_F(SigmaVerb, ControllerAddsTheClosedLoop) {
  const Json document =
      json({"sigma", config("scenes/metrology_frame.yaml"), "--to", "400", "--points", "3"});
  EXPECT_EQ(document["closed_singular_values"][0].size(), 6u);
  EXPECT_EQ(document["sampled_singular_values"][0].size(), 6u);
  expect_documented_keys("sigma", document);
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

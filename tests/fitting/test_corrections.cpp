#include <gtest/gtest.h>

#include "core/control/robustness/parameters.hpp"
#include "core/errors/input_error.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "tests/fitting/small_frame.hpp"

namespace stillframe::fitting {
namespace {

using Eigen::Index;

/// What `corrections` says of a scene is what perturbed makes of it.
TEST(Corrections, AreThePerturbedScene) {
  const FitQuestion question = small_frame_question();
  const std::string block = R"(corrections:
  stiffness: {leg_l: 0.1, leg_s: -0.05}
  damping: {leg_r: 0.2}
  mass: {lens: -0.03}
  inertia: {lens: 0.04}
  centre_of_mass_m: {lens: [0.002, -0.001]}
  leg_direction_rad: {leg_r: [0.03]}
  delay_samples: 0.25
)";
  const Scene corrected = parse_scene(small_frame_text() + block, "corrected");
  Eigen::VectorXd values = Eigen::VectorXd::Zero(static_cast<Index>(question.parameters.size()));
  const auto set = [&](const std::string& name, double value) {
    for (std::size_t i = 0; i < question.parameters.size(); ++i) {
      if (robustness::name_of(question.parameters[i]) != name) continue;
      values(static_cast<Index>(i)) = value / question.parameters[i].size;
      return;
    }
    ADD_FAILURE() << "no parameter " << name;
  };
  set("leg_l stiffness", 0.1);
  set("leg_s stiffness", -0.05);
  set("leg_r damping", 0.2);
  set("lens mass", -0.03);
  set("lens inertia", 0.04);
  set("lens centre of mass along x", 0.002);
  set("lens centre of mass along y", -0.001);
  set("leg_r foot towards x", 0.03);
  set("delay", 0.25);
  const robustness::PerturbedPlant expected =
      robustness::perturbed(question.scene, question.sampling, question.parameters, values);
  EXPECT_DOUBLE_EQ(corrected.controller->delay_samples, expected.sampling.delay_samples);
  Sampling sampling = question.sampling;
  sampling.delay_samples = corrected.controller->delay_samples;
  const SampledPlant a = robustness::sampled({corrected, sampling}),
                     b = robustness::sampled(expected);
  // The same numbers by the same steps, but for 0.1 / 0.2 * 0.2.
  EXPECT_LT((a.Phi - b.Phi).norm(), 1e-12 * b.Phi.norm());
  EXPECT_LT((a.C_y - b.C_y).norm(), 1e-12 * b.C_y.norm());
  EXPECT_LT((a.Gamma_u - b.Gamma_u).norm(), 1e-12 * b.Gamma_u.norm());
  EXPECT_NE(corrected.hash, question.scene.hash);
}

TEST(Corrections, SayWhatIsWrong) {
  const auto refused = [](const std::string& block, const std::string& message) {
    try {
      parse_scene(small_frame_text() + "corrections: " + block + "\n", "scene.yaml");
      ADD_FAILURE() << block << " was taken";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
    }
  };
  refused("{stiffness: {leg_x: 0.1}}", "there is no element named 'leg_x'");
  refused("{stiffness: {leg_l: -1}}", "found -1, allowed is above -1");
  refused("{mass: {left: 0.1}}", "there is no node with a mass named 'left'");
  refused("{centre_of_mass_m: {lens: [1, 2, 3]}}", "lens");
  refused("{leg_direction_rad: {leg_l: [0.1, 0.1]}}", "leg_l");
  refused("{delay: 1}", "delay");
  refused("{damping: {leg_s: 0.1}}", "'leg_s' has no damping");
  refused("{stiffness: {arm_left: 0.1}}", "'arm_left' has no stiffness");
}

}  // namespace
}  // namespace stillframe::fitting

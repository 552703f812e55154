#include <algorithm>
#include <cmath>

#include "core/mechanics/equilibrium.hpp"
#include "core/mechanics/linearisation/linearisation.hpp"
#include "core/mechanics/node_displacements.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "tests/tools/verb.hpp"

namespace stillframe::test {
namespace {

using Json = nlohmann::json;

class EquilibriumVerb : public Verb {};
class BucklingVerb : public Verb {
 protected:
  /// A pinned column, L = 2 m, EI = 3 N m^2, in 8 parts; a negative load pushes.
  std::filesystem::path column(const std::string& load) const {
    return write("column.yaml", R"(title: A pinned column
planar: true
nodes:
  root: {position: [0, 0]}
  tip: {position: [2, 0]}
masses: []
elements:
  column: {type: beam, nodes: [root, tip], EA: 1e6, EI: 3, mass_per_length: 1,
    second_order: true, divide: 8}
supports:
  - {nodes: [root], fix: [x, y]}
  - {nodes: [tip], fix: [y]}
dofs: auto
)" + load);
  }
};

TEST_F(EquilibriumVerb, HangingMass) {
  const Json document = json({"equilibrium", write("scene.yaml", hanging_mass)});
  const double weight = 2 * 9.81;
  // The residual is rounding of the weight: 1e-15 of 19.62 N, over 800 N/m.
  EXPECT_NEAR(document["q"][0].get<double>(), weight / 800, 1e-15);
  EXPECT_EQ(document["dofs"][0], "e(spring)");
  EXPECT_EQ(document["nodal_displacements"][1]["node"], "mass");
  EXPECT_NEAR(document["nodal_displacements"][1]["displacement"][2].get<double>(), -weight / 800,
              1e-15);
  EXPECT_NEAR(document["elements"][0]["stress_resultants"][0].get<double>(), weight, 1e-13);
  EXPECT_NEAR(document["reference"].get<double>(), weight, 1e-13);
  EXPECT_LE(document["residual"].get<double>(), 1e-13);
  const Json& reactions = document["reactions"];
  ASSERT_EQ(reactions.size(), 5u);
  for (const Json& reaction : reactions) {
    const bool holds = reaction["node"] == "ceiling" && reaction["direction"][2] == 1.0;
    EXPECT_NEAR(reaction["value"].get<double>(), holds ? weight : 0.0, 1e-13) << reaction;
  }
  expect_documented_keys("equilibrium", document);
  const std::string page = run({"equilibrium", folder_ / "scene.yaml"}).output;
  EXPECT_NE(page.find("0.024525"), std::string::npos) << page;
  EXPECT_NE(page.find("ceiling  z"), std::string::npos) << page;
  EXPECT_EQ(page.find("-0\n"), std::string::npos) << page;
}

TEST_F(EquilibriumVerb, SpatialRotationsAreAnglesTimesAxes) {
  const Json document = json({"equilibrium", write("scene.yaml", R"(title: A weak bearing
nodes:
  wall: {position: [0, 0, 0]}
  arm: {position: [0, 0, 0]}
masses:
  - {node: arm, mass: 1, inertia: [1, 1, 1]}
elements:
  bearing: {type: hinge, nodes: [wall, arm], axis: [0, 3, 4], stiffness: 2}
supports:
  - {nodes: [wall], fix: [x, y, z, rotation]}
loads:
  - {node: arm, torque: [0, 1.2, 1.6]}
dofs:
  - {element: bearing, mode: 1}
)")});
  // 2 N m about the axis, over 2 N m/rad: one radian about (0, 0.6, 0.8).
  const Json& rotation = document["nodal_displacements"][1]["rotation"];
  EXPECT_NEAR(rotation[0].get<double>(), 0, 1e-14);
  EXPECT_NEAR(rotation[1].get<double>(), 0.6, 1e-14);
  EXPECT_NEAR(rotation[2].get<double>(), 0.8, 1e-14);
  EXPECT_NEAR(document["elements"][0]["deformations"][0].get<double>(), 1.0, 1e-14);
  // The wall holds against the whole torque.
  double moment = 0;
  for (const Json& reaction : document["reactions"]) {
    if (reaction["unit"] == "N m") {
      moment += std::pow(reaction["value"].get<double>(), 2);
    }
  }
  EXPECT_NEAR(std::sqrt(moment), 2.0, 1e-13);
}

/// By symmetry it sinks only: what else the balance finds is rounding of the positions.
TEST_F(EquilibriumVerb, PageHasNoRoundingOfPositions) {
  std::string text = R"(title: A symmetric tripod
gravity: [0, 0, -9.81]
nodes:
  mass: {position: [0, 0, 0]}
  one: {position: [0.984807753012208, 0.1736481776669303, -1]}
  two: {position: [-0.6427876096865394, 0.766044443118978, -1]}
  three: {position: [-0.3420201433256685, -0.9396926207859084, -1]}
masses: [{node: mass, mass: 10}]
elements:
  leg_1: {type: truss, nodes: [one, mass], stiffness: 10000}
  leg_2: {type: truss, nodes: [two, mass], stiffness: 10000}
  leg_3: {type: truss, nodes: [three, mass], stiffness: 10000}
supports: [{nodes: [one, two, three], fix: [x, y, z]}]
dofs: [{node: mass, along: x}, {node: mass, along: y}, {node: mass, along: z}]
)";
  const std::string page = run({"equilibrium", write("scene.yaml", text)}).output;
  EXPECT_NE(page.find("x(mass)  m                  0\n"), std::string::npos) << page;
  EXPECT_NE(page.find("y(mass)  m                  0\n"), std::string::npos) << page;
  // m g / k_z, k_z = 3 k / 2: 6.54e-18 m is small of the scene, but no rounding of what moves.
  text.replace(text.find("mass: 10}"), 9, "mass: 1e-14}");
  const std::string tiny = run({"equilibrium", write("scene.yaml", text)}).output;
  EXPECT_NE(tiny.find("-6.54e-18\n"), std::string::npos) << tiny;
}

/// What the dense way has to say of the same scene.
struct DenseEquilibrium {
  Model model;
  Equilibrium found;
  Lineariser lineariser;
  explicit DenseEquilibrium(const std::filesystem::path& scene)
      : model(make_model(read_scene(scene))),
        found(solve_equilibrium(model)),
        lineariser(model, {}, {}, {.mass = false, .damping = false, .stiffness = false}) {
    lineariser.about(found.motion);
  }
};

/// Two Newton's methods that stop at 1e-7 of the loads, each a square of that away: of the
/// displacements 1e-8 is left, and of the resultants, some of which are differences, 1e-7.
TEST_F(EquilibriumVerb, OfALargeSceneIsThatOfItsDofs) {
  const auto scene = write("chain.yaml", large_chain("loads: [{node: b, force: [-40, 5, 3]}]\n"
                                                     "gravity: [0, 0, -9.81]\n"));
  const Json document = json({"equilibrium", scene});
  expect_documented_keys("equilibrium", document);
  EXPECT_EQ(document["dofs"].size(), 280u);
  EXPECT_EQ(document["q"].size(), 280u);
  EXPECT_EQ(document["dof_units"].size(), 280u);
  EXPECT_EQ(document["stable"], true);
  const DenseEquilibrium dense(scene);
  const auto nodes = node_displacements(dense.model, dense.found.motion.x);
  ASSERT_EQ(document["nodal_displacements"].size(), nodes.size());
  double largest = 0;
  for (const auto& node : nodes) largest = std::max(largest, node.displacement.norm());
  EXPECT_GT(largest, 1e-3);
  for (size_t i = 0; i < nodes.size(); ++i) {
    const Json& node = document["nodal_displacements"][i];
    EXPECT_EQ(node["node"], nodes[i].node);
    for (Eigen::Index k = 0; k < 3; ++k) {
      const auto entry = static_cast<size_t>(k);
      EXPECT_NEAR(node["displacement"][entry], nodes[i].displacement(k), 1e-8 * largest) << i;
      EXPECT_NEAR(node["rotation"][entry], nodes[i].rotation(k), 1e-8) << i;
    }
  }
  ASSERT_EQ(document["elements"].size(), 40u);
  const auto& data = dense.lineariser.data();
  for (const Json& element : document["elements"]) {
    const auto& item = dense.model.elements[static_cast<size_t>(
        dense.model.element_index(element["element"].get<std::string>()))];
    for (size_t i = 0; i < element["stress_resultants"].size(); ++i) {
      EXPECT_NEAR(element["stress_resultants"][i], data.sigma(item.row[i]), 1e-7 * 50) << element;
      EXPECT_NEAR(element["deformations"][i], data.e(item.row[i]), 1e-8 * largest) << element;
    }
  }
}

/// Forces and moments about the clamp, without any model: what is pushed is borne.
TEST_F(EquilibriumVerb, SupportsOfALargeSceneBearItsLoads) {
  const auto scene = write("chain.yaml", large_chain("loads: [{node: b, force: [-40, 5, 3]}]\n"));
  const Json document = json({"equilibrium", scene});
  const Json& tip = document["nodal_displacements"];
  Eigen::Vector3d arm(1, 0, 0), force, moment;
  for (const Json& node : tip) {
    if (node["node"] != "b") continue;
    for (size_t k = 0; k < 3; ++k) {
      arm(static_cast<Eigen::Index>(k)) += node["displacement"][k].get<double>();
    }
  }
  const Eigen::Vector3d load(-40, 5, 3);
  ASSERT_EQ(document["reactions"].size(), 6u);
  for (size_t i = 0; i < 3; ++i) {
    force(static_cast<Eigen::Index>(i)) = document["reactions"][i]["value"];
    moment(static_cast<Eigen::Index>(i)) = document["reactions"][i + 3]["value"];
    EXPECT_EQ(document["reactions"][i]["unit"], "N");
    EXPECT_EQ(document["reactions"][i + 3]["unit"], "N m");
  }
  // The residual of 40 N is 1e-7 of it squared by the last step.
  EXPECT_LT((force + load).norm(), 1e-9 * load.norm()) << force;
  EXPECT_LT((moment + arm.cross(load)).norm(), 1e-9 * load.norm()) << moment;
}

TEST_F(EquilibriumVerb, OfALargeSceneThatIsNotStableIsPrintedWithAWarning) {
  const auto scene = write("chain.yaml", large_chain("loads: [{node: b, force: [-3000, 0, 0]}]\n"));
  const Said said = run({"equilibrium", scene, "--json"});
  EXPECT_EQ(said.exit_code, 0) << said.error;
  EXPECT_NE(said.error.find("not stable"), std::string::npos) << said.error;
  EXPECT_NE(said.error.find("which moves b "), std::string::npos) << said.error;
  EXPECT_EQ(Json::parse(said.output)["stable"], false);
}

TEST_F(EquilibriumVerb, NothingThatHoldsIsRefused) {
  std::string text = hanging_mass;
  text.replace(text.find("stiffness: 800"), 14, "stiffness: 0");
  expect_refused({"equilibrium", write("scene.yaml", text)}, 3, "no equilibrium found");
}

/// V6: n^2 pi^2 EI / L^2.
TEST_F(BucklingVerb, EulerColumn) {
  const auto scene = column("loads:\n  - {node: tip, force: [-1, 0]}\n");
  const Json document = json({"buckling", scene, "--count", "2"});
  const Json& multipliers = document["load_multipliers"];
  ASSERT_EQ(multipliers.size(), 2u);
  const double euler = M_PI * M_PI * 3 / 4;
  // Cubic elements converge with (n pi / 8)^4 / 720 or faster: 3.4e-5 and 5.3e-4.
  EXPECT_NEAR(multipliers[0].get<double>(), euler, 4e-5 * euler);
  EXPECT_NEAR(multipliers[1].get<double>(), 4 * euler, 6e-4 * 4 * euler);
  EXPECT_GE(multipliers[0].get<double>(), euler);  // a restricted shape is too stiff
  EXPECT_EQ(document["shapes"].size(), document["dofs"].size());
  EXPECT_EQ(document["shapes"][0].size(), 2u);
  expect_documented_keys("buckling", document);
  const std::string page = run({"buckling", scene, "--count", "2"}).output;
  EXPECT_NE(page.find("it buckles at 7.40"), std::string::npos) << page;
  EXPECT_NE(page.find("phi(root) 1"), std::string::npos) << page;
  EXPECT_NE(page.find("more: see --count"), std::string::npos) << page;
}

TEST_F(BucklingVerb, PullHasNoMultiplier) {
  const auto scene = column("loads:\n  - {node: tip, force: [1, 0]}\n");
  EXPECT_EQ(json({"buckling", scene})["load_multipliers"].size(), 0u);
  EXPECT_NE(run({"buckling", scene}).output.find("no multiple of the load"), std::string::npos);
}

TEST_F(BucklingVerb, NoLoadIsRefused) {
  expect_refused({"buckling", column("")}, 3, "there is no load to multiply");
}

// 20 N on a column that buckles at 7.4 N: it balances, and does not stay there.
TEST_F(BucklingVerb, BeyondItsLoadEveryVerbWarnsThatTheOperatingPointIsNotStable) {
  const std::string signals = R"(inputs: [{name: push, force: tip, along: x}]
outputs: [{name: moved, position: tip, along: x}]
)";
  const auto scene = column("loads: [{node: tip, force: [-20, 0]}]\n" + signals);
  for (const char* verb : {"equilibrium", "linearise", "sigma"}) {
    for (const bool as_json : {false, true}) {
      std::vector<std::string> arguments{verb, scene};
      if (as_json) arguments.push_back("--json");
      const Said said = run(arguments);
      EXPECT_EQ(said.exit_code, 0) << verb;
      EXPECT_NE(said.error.find("warning: the operating point is not stable, and nothing stays "
                                "there: omega^2 = -"),
                std::string::npos)
          << verb << said.error;
      // Both ends turn by the same, and rounding says which is named first.
      EXPECT_TRUE(said.error.find("which moves root rz 1, tip rz -1") != std::string::npos ||
                  said.error.find("which moves tip rz 1, root rz -1") != std::string::npos)
          << verb << said.error;
      EXPECT_EQ(std::count(said.error.begin(), said.error.end(), '\n'), 1) << said.error;
      if (as_json) {
        EXPECT_EQ(Json::parse(said.output)["stable"], false) << verb;
      }
    }
  }
  const auto below = column("loads: [{node: tip, force: [-7, 0]}]\n" + signals);
  for (const char* verb : {"equilibrium", "linearise", "sigma"}) {
    EXPECT_EQ(json({verb, below})["stable"], true) << verb;
  }
}

/// A shaft, twisted by a torque that stays fixed in space, or pushed by a force that follows.
TEST_F(BucklingVerb, ReasonOfAStiffnessThatIsNotSymmetricIsTheLoadThatMakesItSo) {
  const auto scene = [&](const std::string& load) {
    return write("shaft.yaml", R"(title: A shaft
nodes: {p: {position: [0, 0, 0]}, q: {position: [1, 0, 0]}}
masses: [{node: q, mass: 1, inertia: [0.1, 0.1, 0.1]}]
elements:
  b: {type: beam, nodes: [p, q], orientation: y, EA: 1e6, GJ: 100, EI_y: 100, EI_z: 100,
    mass_per_length: 0.5, inertia_per_length: 0.001, second_order: true}
supports: [{nodes: [p], fix: [x, y, z, rotation]}]
dofs: [{deformations: b}]
loads: [{node: q, )" + load + "}]\n");
  };
  const std::string dead = "as a torque keeps its direction while its node turns",
                    follows = "as a load follows its node";
  for (const auto& [load, reason] :
       {std::pair{"torque: [1, 0.2, 0]", dead}, {"force: [0, 1, 0], follows: true", follows}}) {
    const std::string page = run({"modes", scene(load)}).output;
    EXPECT_NE(page.find("No natural frequencies: the stiffness is not symmetric, " + reason + "\n"),
              std::string::npos)
        << page;
    expect_refused({"buckling", scene(load)}, 3, "is not symmetric, " + reason + ":");
  }
}

}  // namespace
}  // namespace stillframe::test

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "core/errors/input_error.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/numerics/worst.hpp"
#include "tests/plant_sim/motion_rig.hpp"

// What a run starts from: the scene's operating point, whose prescribed motion goes on in it.
namespace stillframe::test {
namespace {

class OperatingPoint : public testing::TestWithParam<PlantMethod> {};

constexpr double tolerance = 1e-8;
constexpr double promised = 30 * tolerance;  // docs/scene.md, simulation

Scene mass_on_a_table(const std::string& operating_point, const std::string& prescribed,
                      const std::string& dof, PlantMethod method) {
  return with_method(parse_scene(R"(
title: A mass on a table, along one line
operating_point: )" + operating_point +
                                     R"(
nodes:
  table: {position: [0, 0, 0]}
  mass: {position: [0.4, 0, 0]}
masses:
  - {node: mass, mass: 10}
elements:
  leg: {type: truss, nodes: [table, mass], stiffness: 4e3}
supports:
  - {nodes: [table, mass], fix: [y, z]}
prescribed:
  - {nodes: [table], move: [x], )" + prescribed +
                                     R"(}
dofs:
  - {element: leg, )" + dof + R"(}
inputs:
  - {name: floor, acceleration: table, along: x}
outputs:
  - {name: mass, acceleration: mass, along: x}
controller: {legs: [leg], target_hz: 1, damping_ratio: 0.7, sample_rate_hz: 1000, delay_samples: 1, leak_hz: 0.05}
)",
                                 "table.yaml"),
                     method, tolerance);
}

TEST_P(OperatingPoint, WithAPrescribedValueIsAtRestOnAStillFloor) {
  const Scene scene = mass_on_a_table("equilibrium", "value: 0.001", "mode: 1", GetParam());
  const Eigen::MatrixXd none = Eigen::MatrixXd::Zero(1, 100);
  EXPECT_LT(worst_of(trajectory(scene, none, none)), 1e-12);
}

TEST_P(OperatingPoint, AsWrittenIsWhereARunBegins) {
  // The table leaves at 0.3 m/s, 0.5 m/s^2, and the floor adds 0.2 m/s^2: what the leg does is
  //   m (e'' + a) = -k e,   a = 0.7 m/s^2,
  // about e_0 = -m a / k, from e = 0.01 m, e' = 0.2 m/s. Forces count from that of the start.
  if (GetParam() == PlantMethod::linear) GTEST_SKIP() << "about rest alone";
  const Scene scene = mass_on_a_table("as_written", "value: 0.02, rate: 0.3, acceleration: 0.5",
                                      "value: 0.01, rate: 0.2", GetParam());
  const Index n = 300;
  const auto found =
      trajectory(scene, Eigen::MatrixXd::Zero(1, n), Eigen::MatrixXd::Constant(1, n, 0.2));
  const double w = 20, T = 1e-3, a = 0.7, e_0 = -a / (w * w);
  const auto e = [&](double t) {
    return e_0 + (0.01 - e_0) * std::cos(w * t) + 0.2 / w * std::sin(w * t);
  };
  const auto v = [&](double t) {
    return 0.3 + a * t - (0.01 - e_0) * w * std::sin(w * t) + 0.2 * std::cos(w * t);
  };
  Eigen::MatrixXd exact(n, 2);
  for (Index k = 0; k < n; ++k) {
    const double t = static_cast<double>(k) * T;
    exact.row(k) << (v(t + T) - v(t)) / T, 4e3 * (e(t + T) - 0.01);
  }
  EXPECT_LT(relative(found.leftCols(1), exact.leftCols(1)), promised);
  EXPECT_LT(relative(found.rightCols(1), exact.rightCols(1)), promised);
}

Scene turning_table(PlantMethod method) {
  return with_method(parse_scene(R"(
title: A mass in two springs on a table that turns at 3 rad/s on a floor
planar: true
nodes:
  ground: {position: [0, 0]}
  table: {position: [0, 0]}
  end_x: {position: [2, 0]}
  end_y: {position: [1, 1]}
  mass: {position: [1, 0]}
masses:
  - {node: mass, mass: 1}
elements:
  axle: {type: hinge, nodes: [ground, table]}
  arm_x: {type: rigid_beam, nodes: [table, end_x]}
  arm_y: {type: rigid_beam, nodes: [table, end_y]}
  spring_x: {type: truss, nodes: [end_x, mass], stiffness: 400}
  spring_y: {type: truss, nodes: [end_y, mass], stiffness: 300, damping: 1}
supports:
  - {nodes: [ground], fix: [rotation]}
prescribed:
  - {nodes: [ground], move: [x, y]}
  - {element: axle, value: 0.3, rate: 3}
dofs:
  - {element: spring_x}
  - {element: spring_y}
inputs:
  - {name: floor_x, acceleration: ground, along: x}
  - {name: floor_y, acceleration: ground, along: y}
outputs:
  - {name: mass_x, acceleration: mass, along: x}
  - {name: mass_y, acceleration: mass, along: y}
controller: {legs: [spring_x], target_hz: 1, damping_ratio: 0.7, sample_rate_hz: 100, delay_samples: 1, leak_hz: 0.05}
)",
                                 "turning.yaml"),
                     method, tolerance);
}

TEST_P(OperatingPoint, OfATurningTableTurnsOn) {
  // In 10 s five turns: the mass goes round at the radius of the stationary motion, its springs at
  // rest on the table.
  const Scene scene = turning_table(GetParam());
  const Index n = 1000;
  const Eigen::MatrixXd still = Eigen::MatrixXd::Zero(2, n), none = Eigen::MatrixXd::Zero(1, n);
  if (GetParam() == PlantMethod::linear) {
    EXPECT_THROW(trajectory(scene, none, still), InputError);
    return;
  }
  const auto found = trajectory(scene, none, still);
  const Model model = make_model(scene);
  const NominalMotion nominal = nominal_motion(model);
  const Index mass = model.node_index("mass");
  const Eigen::Vector2d r(1 + model.translation_row(mass, Eigen::Vector3d::UnitX()) * nominal.x,
                          model.translation_row(mass, Eigen::Vector3d::UnitY()) * nominal.x);
  const double w = 3, T = 1e-2;
  Eigen::MatrixXd exact(n, 2);
  for (Index k = 0; k < n; ++k) {
    const auto velocity = [&](double t) {
      const Eigen::Vector2d at = Eigen::Rotation2Dd(w * t) * r;
      return Eigen::Vector2d(-w * at.y(), w * at.x());
    };
    const double t = static_cast<double>(k) * T;
    exact.row(k) = (velocity(t + T) - velocity(t)).transpose() / T;
  }
  EXPECT_LT(relative(found.leftCols(2), exact), promised);
  // Springs of 400 N/m that carry m w^2 r, 9 N and more.
  EXPECT_LT(worst_of(found.col(2)), 9 * promised);
}

TEST_P(OperatingPoint, OfATurningTableFeelsTheFloorFromWhereItIs) {
  // Two formulations on a floor that is shaken while the table turns.
  if (GetParam() == PlantMethod::linear) GTEST_SKIP() << "about rest alone";
  const PlantMethod other =
      GetParam() == PlantMethod::nodal ? PlantMethod::dormand_prince : PlantMethod::nodal;
  const Eigen::MatrixXd floor = noise(2, 300, 5), forces = 10 * noise(1, 300, 6);
  const auto found = trajectory(turning_table(GetParam()), forces, floor);
  Scene fine = turning_table(other);
  fine.simulation.relative_tolerance = 1e-12;
  const auto exact = trajectory(fine, forces, floor);
  EXPECT_LT(relative(found.leftCols(2), exact.leftCols(2)), promised);
  EXPECT_LT(relative(found.rightCols(1), exact.rightCols(1)), promised);
}

TEST_P(OperatingPoint, AsWrittenWindsUpASpringByManyTurns) {
  // An arm of m r^2 = 1 kg m^2 on an axle that leaves at 100 rad/s, against a torsion spring of
  // 25 N m/rad beside it, which is no dof: 20 sin(5 t) rad, more than three turns and back.
  if (GetParam() == PlantMethod::linear) GTEST_SKIP() << "about rest alone";
  const Scene scene = with_method(parse_scene(R"(
title: An arm on a spring that is wound up
operating_point: as_written
nodes:
  ground: {position: [0, 0, 0]}
  rotor: {position: [0, 0, 0]}
  tip: {position: [0.5, 0, 0]}
  table: {position: [0, 2, 0]}
  mass: {position: [0.4, 2, 0]}
masses:
  - {node: tip, mass: 4}
  - {node: mass, mass: 10}
elements:
  axle: {type: hinge, nodes: [ground, rotor], axis: z}
  spring: {type: hinge, nodes: [ground, rotor], axis: z, rigid: [], stiffness: [25, 0, 0]}
  arm: {type: rigid_beam, nodes: [rotor, tip]}
  leg: {type: truss, nodes: [table, mass], stiffness: 4e3}
supports:
  - {nodes: [ground], fix: [x, y, z, rotation]}
  - {nodes: [table, mass], fix: [y, z]}
prescribed:
  - {nodes: [table], move: [x]}
dofs:
  - {element: axle, rate: 100}
  - {element: leg}
inputs:
  - {name: floor, acceleration: table, along: x}
outputs:
  - {name: tip_x, acceleration: tip, along: x}
  - {name: tip_y, acceleration: tip, along: y}
controller: {legs: [leg], target_hz: 1, damping_ratio: 0.7, sample_rate_hz: 1000, delay_samples: 1, leak_hz: 0.05}
)",
                                              "arm.yaml"),
                                  GetParam(), tolerance);
  const Index n = 700;
  const Eigen::MatrixXd none = Eigen::MatrixXd::Zero(1, n);
  const auto found = trajectory(scene, none, none);
  const double r = 0.5, w = 5, T = 1e-3;
  const auto velocity = [&](double t) {
    const double angle = 20 * std::sin(w * t), rate = 20 * w * std::cos(w * t);
    return Eigen::RowVector2d(-r * rate * std::sin(angle), r * rate * std::cos(angle));
  };
  Eigen::MatrixXd exact(n, 2);
  for (Index k = 0; k < n; ++k) {
    const double t = static_cast<double>(k) * T;
    exact.row(k) = (velocity(t + T) - velocity(t)) / T;
  }
  EXPECT_LT(relative(found.leftCols(2), exact), promised);
}

INSTANTIATE_TEST_SUITE_P(Methods, OperatingPoint,
                         testing::Values(PlantMethod::automatic, PlantMethod::linear,
                                         PlantMethod::exponential, PlantMethod::dormand_prince,
                                         PlantMethod::nodal),
                         [](const auto& one) { return method_name(one.param); });

}  // namespace
}  // namespace stillframe::test

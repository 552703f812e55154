#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "core/mechanics/equilibrium.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "core/numerics/worst.hpp"
#include "plant_sim/nodal/nodal_motion.hpp"
#include "tests/core/joint_scenes.hpp"
#include "tests/plant_sim/nodal_reference.hpp"
#include "tests/support/allocation_count.hpp"

// Motions in nodal coordinates against those in minimal coordinates: other unknowns, other
// equations, another integrator.
namespace stillframe::nodal {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double sample_time = 1e-3;

Scene scene_of(const std::string& name) {
  return read_scene(std::filesystem::path(STILLFRAME_SOURCE_DIR) / "config/scenes" / name);
}

double uniform(std::mt19937& engine) { return 2.0 * engine() / 4294967295.0 - 1; }

struct Drive {
  double floor = 0;   ///< m/s^2, of the prescribed coordinates
  double stress = 0;  ///< N, of the dofs that are deformations
};

/// Steps through held pseudo-random inputs.
template <class Step>
void drive(const Model& model, const Drive& size, int samples, const Step& step) {
  test::HeldInputs inputs(model);
  std::mt19937 engine(7);
  for (int k = 0; k < samples; ++k) {
    for (double& a : inputs.acceleration) a = size.floor * uniform(engine);
    for (const Model::Dof& dof : model.dofs) {
      if (dof.is_deformation) inputs.sigma_a(dof.index) = size.stress * uniform(engine);
    }
    step(inputs);
    inputs.finish(sample_time);
  }
}

/// Accelerations of all nodes and all stresses at the end of each sample.
struct Trajectory {
  MatrixXd x_ddot, sigma;
  static double difference(const MatrixXd& a, const MatrixXd& b) {
    return worst_of(a - b) / worst_of(b);
  }
};

Data start_of(const Model& model, const NominalMotion& motion) {
  Data data(model);
  data.x = motion.x;
  VectorXd q_d_ddot(model.n_d);
  accelerations(model, data, motion.state, VectorXd::Zero(model.n_e), q_d_ddot);
  return data;
}

Trajectory minimal(const Model& model, const NominalMotion& start, const Drive& size, int samples,
                   int steps) {
  test::MinimalMotion motion(model, start.state, start.x);
  Trajectory result{MatrixXd(model.n_x, samples), MatrixXd(model.n_e, samples)};
  Index k = 0;
  drive(model, size, samples, [&](const test::HeldInputs& inputs) {
    motion.advance(inputs, sample_time, steps);
    result.x_ddot.col(k) = motion.data().x_ddot;
    result.sigma.col(k++) = motion.data().sigma;
  });
  return result;
}

Trajectory nodal(const Model& model, const NominalMotion& start, const Drive& size, int samples,
                 double tolerance, Index stages = 5) {
  NodalMotion motion(model, start_of(model, start), tolerance, stages);
  Trajectory result{MatrixXd(model.n_x, samples), MatrixXd(model.n_e, samples)};
  Index k = 0;
  drive(model, size, samples, [&](const test::HeldInputs& inputs) {
    ASSERT_EQ(motion.advance(inputs, sample_time), Status::ok) << k;
    result.x_ddot.col(k) = motion.x_ddot();
    result.sigma.col(k++) = motion.sigma();
  });
  return result;
}

struct Case {
  std::string scene;
  Drive size;
  int samples, steps;
};

class NodalMotions : public testing::TestWithParam<Case> {};

TEST_P(NodalMotions, AreThoseOfMinimalCoordinates) {
  const Case& c = GetParam();
  const Scene scene = scene_of(c.scene);
  const Model model = make_model(scene);
  const NominalMotion start = nominal_motion(model);
  const Trajectory fine = minimal(model, start, c.size, c.samples, 2 * c.steps);
  const Trajectory coarse = minimal(model, start, c.size, c.samples, c.steps);
  // The classical method is of order four: 15 times less is left at half the step. 1e-8 beside it
  // for the tolerance of 1e-9 over a sample.
  const double left = Trajectory::difference(coarse.x_ddot, fine.x_ddot) / 15 + 1e-8;
  ASSERT_LT(left, 1e-6);
  const Trajectory motion = nodal(model, start, c.size, c.samples, 1e-9);
  EXPECT_LT(Trajectory::difference(motion.x_ddot, fine.x_ddot), 2 * left);
  EXPECT_LT(Trajectory::difference(motion.sigma, fine.sigma), 2 * left);
}

INSTANTIATE_TEST_SUITE_P(Scenes, NodalMotions,
                         testing::Values(Case{"metrology_frame.yaml", {1e-3, 0.1}, 20, 20},
                                         Case{"frame_under_gravity.yaml", {1e-2, 1}, 10, 20},
                                         Case{"slider_crank.yaml", {20, 0}, 10, 400},
                                         Case{"free_body.yaml", {}, 20, 10},
                                         Case{"turning_table.yaml", {1, 0.1}, 20, 10}));

TEST(NodalMotion, ErrorFallsWithTheTolerance) {
  // With three stages (order 5, error estimate of order 3, so that the error falls faster than the
  // tolerance) until rounding; reference with seven stages.
  const Scene scene = scene_of("metrology_frame.yaml");
  const Model model = make_model(scene);
  const NominalMotion start = nominal_motion(model);
  const Drive size{1e-3, 0.1};
  const Trajectory fine = nodal(model, start, size, 20, 1e-12, 7);
  double last = 1;
  for (const double tolerance : {1e-2, 1e-4, 1e-6}) {
    const double error =
        Trajectory::difference(nodal(model, start, size, 20, tolerance, 3).x_ddot, fine.x_ddot);
    EXPECT_LT(error, tolerance);
    EXPECT_LT(error, 0.2 * last);
    last = error;
  }
}

TEST(NodalMotion, DoesNotKnowTheSizeOfTheMotion) {
  // Nanometres on metres of geometry: a floor of 1e-9 m/s^2 moves the frame as one of 1e-3 m/s^2
  // does, a million times less. Left are the nonlinearity, relative to the amplitude 1e-3 / omega^2
  // / 0.15 m (1e-6 at 13.9 Hz), and rounding.
  const Scene scene = scene_of("metrology_frame.yaml");
  const Model model = make_model(scene);
  const NominalMotion start = nominal_motion(model);
  const Trajectory small = nodal(model, start, {1e-9, 1e-7}, 20, 1e-8);
  const Trajectory large = nodal(model, start, {1e-6, 1e-4}, 20, 1e-8);
  EXPECT_LT(Trajectory::difference(1e3 * small.x_ddot, large.x_ddot), 1e-8);
  EXPECT_LT(Trajectory::difference(1e3 * small.sigma, large.sigma), 1e-8);
}

TEST(NodalMotion, HeldDeformationsStayHeld) {
  const Scene scene = scene_of("slider_crank.yaml");
  const Model model = make_model(scene);
  const NominalMotion start = nominal_motion(model);
  NodalMotion motion(model, start_of(model, start), 1e-6);
  Equations equations(model);
  VectorXd r(equations.size());
  drive(model, {50, 0}, 200, [&](const test::HeldInputs& inputs) {
    ASSERT_EQ(motion.advance(inputs, sample_time), Status::ok);
    NodalState state = equations.zero_state();
    equations.take_inputs(inputs, sample_time, state);
    state.x = motion.x();
    state.x_dot = motion.x_dot();
    // Rounding of positions of 1 m, and of rates of up to 100 m/s and rad/s, through a few
    // products.
    equations.position_errors(state, r);
    EXPECT_LT(worst_of(r), 1e-14);
    equations.rate_errors(state, r);
    EXPECT_LT(worst_of(r), 1e-12);
  });
}

TEST(NodalMotion, FreeMotionKeepsItsEnergy) {
  // A body that tumbles about its intermediate axis for 20 s: order 9 at the tolerance 1e-10 leaves
  // no more than 1e-9 of the energy.
  const Scene scene = scene_of("free_body.yaml");
  const Model model = make_model(scene);
  const NominalMotion start = nominal_motion(model);
  NodalMotion motion(model, start_of(model, start), 1e-10);
  Data data(model);
  const test::HeldInputs inputs(model);
  const auto energy = [&] {
    data.x = motion.x();
    data.x_dot = motion.x_dot();
    return kinetic_energy(model, data);
  };
  const double before = energy();
  for (int k = 0; k < 200; ++k) ASSERT_EQ(motion.advance(inputs, 0.1), Status::ok);
  EXPECT_NEAR(energy() / before, 1, 1e-9);
  // It has turned over: the Euler parameters are far from where they were.
  EXPECT_GT(worst_of(motion.x()), 0.5);
}

TEST(NodalMotion, RestsOnForcesThatBalanceToRounding) {
  const Scene scene = scene_of("frame_under_gravity.yaml");
  const Model model = make_model(scene);
  const NominalMotion start = nominal_motion(model);
  NodalMotion motion(model, start_of(model, start), 1e-8);
  const test::HeldInputs inputs(model);
  for (int k = 0; k < 20; ++k) ASSERT_EQ(motion.advance(inputs, sample_time), Status::ok);
  EXPECT_LE(motion.steps(), 40);  // rounding is no reason for small steps
  // Rounding of 2.5 kN on 250 kg each.
  EXPECT_LT(worst_of(motion.x_ddot()), 1e-11);
}

TEST(NodalMotion, TheSameInputsGiveTheSameBits) {
  const Scene scene = scene_of("metrology_frame.yaml");
  const Model model = make_model(scene);
  const NominalMotion start = nominal_motion(model);
  const Trajectory a = nodal(model, start, {1e-3, 1}, 20, 1e-6);
  const Trajectory b = nodal(model, start, {1e-3, 1}, 20, 1e-6);
  EXPECT_EQ(a.x_ddot, b.x_ddot);
  EXPECT_EQ(a.sigma, b.sigma);
}

TEST(NodalMotion, LowPassesSeeTheMotionWithinTheSteps) {
  // The filtered stresses of the legs against the exponential of the filter with Simpson's rule
  // over 32 parts of each sample, for corners below and above the sample rate (omega h below and
  // above the 2 at which the moments change their form).
  const Scene scene = scene_of("metrology_frame.yaml");
  const Model model = make_model(scene);
  const NominalMotion start = nominal_motion(model);
  std::vector<Index> rows;
  for (const Model::Dof& dof : model.dofs) rows.push_back(dof.index);
  for (const double rate : {300.0, 5000.0}) {
    NodalMotion motion(model, start_of(model, start), 1e-8);
    motion.filter(rows, rate);
    test::MinimalMotion fine(model, start.state, start.x);
    VectorXd expected = VectorXd::Zero(model.n_d), elastic = expected;
    drive(model, {1e-3, 0.1}, 10, [&](const test::HeldInputs& inputs) {
      ASSERT_EQ(motion.advance(inputs, sample_time), Status::ok);
      constexpr int parts = 32;
      const double h = sample_time / parts;
      test::HeldInputs within = inputs;
      const auto stresses = [&] {
        VectorXd values(model.n_d);
        for (Index i = 0; i < model.n_d; ++i) {
          const Index row = rows[static_cast<size_t>(i)];
          values(i) = fine.data().sigma(row) - inputs.sigma_a(row);
        }
        return values;
      };
      for (int part = 0; part < parts; ++part) {
        const VectorXd before = elastic;
        fine.advance(within, h / 2, 2);
        within.finish(h / 2);
        const VectorXd middle = stresses();
        fine.advance(within, h / 2, 2);
        within.finish(h / 2);
        elastic = stresses();
        expected =
            std::exp(-rate * h) * expected +
            rate * h / 6 *
                (std::exp(-rate * h) * before + 4 * std::exp(-rate * h / 2) * middle + elastic);
      }
      // Simpson's rule leaves (omega h)^4 / 2880: 2e-7 at the higher corner.
      EXPECT_LT((motion.filtered() - expected).norm(), 1e-6 * expected.norm()) << rate;
    });
  }
}

TEST(NodalMotion, DoesNotAllocate) {
  // By collocation, with and without filters; not in the first part.
  const Scene scene = scene_of("metrology_frame.yaml");
  const Model model = make_model(scene);
  const NominalMotion start = nominal_motion(model);
  for (const bool filters : {false, true}) {
    NodalMotion motion(model, start_of(model, start), 1e-8);
    if (filters) motion.filter({model.deformation_row("leg_1t")}, 300);
    int k = 0;
    drive(model, {1e-3, 0.1}, 20, [&](const test::HeldInputs& inputs) {
      const auto before = test::allocation_count();
      const Status status = motion.advance(inputs, sample_time);
      const auto allocated = test::allocation_count() - before;
      EXPECT_EQ(status, Status::ok);
      if (k++ > 0) {
        EXPECT_EQ(allocated, 0) << k;
      }
    });
  }
}

TEST(NodalMotion, TakesForcesAtNodes) {
  // A force on a free body of 2 kg: constant acceleration in every method, exactly.
  const Scene scene = scene_of("free_body.yaml");
  const Model model = make_model(scene);
  NodalMotion motion(model, Data(model), 1e-8);
  test::HeldInputs inputs(model);
  inputs.force = 3 * model.translation_row(0, Eigen::Vector3d::UnitY()).transpose();
  ASSERT_EQ(motion.advance(inputs, 0.5), Status::ok);
  EXPECT_NEAR(model.translation_row(0, Eigen::Vector3d::UnitY()).dot(motion.x()), 0.1875, 1e-14);
  EXPECT_NEAR(model.translation_row(0, Eigen::Vector3d::UnitY()).dot(motion.x_dot()), 0.75, 1e-14);
}

TEST(NodalMotion, CountsTheTurnsOfAnElasticHinge) {
  // A torsion spring of 0.5 N m/rad, wound up by more than the 4 pi after which the Euler
  // parameters of its nodes repeat.
  Scene scene = test::hinge_chain(1, false);
  scene.elements.front().stiffness(0, 0) = 0.5;
  const Model model = make_model(scene);
  NominalMotion start(model);
  start.state.q_d_dot(0) = 60;
  test::MinimalMotion minimal(model, start.state, start.x);
  NodalMotion motion(model, start_of(model, start), 1e-10);
  const test::HeldInputs inputs(model);
  double most = 0;
  for (int k = 0; k < 60; ++k) {
    minimal.advance(inputs, 0.01, 40);
    ASSERT_EQ(motion.advance(inputs, 0.01), Status::ok);
    most = std::max(most, motion.sigma()(model.deformation_row("hinge_1")));
    // The classical method leaves (60 rad/s 0.25 ms)^4 / 120 a step.
    EXPECT_LT((motion.sigma() - minimal.data().sigma).norm(), 1e-6 * minimal.data().sigma.norm());
  }
  EXPECT_GT(most, 0.5 * 5 * 3.14);
}

TEST(NodalMotion, SaysThatAPositionCannotBeReached) {
  // A mass on a rigid rod of 1 m, drawn by a rope whose length is prescribed: beyond 2.2 m from the
  // other post there is no such place.
  const Scene scene = parse_scene(R"(
title: Out of reach
planar: true
nodes:
  post: {position: [0, 0]}
  other: {position: [1.2, 0]}
  mass: {position: [0.6, 0.8]}
  bob: {position: [0, 2]}
masses:
  - {node: mass, mass: 1}
  - {node: bob, mass: 1}
elements:
  rod: {type: truss, nodes: [post, mass], rigid: true}
  rope: {type: truss, nodes: [other, mass], stiffness: 1}
  spring: {type: truss, nodes: [post, bob], stiffness: 100}
supports:
  - {nodes: [post, other], fix: [x, y]}
  - {nodes: [bob], fix: [x]}
prescribed:
  - {element: rope}
dofs:
  - {element: spring}
inputs:
  - {name: pull, deformation_acceleration: rope}
outputs:
  - {name: bob, acceleration: bob, along: y}
)",
                                  "out of reach");
  const Model model = make_model(scene);
  NodalMotion motion(model, Data(model), 1e-6);
  test::HeldInputs inputs(model);
  inputs.rate(0) = 0.5;
  VectorXd last = motion.x();
  int k = 0;
  auto status = Status::ok;
  for (; k < 400 && status == Status::ok; ++k) {
    last = motion.x();
    status = motion.advance(inputs, 0.01);
    inputs.finish(0.01);
  }
  EXPECT_NE(status, Status::ok);
  // From 1 m to 2.2 m at 0.5 m/s takes 2.4 s; not a part later.
  EXPECT_LE(k, 241);
  EXPECT_GT(k, 238);
  EXPECT_EQ(motion.x(), last);  // as it was before the part that failed
}

TEST(NodalMotion, CostOfAChainGrowsLikeItsLength) {
  // Ten times the beams: ten times the unknowns in a band of the same width.
  const auto chain = [](int n) {
    return parse_scene(R"(
title: Chain
planar: true
nodes:
  root: {position: [0, 0]}
  tip: {position: [1, 0]}
masses: []
elements:
  beam: {type: beam, nodes: [root, tip], EA: 4e6, EI: 40, mass_per_length: 1, damping_time: 1e-6, divide: )" +
                           std::to_string(n) + R"(}
supports:
  - {nodes: [root], fix: [x, y, rotation]}
inputs:
  - {name: push, force: tip, along: y}
outputs:
  - {name: tip, position: tip, along: y}
dofs: auto
)",
                       "chain");
  };
  const Model short_chain = make_model(chain(10)), long_chain = make_model(chain(100));
  const Equations few(short_chain), many(long_chain);
  EXPECT_EQ(few.size(), 30);
  EXPECT_EQ(many.size(), 300);
  EXPECT_EQ(few.half_bandwidth(), many.half_bandwidth());
  EXPECT_LE(many.half_bandwidth(), 5);  // six unknowns meet in a beam
}

}  // namespace
}  // namespace stillframe::nodal

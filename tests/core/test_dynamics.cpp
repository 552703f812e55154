#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <iostream>

#include "core/mechanics/dynamics.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "core/numerics/worst.hpp"
#include "tests/core/differences.hpp"
#include "tests/core/newton_euler.hpp"
#include "tests/core/scenes.hpp"

namespace stillframe::test {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Integrates q^d, its rate and the dissipated energy with the classical Runge-Kutta method, floor
/// at rest.
class Motion {
 public:
  Motion(const Model& model, const VectorXd& q_d, const VectorXd& q_d_dot)
      : model_(model), data_(model), state_(model), y_(2 * model.n_d + 1) {
    y_ << q_d, q_d_dot, 0.0;
  }

  void run(double h, int steps) {
    for (int k = 0; k < steps; ++k) {
      const VectorXd k1 = rate(y_), k2 = rate(y_ + 0.5 * h * k1), k3 = rate(y_ + 0.5 * h * k2),
                     k4 = rate(y_ + h * k3);
      y_ += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    }
    rate(y_);
  }
  /// Kinetic and potential energy and what the dampers took.
  double energy() {
    rate(y_);
    return kinetic_energy(model_, data_) + potential_energy(model_, data_) + y_(2 * model_.n_d);
  }
  double kinetic() {
    rate(y_);
    return kinetic_energy(model_, data_);
  }
  double dissipated() const { return y_(2 * model_.n_d); }
  const Data& data() const { return data_; }

 private:
  /// sum of e'^T S_d e' over the elements.
  double dissipated_power() const {
    double power = 0;
    for (const ModelElement& item : model_.elements) {
      for (Index i = 0; i < item.S_d.rows(); ++i) {
        for (Index j = 0; j < item.S_d.cols(); ++j) {
          power += data_.e_dot(item.row[static_cast<size_t>(i)]) * item.S_d(i, j) *
                   data_.e_dot(item.row[static_cast<size_t>(j)]);
        }
      }
    }
    return power;
  }

  VectorXd rate(const VectorXd& y) {
    const Index n = model_.n_d;
    state_.q_d = y.head(n);
    state_.q_d_dot = y.segment(n, n);
    VectorXd q_d_ddot(n);
    EXPECT_EQ(accelerations(model_, data_, state_, VectorXd::Zero(model_.n_e), q_d_ddot),
              DynamicsStatus::ok);
    VectorXd result(2 * n + 1);
    result << state_.q_d_dot, q_d_ddot, dissipated_power();
    return result;
  }

  const Model& model_;
  Data data_;
  MotionState state_;
  VectorXd y_;
};

/// Change of the total energy over 0.05 s, for steps h.
double energy_change(const Model& model, const VectorXd& q, const VectorXd& q_dot, double h) {
  Motion motion(model, q, q_dot);
  const double start = motion.energy();
  motion.run(h, static_cast<int>(std::lround(0.05 / h)));
  return std::abs(motion.energy() - start);
}

TEST(Energy, IsConservedByTheFreeFrameAtLargeAmplitude) {
  const Model model = make_model(frame_scene());
  std::mt19937 engine(1);
  const VectorXd q = 5e-3 * random_vector(6, engine), q_dot = 0.5 * random_vector(6, engine);
  Motion start(model, q, q_dot);
  const double energy = start.energy(), coarse = energy_change(model, q, q_dot, 4e-4),
               fine = energy_change(model, q, q_dot, 2e-4);
  std::cout << "energy " << energy << " J, change " << coarse << " and " << fine
            << " J at half the step\n";
  // The method takes (omega h)^6 / 72 of an oscillation's energy at each step: 8.6e-9 of it over
  // 125 steps at 49 Hz and 4e-4 s if all of it stood there. A nonlinear motion has harmonics, hence
  // the factor 10.
  const double omega_h = 2 * M_PI * 49.0 * 4e-4;
  EXPECT_LE(coarse, 10 * energy * 125 * std::pow(omega_h, 6) / 72);
  // Half the step: the change falls by 2^5 (the loss) or 2^4 (the oscillating part). An error of
  // the equations would not fall at all.
  EXPECT_LE(fine, coarse / 12);
}

TEST(Energy, BalanceHoldsWithDampersPreloadAndLoads) {
  const Model model = make_model(preloaded_frame());
  std::mt19937 engine(1);
  const VectorXd q = 5e-3 * random_vector(6, engine), q_dot = 0.5 * random_vector(6, engine);
  Motion start(model, q, q_dot);
  start.run(2e-4, 250);
  EXPECT_GT(start.dissipated(), 1.0);  // J: so the balance below is about something
  // At coarser steps the two parts of the error, of order h^4 and h^5, still cancel in part.
  const double coarse = energy_change(model, q, q_dot, 1e-4),
               fine = energy_change(model, q, q_dot, 5e-5);
  std::cout << "change " << coarse << " and " << fine << " J at half the step\n";
  EXPECT_LE(coarse, 1e-7 * start.dissipated());
  EXPECT_LE(fine, coarse / 12);  // as above
}

struct NamedFrame {
  const char* name;
  Scene scene;
  double size;  ///< of the dofs, m and 1
};

void PrintTo(const NamedFrame& frame, std::ostream* out) { *out << frame.name; }

class RigidBody : public testing::TestWithParam<NamedFrame> {};

TEST_P(RigidBody, AccelerationsAreThoseOfNewtonAndEuler) {
  const Scene& scene = GetParam().scene;
  const Model model = make_model(scene);
  Data data(model);
  std::mt19937 engine(9);
  VectorXd q_d_ddot(6);
  double worst = 0;
  for (int k = 0; k < 20; ++k) {
    // Floor nodes shifted, moving and accelerating in all directions; every element pushed.
    const MotionState state = random_motion(model, GetParam().size, 0.5, engine);
    VectorXd sigma_a = VectorXd::Zero(model.n_e);
    for (const SceneElement& element : scene.elements) {
      if (!element.rigid())
        sigma_a(model.deformation_row(element.name)) = 300 * random_vector(1, engine)(0);
    }
    ASSERT_EQ(accelerations(model, data, state, sigma_a, q_d_ddot), DynamicsStatus::ok);
    const RigidAcceleration expected =
        newton_euler(scene, model, data, sigma_a, rigid_state(scene, model, data));
    const RigidAcceleration found = rigid_acceleration(scene, model, data);
    worst = worst_of({worst, relative_error(found.linear, expected.linear),
                      relative_error(found.angular, expected.angular)});
  }
  std::cout << GetParam().name << ": worst relative error " << worst << "\n";
  // Some hundred operations, a mass matrix of condition 100.
  EXPECT_LE(worst, 1e-10);
}

INSTANTIATE_TEST_SUITE_P(
    Frames, RigidBody,
    testing::Values(NamedFrame{"by_elongations", frame_scene(), 5e-3},
                    NamedFrame{"by_lens", by_lens_coordinates(frame_scene()), 0.1},
                    NamedFrame{"preloaded", preloaded_frame(), 5e-3},
                    NamedFrame{"preloaded_by_lens", by_lens_coordinates(preloaded_frame()), 0.1}),
    [](const auto& param) { return std::string(param.param.name); });

TEST(FreeBody, ObeysEulersEquationsAtAnyRotation) {
  const Scene scene = free_body();
  const Model model = make_model(scene);
  Data data(model);
  std::mt19937 engine(4);
  VectorXd q_d_ddot(6);
  for (int k = 0; k < 20; ++k) {
    const MotionState state = random_motion(model, 0.5, 3.0, engine);
    ASSERT_EQ(accelerations(model, data, state, VectorXd::Zero(model.n_e), q_d_ddot),
              DynamicsStatus::ok);
    const Vector3d omega = rigid_state(scene, model, data).omega;
    const Matrix3d& J = scene.masses.front().inertia;
    const Vector3d expected = J.inverse() * -omega.cross(J * omega);
    const RigidAcceleration found = rigid_acceleration(scene, model, data);
    EXPECT_LE((found.angular - expected).norm(), 1e-12 * omega.squaredNorm());
    EXPECT_LE(found.linear.norm(), 1e-13 * omega.squaredNorm());
  }
}

/// Euler's equations alone, in body axes, with small steps.
Vector3d tumble(const Matrix3d& J, Vector3d omega, double h, int steps) {
  const auto rate = [&](const Vector3d& w) -> Vector3d { return J.inverse() * -w.cross(J * w); };
  for (int k = 0; k < steps; ++k) {
    const Vector3d k1 = rate(omega), k2 = rate(omega + 0.5 * h * k1),
                   k3 = rate(omega + 0.5 * h * k2), k4 = rate(omega + h * k3);
    omega += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }
  return omega;
}

TEST(FreeBody, TumblesLikeEulersEquationsAndKeepsMomentumAndEnergy) {
  const Scene scene = free_body();
  const Model model = make_model(scene);
  const Matrix3d J = scene.masses.front().inertia;
  const Eigen::SelfAdjointEigenSolver<Matrix3d> axes(J);
  // About the intermediate axis, a little off, at 3 rad/s for 0.8 s: half a turn is where lambda_0
  // becomes zero.
  const Vector3d omega = 3.0 * (axes.eigenvectors().col(1) + 0.1 * axes.eigenvectors().col(0));
  VectorXd q_dot(6);
  q_dot << 0.1, 0.2, -0.3, 0.5 * omega;  // lambda' = omega / 2 at lambda = (1, 0, 0, 0)
  const int steps = 800;
  const double h = 1e-3;
  Motion motion(model, VectorXd::Zero(6), q_dot);
  const double energy = motion.kinetic();
  EXPECT_NEAR(energy, 0.5 * 3.0 * 0.14 + 0.5 * omega.dot(J * omega), 1e-13 * energy);
  motion.run(h, steps);
  const RigidState end = rigid_state(scene, model, motion.data());
  // Error of the method: (omega h)^4 * omega t = 2e-10 with constants below one; the two share no
  // error.
  const double tolerance = 1e-9;
  EXPECT_LE((end.omega - tumble(J, omega, h, steps)).norm(), tolerance * omega.norm());
  EXPECT_LE((end.R * J * end.omega - J * omega).norm(), tolerance * (J * omega).norm());
  EXPECT_NEAR(motion.kinetic(), energy, tolerance * energy);
  EXPECT_LE((end.v - q_dot.head<3>()).norm(), 1e-13);
}

/// M_dd column by column: what the inertias answer to unit accelerations at rest, and the power of
/// that on unit velocities.
MatrixXd mass_by_unit_accelerations(const Model& model, const Data& data) {
  MatrixXd M = MatrixXd::Zero(model.n_d, model.n_d);
  LocalVector u, a, v;
  for (const ModelInertia& item : model.inertias) {
    gather(item.parts, data.x, u);
    LocalVector F(u.size());
    for (Index i = 0; i < model.n_d; ++i) {
      gather(item.parts, data.DF.col(i), a);
      item.inertia->force(u, LocalVector::Zero(u.size()), a, Vector3d::Zero(), F);
      for (Index j = 0; j < model.n_d; ++j) {
        gather(item.parts, data.DF.col(j), v);
        M(j, i) += v.dot(F);
      }
    }
  }
  return M;
}

TEST(Mass, KineticEnergyIsTheQuadraticFormOfTheMassMatrix) {
  for (const Scene& scene : {preloaded_frame(), by_lens_coordinates(frame_scene()), mechanism()}) {
    const Model model = make_model(scene);
    Data data(model);
    std::mt19937 engine(6);
    MotionState state = random_motion(model, 5e-3, 1.0, engine);
    state.q_r_dot.setZero();
    VectorXd q_d_ddot(model.n_d);
    ASSERT_EQ(accelerations(model, data, state, VectorXd::Zero(model.n_e), q_d_ddot),
              DynamicsStatus::ok);
    // It is the mass matrix itself that accelerations() leaves.
    const double form = 0.5 * state.q_d_dot.dot(data.M_dd * state.q_d_dot);
    EXPECT_NEAR(kinetic_energy(model, data), form, 1e-13 * form);
    EXPECT_LE((data.M_dd - data.M_dd.transpose()).norm(), 1e-15 * data.M_dd.norm());
    EXPECT_LE(relative_error(mass_by_unit_accelerations(model, data), data.M_dd), 1e-14);
  }
}

/// A force that whoever moves the model adds is carried by the supports like one of the scene.
TEST(Reactions, CarryTheForcesFromOutside) {
  const Scene scene = mechanism();
  Scene loaded = scene;
  const std::string node = scene.loads.front().node;
  const Vector3d force(3, -5, 7);
  loaded.loads.push_back(force_at(node, force));
  const Model model = make_model(scene), with_load = make_model(loaded);
  std::mt19937 engine(7);
  const MotionState state = random_motion(model, 5e-3, 1.0, engine);
  Data data(model), expected(with_load);
  VectorXd external = VectorXd::Zero(model.n_x), q_d_ddot(model.n_d);
  for (int i = 0; i < 3; ++i) {
    external +=
        force(i) * model.translation_row(model.node_index(node), Vector3d::Unit(i)).transpose();
  }
  data.external = &external;
  const VectorXd sigma_a = VectorXd::Zero(model.n_e);
  ASSERT_EQ(accelerations(model, data, state, sigma_a, q_d_ddot), DynamicsStatus::ok);
  ASSERT_EQ(accelerations(with_load, expected, state, sigma_a, q_d_ddot), DynamicsStatus::ok);
  reaction_stresses(model, data);
  reaction_stresses(with_load, expected);
  EXPECT_LE(relative_error(data.sigma, expected.sigma), 1e-13);
  // What a load of the scene puts on fixed coordinates goes straight to the support.
  const VectorXd straight = with_load.fixed_load - model.fixed_load;
  EXPECT_LE(relative_error(constraint_forces(model, data).tail(model.n_0),
                           constraint_forces(with_load, expected).tail(model.n_0) + straight),
            1e-13);
}

/// A torsion spring beside a motor: its angle goes on after a turn of 2 pi, at which the Euler
/// parameters of its nodes change sign.
TEST(Hinges, ARedundantOneGoesOnCountingItsTurns) {
  const auto scene = [](double angle) {
    return parse_scene(R"(title: Motor and spring
nodes: {ground: {position: [0, 0, 0]}, rotor: {position: [0, 0, 0]}, weight: {position: [1, 0, 0]}}
masses: [{node: weight, mass: 1}]
elements:
  motor: {type: hinge, nodes: [ground, rotor], axis: z}
  spring: {type: hinge, nodes: [ground, rotor], axis: z, rigid: [], stiffness: [0.5, 0, 0]}
  arm: {type: truss, nodes: [rotor, weight], stiffness: 100}
supports: [{nodes: [ground], fix: [x, y, z, rotation]}, {nodes: [weight], fix: [y, z]}]
prescribed: [{element: motor, value: )" +
                           std::to_string(angle) + R"(}]
dofs: [{element: arm}]
outputs: [{name: torque, stress: motor}, {name: turn, deformation: spring}]
)",
                       "scene");
  };
  for (const double angle : {1.0, 6.0, 7.0, 13.0, -20.0, 100.0}) {
    const Scene turned = scene(angle);
    const LinearModel m = linearise(make_model(turned), turned.inputs, turned.outputs);
    EXPECT_NEAR(m.y_0(1), angle, 1e-12) << angle;
    EXPECT_NEAR(m.y_0(0), -0.5 * angle, 1e-12) << angle;
  }
}

TEST(Mass, ADofWithoutMassIsAnsweredAsSingular) {
  Scene scene = strung_mass(10);
  scene.masses.front().mass = 0;
  const Model model = make_model(scene);
  Data data(model);
  VectorXd q_d_ddot(3);
  EXPECT_EQ(accelerations(model, data, MotionState(model), VectorXd::Zero(model.n_e), q_d_ddot),
            DynamicsStatus::mass_matrix_singular);
}

}  // namespace
}  // namespace stillframe::test

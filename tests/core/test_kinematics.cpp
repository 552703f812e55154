#include <gtest/gtest.h>

#include <cmath>

#include "core/mechanics/dynamics.hpp"
#include "core/mechanics/elements/rotation.hpp"
#include "core/mechanics/kinematics.hpp"
#include "core/numerics/worst.hpp"
#include "tests/core/differences.hpp"
#include "tests/core/joint_scenes.hpp"
#include "tests/core/scenes.hpp"
#include "tests/support/allocation_count.hpp"

namespace stillframe::test {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

struct NamedScene {
  const char* name;
  Scene (*scene)();
  double size;  ///< of the dofs in the large-motion tests: m, or radians for the mechanism and the
                ///< lens
};

Scene frame_by_lens() { return by_lens_coordinates(frame_scene()); }
Scene driven_chain() { return hinge_chain(3, true); }
Scene preloaded_by_lens() { return by_lens_coordinates(preloaded_frame()); }

class Kinematics : public testing::TestWithParam<NamedScene> {
 protected:
  Model model_ = make_model(GetParam().scene());
  Data data_{model_};
  std::mt19937 engine_{5};

  MotionState large_motion() { return random_motion(model_, GetParam().size, 1.0, engine_); }

  VectorXd positions(const VectorXd& q_d, const VectorXd& q_r) {
    MotionState state = position_state(model_, q_d);
    state.q_r = q_r;
    EXPECT_TRUE(solve_positions(model_, data_, state));
    return data_.x;
  }
};

/// Position of a node in the world, from the displacements in data.
Eigen::Vector3d place_of(const Model& model, const VectorXd& x, const std::string& name) {
  const Index node = model.node_index(name);
  Eigen::Vector3d place = model.nodes[static_cast<size_t>(node)].position;
  for (int i = 0; i < 3; ++i)
    place(i) += model.translation_row(node, Eigen::Vector3d::Unit(i)).dot(x);
  return place;
}

TEST_P(Kinematics, SolvedPositionsMeetEveryCondition) {
  for (const double size : {1e-12, 1e-6, 1e-3, GetParam().size}) {
    for (int k = 0; k < 10; ++k) {
      const MotionState state = random_motion(model_, size, 0, engine_);
      ASSERT_TRUE(solve_positions(model_, data_, state)) << size;
      assemble(model_, data_);
      VectorXd wanted = VectorXd::Zero(model_.n_c);
      for (Index i = 0; i < model_.n_d; ++i) {
        const Model::Dof& dof = model_.dofs[static_cast<size_t>(i)];
        if (dof.is_deformation) {
          wanted(dof.index) = state.q_d(i);
        } else {
          EXPECT_EQ(data_.x(dof.index), state.q_d(i));
        }
      }
      EXPECT_EQ(data_.x.tail(model_.n_rx), state.q_r.head(model_.n_rx));
      for (size_t i = 0; i < model_.prescribed_rows.size(); ++i) {
        wanted(model_.prescribed_rows[i]) = state.q_r(model_.n_rx + static_cast<Index>(i));
      }
      // Relative to the displacements: small motions keep their digits too. Some ten terms of 1e-16
      // each.
      EXPECT_LE(worst_of(data_.e.head(model_.n_c) - wanted), 4e-15 * worst_of(data_.x)) << size;
    }
  }
}

TEST_P(Kinematics, ComesBackToTheSceneAsWritten) {
  // The solution is exactly zero, so that no rounding relative to it ever ends the iteration.
  const MotionState away = large_motion(), home(model_);
  ASSERT_TRUE(solve_positions(model_, data_, away));
  ASSERT_TRUE(solve_positions(model_, data_, home));
  EXPECT_LE(worst_of(data_.x), 1e-29);
}

TEST_P(Kinematics, TransferFunctionsAreTheDerivativesOfPositions) {
  for (int k = 0; k < 3; ++k) {
    const MotionState state = large_motion();
    positions(state.q_d, state.q_r);
    geometric_transfer_functions(model_, data_);
    const MatrixXd DF = data_.DF, DF_e = data_.DF_e;
    const MatrixXd DF_r =
        prescribed_transfer_functions(model_, data_, MatrixXd::Identity(model_.n_r, model_.n_r));
    MatrixXd expected(model_.n_x, model_.n_d), expected_e(model_.n_redundant, model_.n_d);
    // The extrapolated error is of the order of (h / 0.15 m)^8 and the rounding 1e-16 / h.
    const double h = 3e-3, tolerance = 1e-10;
    for (Index i = 0; i < model_.n_d; ++i) {
      const auto both = derivative(
          [&](double t) {
            VectorXd all(model_.n_x + model_.n_redundant);
            all << positions(state.q_d + t * VectorXd::Unit(model_.n_d, i), state.q_r),
                data_.e.tail(model_.n_redundant);
            return all;
          },
          h);
      expected.col(i) = both.head(model_.n_x);
      expected_e.col(i) = both.tail(model_.n_redundant);
    }
    EXPECT_LE(relative_error(DF, expected), tolerance);
    if (model_.n_redundant > 0) {
      EXPECT_LE(relative_error(DF_e, expected_e), tolerance);
    }
    for (Index j = 0; j < model_.n_r; ++j) {
      const VectorXd column = derivative(
          [&](double t) {
            return positions(state.q_d, state.q_r + t * VectorXd::Unit(model_.n_r, j));
          },
          h);
      EXPECT_LE(relative_error(DF_r.col(j), column), tolerance) << j;
    }
  }
}

TEST_P(Kinematics, RatesAreTheDerivativesOfPositionsInTime) {
  for (int k = 0; k < 3; ++k) {
    const MotionState s = large_motion();
    positions(s.q_d, s.q_r);
    geometric_transfer_functions(model_, data_);
    velocities(model_, data_, s);
    const VectorXd x_dot = data_.x_dot, x_ddot_0 = data_.x_ddot_0, e_dot = data_.e_dot;
    const auto motion = [&](double t) -> VectorXd {
      VectorXd all(model_.n_x + model_.n_e);
      all << positions(s.q_d + t * s.q_d_dot, s.q_r + t * s.q_r_dot + 0.5 * t * t * s.q_r_ddot),
          data_.e;
      return all;
    };
    // Steps in s, at rates of 1 m/s and 10 m/s^2; the second difference has a rounding of 1e-14 /
    // h^2.
    const VectorXd first = derivative(motion, 3e-3), second = second_derivative(motion, 1e-2);
    EXPECT_LE(relative_error(x_dot, first.head(model_.n_x)), 1e-10);
    EXPECT_LE(worst_of(e_dot - first.tail(model_.n_e)), 1e-10 * worst_of(x_dot));
    EXPECT_LE(relative_error(x_ddot_0, second.head(model_.n_x)), 1e-8);
  }
}

TEST_P(Kinematics, AccelerationsDoNotAllocate) {
  MotionState state = random_motion(model_, 0.1 * GetParam().size, 1, engine_);
  const VectorXd sigma_a = VectorXd::Zero(model_.n_e);
  VectorXd q_d_ddot(model_.n_d);
  const auto before = allocation_count();
  auto status = accelerations(model_, data_, state, sigma_a, q_d_ddot);
  for (int k = 0; k < 20 && status == DynamicsStatus::ok; ++k) {
    state.q_d *= -0.9;
    status = accelerations(model_, data_, state, sigma_a, q_d_ddot);
  }
  const auto after = allocation_count();
  EXPECT_EQ(status, DynamicsStatus::ok);
  EXPECT_EQ(after, before);
  VectorXd another(model_.n_d);
  EXPECT_GT(allocation_count(), after);  // the counter does count
}

INSTANTIATE_TEST_SUITE_P(Scenes, Kinematics,
                         testing::Values(NamedScene{"frame", frame_scene, 0.01},
                                         NamedScene{"frame_by_lens", frame_by_lens, 0.05},
                                         NamedScene{"preloaded_frame", preloaded_frame, 0.01},
                                         NamedScene{"preloaded_by_lens", preloaded_by_lens, 0.05},
                                         NamedScene{"mechanism", mechanism, 0.05},
                                         NamedScene{"driven_chain", driven_chain, 0.3},
                                         NamedScene{"spinning_rotor", spinning_rotor, 1.0},
                                         NamedScene{"slider_crank", slider_crank, 0.2},
                                         NamedScene{"four_bar", four_bar, 0.2}),
                         [](const auto& param) { return std::string(param.param.name); });

TEST(FrameKinematics, TheFrameStaysRigidAndTheLegsHaveTheirLength) {
  const Scene scene = frame_scene();
  const Model model = make_model(scene);
  Data data(model);
  std::mt19937 engine(2);
  for (int k = 0; k < 20; ++k) {
    const MotionState s = random_motion(model, 0.02, 0, engine);
    ASSERT_TRUE(solve_positions(model, data, s));
    size_t dof = 0;
    for (const SceneElement& element : scene.elements) {
      const Eigen::Vector3d now =
          place_of(model, data.x, element.node_q) - place_of(model, data.x, element.node_p);
      const Eigen::Vector3d before =
          model.nodes[static_cast<size_t>(model.node_index(element.node_q))].position -
          model.nodes[static_cast<size_t>(model.node_index(element.node_p))].position;
      const double change = element.rigid() ? 0.0 : s.q_d(static_cast<Index>(dof++));
      EXPECT_NEAR(now.norm() - before.norm(), change, 1e-15);  // a few roundings of half a metre
    }
    // Rigid arms hold their angles, too: mount to mount stays 0.6 sqrt(3) m.
    for (const auto& [a, b] : {std::pair("mount_1", "mount_2"), std::pair("mount_2", "mount_3")}) {
      EXPECT_NEAR((place_of(model, data.x, a) - place_of(model, data.x, b)).norm(),
                  0.6 * std::sqrt(3.0), 2e-15);
    }
  }
}

TEST(FrameKinematics, EveryRotationNodeOfOneBodyHasTheSameUnitEulerParameters) {
  const Model model = make_model(by_lens_coordinates(frame_scene()));
  Data data(model);
  VectorXd q = VectorXd::Zero(6);
  q.tail<3>() << 0.5, -0.3, 0.4;  // 95 degrees
  ASSERT_TRUE(solve_positions(model, data, position_state(model, q)));
  const double lambda_0 = std::sqrt(1 - q.squaredNorm());
  for (const ModelNode& node : model.nodes) {
    if (!node.has_rotation()) continue;
    EXPECT_NEAR(1 + data.x(node.rotation.column[0]), lambda_0, 1e-14) << node.name;
    for (size_t i = 1; i < 4; ++i) {
      EXPECT_NEAR(data.x(node.rotation.column[i]), q(static_cast<Index>(i) + 2), 1e-14)
          << node.name;
    }
  }
}

TEST(FrameKinematics, APicometreOfElongationMovesTheFrameByPicometres) {
  const Model model = make_model(frame_scene());
  Data data(model);
  geometric_transfer_functions(model, data);
  const MatrixXd DF = data.DF;
  for (Index i = 0; i < 6; ++i) {
    ASSERT_TRUE(solve_positions(model, data, position_state(model, 1e-12 * VectorXd::Unit(6, i))));
    // At this size the motion is linear to 1e-11, as its second order is (1e-12 m)^2 / 0.15 m.
    EXPECT_LE(relative_error(data.x / 1e-12, DF.col(i)), 2e-11);
  }
}

TEST(FrameKinematics, AnUnreachableConfigurationIsAnsweredNotInvented) {
  const Model model = make_model(mechanism());
  Data data(model);
  const VectorXd q_d = Eigen::Vector3d(0.9, 0.9, 0.9);  // no unit quaternion has these three
  EXPECT_FALSE(solve_positions(model, data, position_state(model, q_d)));
}

}  // namespace
}  // namespace stillframe::test

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>

#include "core/mechanics/condition_factors.hpp"
#include "core/mechanics/dynamics.hpp"
#include "core/numerics/worst.hpp"
#include "tests/core/differences.hpp"
#include "tests/core/joint_scenes.hpp"
#include "tests/core/scenes.hpp"

// Hinges, closed loops and prescribed deformations against the closed forms of their motion.
namespace stillframe::test {
namespace {

using Eigen::MatrixXd;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

Quaterniond turn(double angle, const Vector3d& axis) {
  return Quaterniond(Eigen::AngleAxisd(angle, axis));
}

/// Position of a node in the world; x stands for displacements, or rates with the start left out.
Vector3d translation(const Model& model, const VectorXd& x, const std::string& name) {
  const Index node = model.node_index(name);
  Vector3d value;
  for (int i = 0; i < 3; ++i) value(i) = model.translation_row(node, Vector3d::Unit(i)).dot(x);
  return value;
}
Vector3d place(const Model& model, const VectorXd& x, const std::string& name) {
  return model.nodes[static_cast<size_t>(model.node_index(name))].position +
         translation(model, x, name);
}
double angle(const Model& model, const VectorXd& x, const std::string& name) {
  return x(model.nodes[static_cast<size_t>(model.node_index(name))].rotation.column[0]);
}
/// Euler parameters of a node as (w, x, y, z); of rates with one = 0.
Eigen::Vector4d parameters(const Model& model, const VectorXd& x, const std::string& name,
                           double one = 1.0) {
  const auto& column = model.nodes[static_cast<size_t>(model.node_index(name))].rotation.column;
  return {one + x(column[0]), x(column[1]), x(column[2]), x(column[3])};
}
Eigen::Vector4d entries(const Quaterniond& q) { return {q.w(), q.x(), q.y(), q.z()}; }

void expect_chain(const Model& model, const Data& data, const VectorXd& angles) {
  Quaterniond rotation = Quaterniond::Identity();
  Vector3d at = model.nodes.front().position;
  for (int i = 1; i <= angles.size(); ++i) {
    const std::string n = std::to_string(i);
    rotation = rotation * turn(angles(i - 1), chain_axis(i));
    EXPECT_EQ(place(model, data.x, "start_" + n),
              i == 1 ? at : place(model, data.x, "end_" + std::to_string(i - 1)));
    at += rotation * chain_link(i);
    // Roundings add up along the chain: a few of 1e-16 a link.
    const double tolerance = 2e-15 * i;
    EXPECT_LE((place(model, data.x, "end_" + n) - at).norm(), tolerance) << i;
    EXPECT_LE((parameters(model, data.x, "end_" + n) - entries(rotation)).norm(), tolerance) << i;
  }
}

TEST(HingeChain, IsTheProductOfItsRotations) {
  const Model model = make_model(hinge_chain(4, true));
  ASSERT_EQ(model.n_d, 3);
  ASSERT_EQ(model.n_r, 1);
  ASSERT_EQ(model.n_rx, 0);
  std::mt19937 engine(41);
  for (int k = 0; k < 10; ++k) {
    Data data(model);
    VectorXd angles = 2.5 * random_vector(4, engine);
    MotionState state(model);
    // In four steps: from far away Newton's method need not find its way.
    for (const double part : {0.25, 0.5, 0.75, 1.0}) {
      state.q_r(0) = part * angles(0);
      state.q_d = part * angles.tail(3);
      ASSERT_TRUE(solve_positions(model, data, state));
    }
    expect_chain(model, data, angles);
  }
}

TEST(HingeChain, APrescribedAngleTurnsTheWholeChainWithItsRateAndAcceleration) {
  const Model model = make_model(hinge_chain(3, true));
  Data data(model);
  MotionState state(model);
  state.q_r(0) = 0.8;
  state.q_r_dot(0) = 3.0;
  state.q_r_ddot(0) = -5.0;
  state.q_d = Eigen::Vector2d(0.4, -0.6);
  ASSERT_TRUE(solve_positions(model, data, state));
  geometric_transfer_functions(model, data);
  velocities(model, data, state);
  const Vector3d n = chain_axis(1), r = place(model, data.x, "end_3") - model.nodes[0].position;
  const Vector3d v = 3.0 * n.cross(r), a = -5.0 * n.cross(r) + 3.0 * n.cross(v);
  EXPECT_LE((translation(model, data.x_dot, "end_3") - v).norm(), 1e-14 * v.norm());
  EXPECT_LE((translation(model, data.x_ddot_0, "end_3") - a).norm(), 1e-14 * a.norm());
  EXPECT_EQ(data.e_dot(model.deformation_row("hinge_1")), 3.0);
  // omega = 2 lambda' conj(lambda) of every link is that of the first hinge.
  for (const char* node : {"start_1", "end_2", "end_3"}) {
    const Eigen::Vector4d l = parameters(model, data.x, node),
                          rate = parameters(model, data.x_dot, node, 0.0);
    const Quaterniond omega = Quaterniond(rate(0), rate(1), rate(2), rate(3)) *
                              Quaterniond(l(0), l(1), l(2), l(3)).conjugate();
    EXPECT_LE((2.0 * omega.vec() - 3.0 * n).norm(), 1e-14) << node;
  }
}

TEST(SpinningRotor, StaysExactOverTenThousandRevolutions) {
  const Model model = make_model(spinning_rotor());
  Data data(model);
  MotionState state(model);
  const double end = 2e4 * M_PI, step = 1.0;
  double worst_norm = 0, worst = 0;
  for (int k = 1; k * step < end + step; ++k) {
    const double theta = std::min(k * step, end);
    state.q_r(0) = theta;
    state.q_d(0) = 0.3 * theta;
    ASSERT_TRUE(solve_positions(model, data, state)) << k;
    const Quaterniond rotor = turn(theta, chain_axis(1)),
                      disc = rotor * turn(0.3 * theta, chain_axis(2));
    for (const auto& [node, expected] : {std::pair("start_1", rotor), std::pair("start_2", disc)}) {
      const Eigen::Vector4d lambda = parameters(model, data.x, node);
      worst_norm = worst_of(worst_norm, std::abs(lambda.squaredNorm() - 1.0));
      worst = worst_of(worst, (lambda - entries(expected)).norm());
    }
  }
  // The last step is of some eps, whatever went before.
  EXPECT_LE(worst_norm, 4e-15);
  // 62832 rad are known to eps / 2 of them, 7e-12, and 5000 periods to as much.
  EXPECT_LE(worst, 1e-11);
  RecordProperty("worst_norm", std::to_string(worst_norm));
  std::cout << "lambda^T lambda - 1: " << worst_norm << ", Euler parameters: " << worst << "\n";
}

TEST(SliderCrank, IsTheClosedFormWithRateAndAcceleration) {
  const Model model = make_model(slider_crank());
  Data data(model);
  const double r = 0.3, l = 0.8, start = 0.5;
  for (double turned = 0; turned < 12; turned += 0.2) {
    MotionState state = position_state(model, VectorXd::Constant(1, turned));
    state.q_d_dot(0) = 2.0;
    ASSERT_TRUE(solve_positions(model, data, state));
    geometric_transfer_functions(model, data);
    velocities(model, data, state);
    const double phi = start + turned, s = r * std::sin(phi), c = r * std::cos(phi);
    const double rod = std::sqrt(l * l - s * s);
    // x = c + rod with rod rod' = -s c phi' and (rod')^2 + rod rod'' = (s^2 - c^2) phi'^2.
    const double rod_1 = -s * c * 2 / rod, rod_2 = ((s * s - c * c) * 4 - rod_1 * rod_1) / rod;
    EXPECT_NEAR(place(model, data.x, "slider").x(), c + rod, 1e-14);
    EXPECT_NEAR(translation(model, data.x_dot, "slider").x(), -2 * s + rod_1, 1e-14);
    EXPECT_NEAR(translation(model, data.x_ddot_0, "slider").x(), -4 * c + rod_2, 4e-14);
    EXPECT_NEAR(angle(model, data.x, "slider"),
                std::asin(-s / l) + std::asin(r * std::sin(0.5) / l), 1e-14);
    EXPECT_EQ(place(model, data.x, "slider").y(), 0.0);
  }
}

TEST(FourBar, ClosesItsLoopLikeTwoCircles) {
  const Model model = make_model(four_bar());
  Data data(model);
  const Vector3d pin_0(0.1, 0.3, 0), knee_0(0.9, 0.75, 0), far(1, 0.1, 0);
  const double coupler = (knee_0 - pin_0).norm(), rocker = (knee_0 - far).norm();
  for (double turned = 0; turned > -8; turned -= 0.1) {  // more than once round
    ASSERT_TRUE(solve_positions(model, data, position_state(model, VectorXd::Constant(1, turned))));
    const Vector3d pin = turn(turned, Vector3d::UnitZ()) * pin_0;
    // The knee is where the circles about pin and foot meet, on the side where it began.
    const Vector3d d = far - pin, u = d.normalized(), side(-u.y(), u.x(), 0);
    const double along = (coupler * coupler - rocker * rocker + d.squaredNorm()) / (2 * d.norm());
    const Vector3d knee = pin + along * u + std::sqrt(coupler * coupler - along * along) * side;
    EXPECT_LE((place(model, data.x, "pin") - pin).norm(), 1e-14) << turned;
    EXPECT_LE((place(model, data.x, "knee") - knee).norm(), 1e-14) << turned;
    EXPECT_EQ(place(model, data.x, "knee"), place(model, data.x, "rocker"));
    const Vector3d link = knee - pin, link_0 = knee_0 - pin_0;
    EXPECT_NEAR(std::remainder(angle(model, data.x, "coupler") - std::atan2(link.y(), link.x()) +
                                   std::atan2(link_0.y(), link_0.x()),
                               2 * M_PI),
                0.0, 1e-14);
    EXPECT_NEAR(data.e(model.deformation_row("motor")), turned, 1e-14);
  }
}

/// Twelve links have 132 conditions, one link more than the largest dense J.
class LongChain : public testing::Test {
 protected:
  Model model_ = make_model(hinge_chain(12, false));
  Data data_{model_};
  std::mt19937 engine_{43};
  VectorXd angles_ = 0.6 * random_vector(12, engine_);

  void SetUp() override {
    ASSERT_GT(model_.n_c, ConditionFactors::largest_dense);
    for (const double part : {0.25, 0.5, 0.75, 1.0}) {
      ASSERT_TRUE(solve_positions(model_, data_, position_state(model_, part * angles_)));
    }
    geometric_transfer_functions(model_, data_);
  }
  MatrixXd dense_conditions() const {
    return dense_jacobian(model_, data_).topLeftCorner(model_.n_c, model_.n_c);
  }
};

TEST_F(LongChain, IsTheProductOfItsRotations) { expect_chain(model_, data_, angles_); }

TEST_F(LongChain, SparseFactorsSolveLikeDenseOnes) {
  const MatrixXd J = dense_conditions();
  const Eigen::PartialPivLU<MatrixXd> lu(J);
  MatrixXd unit = MatrixXd::Zero(model_.n_c, 12);
  for (Index i = 0; i < 12; ++i) unit(model_.dofs[static_cast<size_t>(i)].index, i) = 1.0;
  const MatrixXd DF = lu.solve(unit);
  // J has a condition of some 1e3: 1e-12 leaves it and the size of the chain to the rounding.
  const double tolerance = 1e-12;
  EXPECT_LE(relative_error(data_.DF.topRows(model_.n_c), DF), tolerance);
  const VectorXd b = random_vector(model_.n_c, engine_);
  VectorXd x = b, y = b;
  data_.J.solve(x);
  data_.J.solve_transposed(y);
  EXPECT_LE(relative_error(x, lu.solve(b)), tolerance);
  EXPECT_LE(relative_error(y, J.transpose().partialPivLu().solve(b)), tolerance);
  const VectorXd values = Eigen::BDCSVD<MatrixXd>(J).singularValues();
  const double ratio = values(values.size() - 1) / values(0);
  // An estimate: the norm of J is that of Frobenius, within a factor sqrt(n) of the largest value.
  EXPECT_GT(data_.J.reciprocal_condition(), ratio / std::sqrt(values.size()) / 2);
  EXPECT_LT(data_.J.reciprocal_condition(), ratio * 2);
}

TEST_F(LongChain, TheAngularVelocityOfTheTipIsTheSumOfTheHinges) {
  MotionState state = position_state(model_, angles_);
  state.q_d_dot = random_vector(12, engine_);
  velocities(model_, data_, state);
  Quaterniond rotation = Quaterniond::Identity();
  Vector3d omega = Vector3d::Zero();
  for (int i = 1; i <= 12; ++i) {
    omega += state.q_d_dot(i - 1) * (rotation * chain_axis(i));
    rotation = rotation * turn(angles_(i - 1), chain_axis(i));
  }
  const Eigen::Vector4d rate = parameters(model_, data_.x_dot, "end_12", 0.0);
  const Quaterniond found = Quaterniond(rate(0), rate(1), rate(2), rate(3)) * rotation.conjugate();
  EXPECT_LE((2.0 * found.vec() - omega).norm(), 1e-13);
}

/// Sizes below and above the change from dense to sparse.
class Factors : public testing::TestWithParam<int> {
 protected:
  const Index n_ = GetParam();
  std::mt19937 engine_{47};

  /// Diagonally heavy with a few other entries a row, some of them added twice.
  MatrixXd fill(ConditionFactors& factors) {
    MatrixXd J = MatrixXd::Zero(n_, n_);
    std::uniform_int_distribution<Index> any(0, n_ - 1);
    factors.clear();
    const auto add = [&](Index i, Index j, double value) {
      J(i, j) += value;
      factors.add(i, j, value);
    };
    std::mt19937 pattern(53);  // the same entries every time, with other values
    for (Index i = 0; i < n_; ++i) {
      add(i, (i + 3) % n_, 3.0 + random_vector(1, engine_)(0));
      for (int k = 0; k < 4; ++k) add(i, any(pattern), random_vector(1, engine_)(0));
    }
    factors.factorise();
    return J;
  }
};

TEST_P(Factors, SolveForVectorsAndRowsAndTransposed) {
  ConditionFactors factors(n_, 3);
  EXPECT_EQ(factors.size(), n_);
  for (int k = 0; k < 2; ++k) {
    const MatrixXd J = fill(factors);
    VectorXd x = random_vector(n_, engine_), y = x;
    const VectorXd b = x;
    factors.solve(x);
    factors.solve_transposed(y);
    // Well conditioned: residuals of some eps.
    EXPECT_LE((J * x - b).norm(), 1e-13 * b.norm());
    EXPECT_LE((J.transpose() * y - b).norm(), 1e-13 * b.norm());
    for (const Index columns : {2, 3, 7}) {  // 7: more than were announced
      RowMatrix B = random_vector(n_ * columns, engine_).reshaped(n_, columns);
      const RowMatrix right = B;
      factors.solve(B);
      EXPECT_LE((J * B - right).norm(), 1e-13 * right.norm()) << columns;
    }
  }
}

TEST_P(Factors, KnowTheSignOfTheDeterminant) {
  ConditionFactors factors(n_, 1);
  for (int k = 0; k < 20; ++k) {
    const double determinant = fill(factors).determinant();  // up to 1e150
    EXPECT_EQ(factors.sign(), determinant > 0 ? 1 : -1) << determinant;
  }
  factors.clear();  // two rows swapped, and no pivot is negative
  for (Index i = 0; i < n_; ++i) factors.add(i, i < 2 ? 1 - i : i, 1.0);
  factors.factorise();
  EXPECT_EQ(factors.sign(), -1);
}

TEST_P(Factors, ASingularMatrixHasNoReciprocalCondition) {
  ConditionFactors factors(n_, 1);
  factors.clear();
  for (Index i = 0; i < n_; ++i) factors.add(i, std::max<Index>(i, 1), 1.0);  // column 0 is empty
  factors.factorise();
  EXPECT_LE(factors.reciprocal_condition(), 1e-15);
}

INSTANTIATE_TEST_SUITE_P(Sizes, Factors, testing::Values(5, 40, 120, 121, 300));

}  // namespace
}  // namespace stillframe::test

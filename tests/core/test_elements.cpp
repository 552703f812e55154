#include <gtest/gtest.h>

#include <stdexcept>

#include "core/numerics/worst.hpp"
#include "tests/core/element_cases.hpp"

namespace stillframe::test {
namespace {

class Elements : public testing::TestWithParam<const char*> {
 protected:
  static constexpr int n_states = 20;
  // A derivative is a sum of some ten products; 1e-12 of its largest entry is far above their
  // rounding.
  static constexpr double derivative_tolerance = 1e-12;
  Random random_{7};
  Case next_case() { return make_case(GetParam(), random_.vector(3)); }
};

TEST_P(Elements, DeformationsAreThoseOfTheDefinition) {
  for (int k = 0; k < n_states; ++k) {
    const Case c = next_case();
    const LocalVector u = random_state(*c.element, c.l_0, random_);
    LocalDeformation e(c.element->n_deformations());
    c.element->deformations(u, e);
    const auto expected = exact(c, u);
    const double size = std::max(1.0, c.l_0.squaredNorm() + u.squaredNorm());
    for (Index i = 0; i < e.size(); ++i) {
      // n_y, n_z are unit vectors up to 1e-16 in the element and in the formula alike.
      EXPECT_NEAR(e(i), static_cast<double>(expected[static_cast<size_t>(i)]), 1e-14 * size) << i;
    }
  }
}

TEST_P(Elements, FirstAndSecondDerivativesAgreeWithHyperDualNumbers) {
  for (int k = 0; k < n_states; ++k) {
    const Case c = next_case();
    const Index n_e = c.element->n_deformations(), n = c.element->n_local();
    const LocalVector u = random_state(*c.element, c.l_0, random_);
    const VectorXd v = random_.vector(n), w = random_.vector(n);
    LocalJacobian D(n_e, n);
    LocalDeformation found(n_e);
    c.element->jacobian(u, D);
    c.element->second_derivative(u, v, w, found);
    MatrixXd expected(n_e, n);
    for (Index j = 0; j < n; ++j) {
      const auto column = differentiate(c, u, VectorXd::Unit(n, j), w);
      for (Index i = 0; i < n_e; ++i) expected(i, j) = first(column[static_cast<size_t>(i)]);
    }
    EXPECT_LE(worst_of(D - expected), derivative_tolerance * worst_of(expected));
    const auto along = differentiate(c, u, v, w);
    VectorXd expected_second(n_e);
    for (Index i = 0; i < n_e; ++i) expected_second(i) = second(along[static_cast<size_t>(i)]);
    EXPECT_LE(worst_of(found - expected_second), derivative_tolerance * worst_of(expected_second));
  }
}

TEST_P(Elements, HessianAgreesWithHyperDualNumbersEntryByEntry) {
  for (int k = 0; k < n_states; ++k) {
    const Case c = next_case();
    const Index n_e = c.element->n_deformations(), n = c.element->n_local();
    const LocalVector u = random_state(*c.element, c.l_0, random_);
    const LocalDeformation sigma = random_.vector(n_e);
    LocalHessian H(n, n);
    c.element->hessian(u, sigma, H);
    MatrixXd expected = MatrixXd::Zero(n, n);
    for (Index a = 0; a < n; ++a) {
      for (Index b = 0; b < n; ++b) {
        const auto values = differentiate(c, u, VectorXd::Unit(n, a), VectorXd::Unit(n, b));
        for (Index i = 0; i < n_e; ++i)
          expected(a, b) += sigma(i) * second(values[static_cast<size_t>(i)]);
      }
    }
    EXPECT_LE(worst_of(MatrixXd(H) - expected), derivative_tolerance * worst_of(expected));
  }
}

/// D_x, dD_x/dt and d2D_x/dt2 entry by entry: t is eps_1 + eps_2, so that t^2 / 2 is eps_1 eps_2,
/// and eps_3 stands on one coordinate.
std::array<MatrixXd, 2> rates_by_third_derivatives(const Case& c, const LocalVector& u,
                                                   const VectorXd& v, const VectorXd& a) {
  const Index n_e = c.element->n_deformations(), n = c.element->n_local();
  std::array<MatrixXd, 2> rates{MatrixXd(n_e, n), MatrixXd(n_e, n)};
  for (Index j = 0; j < n; ++j) {
    std::vector<Dual<HyperDual>> seeded;
    for (Index i = 0; i < n; ++i) {
      seeded.emplace_back(hyper_dual(u(i), v(i), v(i), a(i)), HyperDual(i == j ? 1.0 : 0.0));
    }
    const auto values = c.third_formula(seeded);
    for (Index i = 0; i < n_e; ++i) {
      rates[0](i, j) = first(values[static_cast<size_t>(i)].d);
      rates[1](i, j) = second(values[static_cast<size_t>(i)].d);
    }
  }
  return rates;
}

TEST_P(Elements, JacobianRatesAgreeWithThirdDerivatives) {
  for (int k = 0; k < n_states; ++k) {
    const Case c = next_case();
    const Index n_e = c.element->n_deformations(), n = c.element->n_local();
    const LocalVector u = random_state(*c.element, c.l_0, random_);
    const VectorXd v = random_.vector(n), a = random_.vector(n);
    LocalJacobian rate(n_e, n), second_rate(n_e, n);
    c.element->jacobian_rates(u, v, a, rate, second_rate);
    const auto expected = rates_by_third_derivatives(c, u, v, a);
    EXPECT_LE(worst_of(rate - expected[0]), derivative_tolerance * worst_of(expected[0]));
    EXPECT_LE(worst_of(second_rate - expected[1]), derivative_tolerance * worst_of(expected[1]));
  }
}

TEST_P(Elements, TheSceneAsWrittenIsUndeformed) {
  const Case c = next_case();
  LocalDeformation e(c.element->n_deformations());
  c.element->deformations(LocalVector::Zero(c.element->n_local()), e);
  EXPECT_EQ(worst_of(e), 0.0);  // exactly: every term has a displacement as a factor
}

TEST_P(Elements, RigidMotionDeformsNothing) {
  for (int k = 0; k < n_states; ++k) {
    const Case c = next_case();
    const bool planar = std::string(GetParam()).starts_with("planar");
    const Eigen::Vector3d p = random_.vector(3), t = random_.vector(3);
    const double angle = 2.0 * random_.vector(1)(0);
    const Vector4 lambda =
        planar ? Vector4(std::cos(angle / 2), 0, 0, std::sin(angle / 2)) : random_.quaternion();
    const Eigen::Matrix3d R =
        Eigen::Quaterniond(lambda(0), lambda(1), lambda(2), lambda(3)).toRotationMatrix();
    LocalVector u(c.element->n_local());
    Index at = 0;
    bool at_p = true;
    for (const NodePart& part : c.element->parts()) {
      if (part.kind == NodePart::Kind::rotation) {
        u.segment<4>(at) = lambda - Vector4::Unit(0);
      } else if (part.kind == NodePart::Kind::angle) {
        u(at) = angle;
      } else {
        const Eigen::Vector3d X = at_p ? p : Eigen::Vector3d(p + c.between);
        u.segment<3>(at) = R * X + t - X;
        at_p = false;
      }
      at += part.size();
    }
    LocalDeformation e(c.element->n_deformations());
    c.element->deformations(u, e);
    // Positions of a few metres carry a rounding of 1e-15 m into e, products of lengths a little
    // more.
    EXPECT_LE(worst_of(e), 2e-14) << GetParam();
  }
}

TEST_P(Elements, APicometreOnAMetreKeepsThirteenDigits) {
  for (int k = 0; k < n_states; ++k) {
    const Case c = make_case(GetParam(), random_.vector(3).normalized());
    const LocalVector u = 1e-12 * random_.vector(c.element->n_local());
    LocalDeformation e(c.element->n_deformations());
    c.element->deformations(u, e);
    const auto expected = exact(c, u);
    for (Index i = 0; i < e.size(); ++i) {
      // Against a deformation of 1e-12: a handful of roundings of terms of that size.
      EXPECT_NEAR(e(i), static_cast<double>(expected[static_cast<size_t>(i)]), 1e-13 * 1e-12)
          << GetParam() << " deformation " << i;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, Elements,
                         testing::Values("truss", "arm_truss", "one_arm_truss", "beam", "norm",
                                         "planar_beam", "hinge", "planar_hinge", "superelement",
                                         "arc_beam", "planar_arc_beam", "quadratic_beam"),
                         [](const auto& param) { return std::string(param.param); });

TEST(Truss, APicometreOnTopOfAMicrometreOfCommonMotion) {
  const Eigen::Vector3d l_0(0.6, -0.48, 0.64);
  const Case c = make_case("truss", l_0);
  LocalVector u(6);
  u.head<3>() = Eigen::Vector3d(1e-6, 2e-6, -3e-6);
  u.tail<3>() = u.head<3>() + 1e-12 * l_0;
  LocalDeformation e(1);
  c.element->deformations(u, e);
  // The difference of two doubles so close is exact, so nothing is lost that u itself still holds.
  EXPECT_NEAR(e(0) / static_cast<double>(exact(c, u)[0]), 1.0, 1e-13);
}

TEST(Truss, ElongationIsTheStretchInClosedForm) {
  const Truss truss(0, 1, {3, 0, 4});
  LocalVector u = LocalVector::Zero(6);
  u.tail<3>() = Eigen::Vector3d(0.3, 0, 0.4);
  LocalDeformation e(1);
  truss.deformations(u, e);
  EXPECT_DOUBLE_EQ(e(0), 0.5);
}

TEST(Beam, DeformationsMeanWhatTheHeaderSays) {
  // A rotation of end q about the beam is torsion alone.
  const double angle = 1e-6, length = 2.0;
  const Eigen::Vector3d l_0(length, 0, 0);
  const Beam beam(0, 1, l_0, any_orientation(l_0));
  LocalDeformation e(6);
  LocalVector u = LocalVector::Zero(14);
  u(11) = std::sin(angle / 2);
  u(10) = std::cos(angle / 2) - 1;
  beam.deformations(u, e);
  // e_2 = l_0 (n_z . R n_y - n_y . R n_z) / 2 = l_0 sin(angle).
  EXPECT_NEAR(e(1), length * std::sin(angle), 1e-20);
  EXPECT_NEAR(e.head(1).norm() + e.tail(4).norm(), 0.0, 1e-20);
  u.setZero();
  u.segment<3>(7) = 1e-6 * Eigen::Vector3d::UnitX().unitOrthogonal();
  beam.deformations(u, e);
  // A sideways shift s of end q along n_y gives e_5 = s, e_6 = -s and an elongation of s^2 / (2 l).
  EXPECT_NEAR(e(4), 1e-6, 1e-19);
  EXPECT_NEAR(e(5), -1e-6, 1e-19);
  EXPECT_NEAR(e(0), 1e-12 / (2 * length), 1e-24);  // the next term is s^4 / (8 l^3)
}

TEST(PlanarBeam, DeformationsMeanWhatTheHeaderSays) {
  const PlanarBeam beam(0, 1, {0, 2, 0});  // n_y is -x
  LocalDeformation e(3);
  LocalVector u = LocalVector::Zero(8);
  u(3) = 0.3;
  beam.deformations(u, e);
  // The axis at p turns away from the chord: -(R n_y) . l = l_0 sin(angle).
  EXPECT_LE((e - Eigen::Vector3d(0, 2 * std::sin(0.3), 0)).norm(), 1e-15);
  u.setZero();
  u(7) = 0.3;
  beam.deformations(u, e);
  EXPECT_LE((e - Eigen::Vector3d(0, 0, -2 * std::sin(0.3))).norm(), 1e-15);
  u.setZero();
  u(4) = -1e-6;
  beam.deformations(u, e);
  EXPECT_LE((e - Eigen::Vector3d(1e-12 / 4, -1e-6, 1e-6)).norm(), 1e-21);
}

TEST(Hinge, TurnsByAnyAngleAboutAnObliqueAxis) {
  Random random(13);
  const Eigen::Vector3d axis(1, -2, 0.5), n = axis.normalized();
  const Hinge hinge(0, 1, axis);
  for (double angle = -30; angle < 30; angle += 0.37) {
    const Vector4 lambda = random.quaternion();
    const Eigen::Quaterniond p(lambda(0), lambda(1), lambda(2), lambda(3));
    const Eigen::Quaterniond q = p * Eigen::Quaterniond(Eigen::AngleAxisd(angle, n));
    LocalVector u(8);
    u << lambda - Vector4::Unit(0), q.w() - 1, q.vec();
    LocalDeformation e(3);
    hinge.deformations(u, e);
    // Exact up to whole periods and to the rounding of the sine and cosine of 30 rad.
    EXPECT_NEAR(std::remainder(e(0) - angle, hinge.period()), 0.0, 1e-14);
    EXPECT_NEAR(e(1), 0.0, 1e-15);
    EXPECT_NEAR(e(2), 0.0, 1e-15);
  }
}

TEST(Hinge, TiltsAreTheSinesOfTheOtherTwoRotations) {
  const Eigen::Vector3d n_x = Eigen::Vector3d(2, 1, -1).normalized(), n_y = n_x.unitOrthogonal();
  const Hinge hinge(0, 1, n_x);
  for (const auto& [axis, expected] :
       {std::pair(n_y, Eigen::Vector3d(0, std::sin(0.4), 0)),
        std::pair(Eigen::Vector3d(n_x.cross(n_y)), Eigen::Vector3d(0, 0, std::sin(0.4)))}) {
    const Eigen::Quaterniond q(Eigen::AngleAxisd(0.4, axis));
    LocalVector u = LocalVector::Zero(8);
    u.tail<4>() << q.w() - 1, q.vec();
    LocalDeformation e(3);
    hinge.deformations(u, e);
    EXPECT_LE((e - expected).norm(), 1e-15);
  }
}

TEST(ElementSetUp, ZeroLengthIsRefused) {
  EXPECT_THROW(
      ArmTruss(0, 1, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX(), Eigen::Vector3d::Zero()),
      std::invalid_argument);
  EXPECT_THROW(Truss(0, 1, Eigen::Vector3d::Zero()), std::invalid_argument);
  EXPECT_THROW(Beam(0, 1, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitY()),
               std::invalid_argument);
  EXPECT_THROW(PlanarBeam(0, 1, Eigen::Vector3d::Zero()), std::invalid_argument);
  EXPECT_THROW(Hinge(0, 1, Eigen::Vector3d::Zero()), std::invalid_argument);
  EXPECT_THROW(Beam(0, 1, Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(-2, -4, -6)),
               std::invalid_argument);
  EXPECT_THROW(Truss(0, 1, Eigen::Vector3d::Constant(std::nan(""))), std::invalid_argument);
}

TEST(Rotation, BodyRateMatrixGivesTheAngularVelocityOfTheRotationMatrix) {
  Random random(3);
  for (int k = 0; k < 10; ++k) {
    const Vector4 lambda = random.quaternion();
    Vector4 rate = random.vector(4);
    rate -= lambda * lambda.dot(rate);
    Eigen::Matrix3d R, R_dot;
    for (int j = 0; j < 3; ++j) {
      HyperDual seeded[4];
      for (int i = 0; i < 4; ++i) seeded[i] = hyper_dual(lambda(i), rate(i), 0);
      const auto column = rotate(seeded, constant<HyperDual>(Eigen::Vector3d::Unit(j)));
      for (int i = 0; i < 3; ++i) {
        R(i, j) = column[static_cast<size_t>(i)].value.value;
        R_dot(i, j) = first(column[static_cast<size_t>(i)]);
      }
    }
    const Eigen::Vector3d omega = 2.0 * body_rate_matrix(lambda) * rate;
    // R' = R [omega]x in body axes; products of numbers of order one.
    EXPECT_LE(worst_of(R.transpose() * R_dot - cross_matrix(omega)), 1e-14);
  }
}

}  // namespace
}  // namespace stillframe::test

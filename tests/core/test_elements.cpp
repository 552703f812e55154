#include <gtest/gtest.h>

#include <functional>
#include <random>
#include <stdexcept>

#include "core/elements/beam.hpp"
#include "core/elements/norm_condition.hpp"
#include "core/elements/rotation.hpp"
#include "core/elements/truss.hpp"
#include "tests/core/element_formulas.hpp"

namespace stillframe::test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Case {
  std::unique_ptr<Element> element;
  std::function<std::vector<HyperDual>(const std::vector<HyperDual>&)> formula;
  std::function<std::vector<Quad>(const std::vector<Quad>&)> exact_formula;
  Eigen::Vector3d l_0;
};

Case make_case(const std::string& kind, const Eigen::Vector3d& l_0) {
  if (kind == "truss") {
    return {std::make_unique<Truss>(0, 1, l_0),
            [l_0](const auto& u) { return truss_formula<HyperDual>(l_0, u); },
            [l_0](const auto& u) { return truss_formula<Quad>(l_0, u); }, l_0};
  }
  if (kind == "beam") {
    return {std::make_unique<Beam>(0, 1, l_0),
            [l_0](const auto& u) { return beam_formula<HyperDual>(l_0, u); },
            [l_0](const auto& u) { return beam_formula<Quad>(l_0, u); }, l_0};
  }
  return {std::make_unique<NormCondition>(0),
          [](const auto& u) { return norm_formula<HyperDual>(u); },
          [](const auto& u) { return norm_formula<Quad>(u); }, l_0};
}

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  VectorXd vector(Index n) {
    VectorXd v(n);
    for (Index i = 0; i < n; ++i) v(i) = normal_(engine_);
    return v;
  }
  Vector4 quaternion() { return vector(4).normalized(); }

 private:
  std::mt19937 engine_;
  std::normal_distribution<double> normal_;
};

/// Displacements of the size of the element, and rotations of any angle.
LocalVector random_state(const Element& element, const Eigen::Vector3d& l_0, Random& random) {
  LocalVector u(element.n_local());
  Index at = 0;
  for (const NodePart& part : element.parts()) {
    if (part.rotation) {
      u.segment<4>(at) = random.quaternion() - Vector4::Unit(0);
    } else {
      u.segment<3>(at) = 0.5 * l_0.norm() * random.vector(3);
    }
    at += part.size();
  }
  return u;
}

/// Second derivative of each deformation in directions v and w; v's first derivative in d1.
std::vector<HyperDual> differentiate(const Case& c, const LocalVector& u, const VectorXd& v,
                                     const VectorXd& w) {
  std::vector<HyperDual> seeded;
  for (Index i = 0; i < u.size(); ++i) seeded.emplace_back(u(i), v(i), w(i));
  return c.formula(seeded);
}

std::vector<Quad> exact(const Case& c, const LocalVector& u) {
  return c.exact_formula(std::vector<Quad>(u.data(), u.data() + u.size()));
}

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
    LocalDeformation second(n_e);
    c.element->jacobian(u, D);
    c.element->second_derivative(u, v, w, second);
    MatrixXd expected(n_e, n);
    for (Index j = 0; j < n; ++j) {
      const auto column = differentiate(c, u, VectorXd::Unit(n, j), w);
      for (Index i = 0; i < n_e; ++i) expected(i, j) = column[static_cast<size_t>(i)].d1;
    }
    EXPECT_LE((D - expected).cwiseAbs().maxCoeff(),
              derivative_tolerance * expected.cwiseAbs().maxCoeff());
    const auto along = differentiate(c, u, v, w);
    VectorXd expected_second(n_e);
    for (Index i = 0; i < n_e; ++i) expected_second(i) = along[static_cast<size_t>(i)].d12;
    EXPECT_LE((second - expected_second).cwiseAbs().maxCoeff(),
              derivative_tolerance * expected_second.cwiseAbs().maxCoeff());
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
          expected(a, b) += sigma(i) * values[static_cast<size_t>(i)].d12;
      }
    }
    EXPECT_LE((MatrixXd(H) - expected).cwiseAbs().maxCoeff(),
              derivative_tolerance * expected.cwiseAbs().maxCoeff());
  }
}

TEST_P(Elements, TheSceneAsWrittenIsUndeformed) {
  const Case c = next_case();
  LocalDeformation e(c.element->n_deformations());
  c.element->deformations(LocalVector::Zero(c.element->n_local()), e);
  EXPECT_EQ(e.cwiseAbs().maxCoeff(), 0.0);  // exactly: every term has a displacement as a factor
}

TEST_P(Elements, RigidMotionDeformsNothing) {
  for (int k = 0; k < n_states; ++k) {
    const Case c = next_case();
    const Eigen::Vector3d p = random_.vector(3), t = random_.vector(3);
    const Vector4 lambda = random_.quaternion();
    const Eigen::Matrix3d R =
        Eigen::Quaterniond(lambda(0), lambda(1), lambda(2), lambda(3)).toRotationMatrix();
    LocalVector u(c.element->n_local());
    Index at = 0;
    bool first = true;
    for (const NodePart& part : c.element->parts()) {
      if (part.rotation) {
        u.segment<4>(at) = lambda - Vector4::Unit(0);
      } else {
        const Eigen::Vector3d X = first ? p : Eigen::Vector3d(p + c.l_0);
        u.segment<3>(at) = R * X + t - X;
        first = false;
      }
      at += part.size();
    }
    LocalDeformation e(c.element->n_deformations());
    c.element->deformations(u, e);
    // Positions of a few metres carry a rounding of 1e-15 m into e, products of lengths a little
    // more.
    EXPECT_LE(e.cwiseAbs().maxCoeff(), 2e-14) << GetParam();
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

INSTANTIATE_TEST_SUITE_P(Kinds, Elements, testing::Values("truss", "beam", "norm"),
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
  const Beam beam(0, 1, {length, 0, 0});
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

TEST(ElementSetUp, ZeroLengthIsRefused) {
  EXPECT_THROW(Truss(0, 1, Eigen::Vector3d::Zero()), std::invalid_argument);
  EXPECT_THROW(Beam(0, 1, Eigen::Vector3d::Zero()), std::invalid_argument);
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
      for (int i = 0; i < 4; ++i) seeded[i] = HyperDual(lambda(i), rate(i), 0);
      const auto column = rotate(seeded, constant<HyperDual>(Eigen::Vector3d::Unit(j)));
      for (int i = 0; i < 3; ++i) {
        R(i, j) = column[static_cast<size_t>(i)].value;
        R_dot(i, j) = column[static_cast<size_t>(i)].d1;
      }
    }
    const Eigen::Vector3d omega = 2.0 * body_rate_matrix(lambda) * rate;
    // R' = R [omega]x in body axes; products of numbers of order one.
    EXPECT_LE((R.transpose() * R_dot - cross_matrix(omega)).cwiseAbs().maxCoeff(), 1e-14);
  }
}

}  // namespace
}  // namespace stillframe::test

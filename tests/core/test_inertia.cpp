#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "core/mechanics/inertia/beam_mass.hpp"
#include "core/mechanics/inertia/body.hpp"
#include "core/mechanics/inertia/lumped.hpp"
#include "core/mechanics/inertia/planar_beam_mass.hpp"
#include "core/mechanics/inertia/superelement_mass.hpp"
#include "core/numerics/worst.hpp"
#include "tests/core/differences.hpp"
#include "tests/core/scenes.hpp"

namespace stillframe::test {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double mass_per_length = 3.0, inertia_per_length = 0.7;

/// Full and positive definite, with the sums of moments that a body has.
Matrix3d any_inertia() {
  Matrix3d J;
  J << 2.0, 0.3, -0.2, 0.3, 2.5, 0.4, -0.2, 0.4, 1.7;
  return J;
}

std::unique_ptr<const Inertia> make_inertia(const std::string& kind, Vector3d l_0) {
  if (kind == "point") return std::make_unique<PointMass>(0, 2.5);
  if (kind == "planar_body") return std::make_unique<PlanarBody>(0, 0.6);
  if (kind == "body") return std::make_unique<Body>(0, any_inertia());
  if (kind == "beam") {
    return std::make_unique<BeamMass>(0, 1, l_0, mass_per_length, inertia_per_length);
  }
  if (kind == "superelement") {
    // Any symmetric positive matrix: that it is of a body is not what Lagrange's equations ask for.
    std::mt19937 engine(43);
    Eigen::Matrix3Xd s(3, 3);
    s << Vector3d::Zero(), l_0, Vector3d(0.2, 0.8, -0.3);
    const MatrixXd root = random_vector(20 * 20, engine).reshaped(20, 20);
    return std::make_unique<SuperelementMass>(Superelement({0, 1, 2}, s, {3}, 2), s,
                                              MatrixXd(0.1 * root * root.transpose()));
  }
  l_0.z() = 0;
  return std::make_unique<PlanarBeamMass>(0, 1, l_0, mass_per_length);
}

/// Displacements with their rates and accelerations; rotations of any angle.
struct State {
  LocalVector u, v, a;
};

class Inertias : public testing::TestWithParam<const char*> {
 protected:
  static constexpr int n_states = 10;
  // Extrapolated differences with this step leave 8 eps / h = 4e-14 of rounding, and h^8 / 4096 =
  // 1e-14 times a ninth derivative over 9!.
  static constexpr double h = 0.05, tolerance = 1e-12;

  const Vector3d l_0_{0.9, -0.5, 0.4}, g_{0.3, -9.7, 1.1};
  std::unique_ptr<const Inertia> inertia_ = make_inertia(GetParam(), l_0_);
  const Index n_ = inertia_->n_local();
  std::mt19937 engine_{17};

  /// Any state at all: the equations do not need Euler parameters of norm one.
  State any_state() {
    return {0.7 * random_vector(n_, engine_), 2.0 * random_vector(n_, engine_),
            3.0 * random_vector(n_, engine_)};
  }
  /// A state with Euler parameters of norm one and the rates and accelerations of a rotation.
  State unit_state() {
    State s = any_state();
    Index at = 0;
    for (const NodePart& part : inertia_->parts()) {
      if (part.kind == NodePart::Kind::rotation) {
        const Vector4 lambda = random_vector(4, engine_).normalized();
        auto v = s.v.segment<4>(at), a = s.a.segment<4>(at);
        v -= lambda * lambda.dot(v);
        a -= lambda * (lambda.dot(a) + v.squaredNorm());
        s.u.segment<4>(at) = lambda - Vector4::Unit(0);
      }
      at += part.size();
    }
    return s;
  }
  MatrixXd mass(const VectorXd& u) const {
    LocalHessian M(n_, n_);
    inertia_->mass(u, M);
    return M;
  }
  VectorXd force(const VectorXd& u, const VectorXd& v, const VectorXd& a, const Vector3d& g) const {
    LocalVector F(n_);
    inertia_->force(u, v, a, g, F);
    return F;
  }
  VectorXd force(const State& s) const { return force(s.u, s.v, s.a, g_); }
};

TEST_P(Inertias, MassIsSymmetricAndPositiveSemidefinite) {
  for (int k = 0; k < n_states; ++k) {
    const MatrixXd M = mass(unit_state().u);
    EXPECT_LE((M - M.transpose()).norm(), 1e-15 * M.norm());
    const VectorXd values = Eigen::SelfAdjointEigenSolver<MatrixXd>(M).eigenvalues();
    // Rotations have no mass along their Euler parameters: zero to the rounding of the eigenvalues.
    EXPECT_GE(values(0), -1e-14 * values(n_ - 1));
    EXPECT_GT(values(n_ - 1), 0.1);
  }
}

TEST_P(Inertias, MassIsTheForceOfUnitAccelerations) {
  for (int k = 0; k < n_states; ++k) {
    const State s = any_state();
    const VectorXd start = force(s);
    MatrixXd found(n_, n_);
    for (Index i = 0; i < n_; ++i) {
      found.col(i) = force(s.u, s.v, s.a + VectorXd::Unit(n_, i), g_) - start;
    }
    // F is linear in the accelerations; differences of numbers of size |F|.
    EXPECT_LE(worst_of(found - mass(s.u)), 1e-14 * start.norm() + 1e-14);
  }
}

TEST_P(Inertias, ForceIsThatOfLagrangesEquations) {
  for (int k = 0; k < n_states; ++k) {
    const State s = k % 2 == 0 ? any_state() : unit_state();
    const VectorXd u = s.u, v = s.v;
    // d/dt (M v) - d(T - V)/du.
    VectorXd expected =
        mass(u) * s.a + derivative([&](double t) -> VectorXd { return mass(u + t * v) * v; }, h);
    for (Index i = 0; i < n_; ++i) {
      const auto lagrangian = [&](double t) {
        const VectorXd at = u + t * VectorXd::Unit(n_, i);
        return VectorXd::Constant(1, 0.5 * v.dot(mass(at) * v) - inertia_->gravity_energy(at, g_));
      };
      expected(i) -= derivative(lagrangian, h)(0);
    }
    EXPECT_LE(relative_error(force(s), expected), tolerance);
    EXPECT_NEAR(inertia_->kinetic_energy(s.u, s.v), 0.5 * v.dot(mass(u) * v),
                1e-15 * v.dot(mass(u) * v));
  }
}

TEST_P(Inertias, TangentsAreTheDerivativesOfTheForce) {
  for (int k = 0; k < n_states; ++k) {
    const State s = k % 2 == 0 ? any_state() : unit_state();
    LocalHessian in_v(n_, n_), in_u(n_, n_);
    inertia_->tangents(s.u, s.v, s.a, g_, in_v, in_u);
    MatrixXd expected_v(n_, n_), expected_u(n_, n_);
    for (Index i = 0; i < n_; ++i) {
      const VectorXd unit = VectorXd::Unit(n_, i);
      expected_v.col(i) =
          derivative([&](double t) { return force(s.u, s.v + t * unit, s.a, g_); }, h);
      expected_u.col(i) =
          derivative([&](double t) { return force(s.u + t * unit, s.v, s.a, g_); }, h);
    }
    // Point masses have no tangents, their differences the rounding of the force.
    const double rounding = 1e-12 * force(s).norm();
    EXPECT_LE(worst_of(in_v - expected_v), rounding);
    EXPECT_LE(worst_of(in_u - expected_u), rounding);
  }
}

TEST_P(Inertias, NothingIsStoredInTheSceneAsWritten) {
  EXPECT_EQ(inertia_->gravity_energy(LocalVector::Zero(n_), g_), 0.0);
}

INSTANTIATE_TEST_SUITE_P(Kinds, Inertias,
                         testing::Values("point", "planar_body", "body", "planar_beam", "beam",
                                         "superelement"),
                         [](const auto& param) { return std::string(param.param); });

/// Rates of Euler parameters of an angular velocity in body axes, lambda' = Lambda^T omega / 2.
Vector4 euler_rate(const Vector4& lambda, const Vector3d& omega) {
  return 0.5 * body_rate_matrix(lambda).transpose() * omega;
}

TEST(Body, TorqueIsThatOfEulersEquations) {
  const Matrix3d J = any_inertia();
  const Body body(0, J);
  std::mt19937 engine(3);
  for (int k = 0; k < 10; ++k) {
    const Vector4 lambda = random_vector(4, engine).normalized();
    const Vector3d omega = 3 * random_vector(3, engine), alpha = 5 * random_vector(3, engine);
    const Vector4 v = euler_rate(lambda, omega);
    // omega' = 2 Lambda lambda'', and lambda^T lambda'' = -|lambda'|^2 keeps the norm.
    const Vector4 a = euler_rate(lambda, alpha) - lambda * v.squaredNorm();
    LocalVector F(4);
    body.force(lambda - Vector4::Unit(0), v, a, Vector3d::Zero(), F);
    const Vector3d torque = 0.5 * body_rate_matrix(lambda) * Vector4(F);
    const Vector3d expected = J * alpha + omega.cross(J * omega);
    EXPECT_LE((torque - expected).norm(), 1e-14 * expected.norm());  // some twenty products
  }
}

/// Points and weights of Gauss's rule on (0, 1), exact to the seventh order: products of two cubics
/// are of the sixth.
struct Gauss {
  double at, weight;
};
std::array<Gauss, 4> gauss_points() {
  std::array<Gauss, 4> points;
  const double r = std::sqrt(1.2);
  for (int i = 0; i < 4; ++i) {
    const double inner = i < 2 ? -1 : 1, sign = i % 2 == 0 ? -1 : 1;
    const double x = std::sqrt((3 + inner * 2 * r) / 7);
    points[static_cast<size_t>(i)] = {0.5 * (1 + sign * x), (18 - inner * std::sqrt(30.0)) / 72};
  }
  return points;
}

/// The cubic with given ends and end slopes, at s of (0, 1).
Vector3d cubic(double s, const Vector3d& p, const Vector3d& slope_p, const Vector3d& q,
               const Vector3d& slope_q) {
  const double r = 1 - s;
  return r * r * (1 + 2 * s) * p + s * r * r * slope_p + s * s * (3 - 2 * s) * q -
         s * s * r * slope_q;
}

/// One end of a spatial beam: tangent and its rate, rate about the axis, from rotation matrices.
struct BeamEnd {
  Vector3d position, velocity, tangent, tangent_rate;
  double spin = 0;
  BeamEnd(const VectorXd& u, const VectorXd& v, const Vector3d& n_x, const Vector3d& start) {
    const Vector4 lambda = euler_parameters(u.segment<4>(3));
    const Matrix3d R =
        Eigen::Quaterniond(lambda(0), lambda(1), lambda(2), lambda(3)).toRotationMatrix();
    const Vector3d omega = 2.0 * body_rate_matrix(lambda) * v.segment<4>(3);
    position = start + u.head<3>();
    velocity = v.head<3>();
    tangent = R * n_x;
    tangent_rate = R * omega.cross(n_x);
    spin = omega.dot(n_x);
  }
};

TEST(BeamMass, EnergiesAreTheIntegralsOverItsAxis) {
  const Vector3d l_0(0.9, -0.5, 0.4), n_x = l_0.normalized(), g(0.3, -9.7, 1.1);
  const double l = l_0.norm();
  const BeamMass mass(0, 1, l_0, mass_per_length, inertia_per_length);
  std::mt19937 engine(21);
  for (int k = 0; k < 10; ++k) {
    VectorXd u = random_vector(14, engine), v = random_vector(14, engine);
    for (const Index at : {3, 10}) {
      const Vector4 lambda = random_vector(4, engine).normalized();
      u.segment<4>(at) = lambda - Vector4::Unit(0);
      v.segment<4>(at) -= lambda * lambda.dot(v.segment<4>(at));
    }
    const BeamEnd p(u.head(7), v.head(7), n_x, Vector3d::Zero()), q(u.tail(7), v.tail(7), n_x, l_0);
    double kinetic = 0, potential = 0;
    for (const auto [s, weight] : gauss_points()) {
      const Vector3d rate =
                         cubic(s, p.velocity, l * p.tangent_rate, q.velocity, l * q.tangent_rate),
                     now = cubic(s, p.position, l * p.tangent, q.position, l * q.tangent);
      const double spin = (1 - s) * p.spin + s * q.spin;
      kinetic += 0.5 * weight * l *
                 (mass_per_length * rate.squaredNorm() + inertia_per_length * spin * spin);
      potential -= weight * l * mass_per_length * g.dot(now - s * l_0);
    }
    EXPECT_NEAR(mass.kinetic_energy(u, v), kinetic, 1e-13 * kinetic);
    EXPECT_NEAR(mass.gravity_energy(u, g), potential, 1e-13 * mass_per_length * l * g.norm());
  }
}

TEST(BeamMass, InARigidMotionItIsASlenderBody) {
  const Vector3d l_0(0.9, -0.5, 0.4), n_x = l_0.normalized();
  const double l = l_0.norm(), m = mass_per_length * l;
  const BeamMass mass(0, 1, l_0, mass_per_length, inertia_per_length);
  const Matrix3d across = Matrix3d::Identity() - n_x * n_x.transpose();
  const Matrix3d J = m * l * l / 12 * across + inertia_per_length * l * n_x * n_x.transpose();
  std::mt19937 engine(5);
  for (int k = 0; k < 10; ++k) {
    const Vector4 lambda = random_vector(4, engine).normalized();
    const Matrix3d R =
        Eigen::Quaterniond(lambda(0), lambda(1), lambda(2), lambda(3)).toRotationMatrix();
    // Rotation about the centre, and the centre's velocity; omega in body axes.
    const Vector3d omega = random_vector(3, engine), centre = random_vector(3, engine);
    LocalVector u(14), v(14);
    for (const int end : {0, 1}) {
      const Vector3d b = (end - 0.5) * l_0;
      u.segment<3>(7 * end) = R * b - b;
      v.segment<3>(7 * end) = centre + R * omega.cross(b);
      u.segment<4>(7 * end + 3) = lambda - Vector4::Unit(0);
      v.segment<4>(7 * end + 3) = euler_rate(lambda, omega);
    }
    const double expected = 0.5 * m * centre.squaredNorm() + 0.5 * omega.dot(J * omega);
    EXPECT_NEAR(mass.kinetic_energy(u, v), expected, 1e-14 * expected);
    LocalHessian M(14, 14);
    mass.mass(u, M);
    const LocalVector momentum = M * v;
    EXPECT_LE((momentum.head<3>() + momentum.segment<3>(7) - m * centre).norm(), 1e-14 * m);
  }
}

TEST(BeamMass, FallsFreelyAndWeighsItsMass) {
  const Vector3d l_0(0.9, -0.5, 0.4), g(0.3, -9.7, 1.1);
  const BeamMass mass(0, 1, l_0, mass_per_length, inertia_per_length);
  LocalVector a = LocalVector::Zero(14), F(14);
  const LocalVector zero = LocalVector::Zero(14);
  mass.force(zero, zero, a, g, F);
  const Vector3d weight = mass_per_length * l_0.norm() * g;
  EXPECT_LE((F.head<3>() + F.segment<3>(7) + weight).norm(), 1e-15 * weight.norm());
  a.head<3>() = a.segment<3>(7) = g;
  mass.force(zero, zero, a, g, F);
  EXPECT_EQ(F.norm(), 0.0);
}

TEST(BeamMass, SpinsAboutItsAxisWithoutForce) {
  const Vector3d l_0(0.9, -0.5, 0.4), n_x = l_0.normalized();
  const BeamMass mass(0, 1, l_0, mass_per_length, inertia_per_length);
  const double angle = 2.1, rate = 50.0, acceleration = 7.0;
  const Vector4 lambda(std::cos(angle / 2), std::sin(angle / 2) * n_x.x(),
                       std::sin(angle / 2) * n_x.y(), std::sin(angle / 2) * n_x.z());
  const Vector4 v_rotation = euler_rate(lambda, rate * n_x);
  LocalVector u = LocalVector::Zero(14), v = u, a = u, F(14);
  for (const int at : {3, 10}) {
    u.segment<4>(at) = lambda - Vector4::Unit(0);
    v.segment<4>(at) = v_rotation;
    a.segment<4>(at) = euler_rate(lambda, acceleration * n_x) - lambda * v_rotation.squaredNorm();
  }
  mass.force(u, v, a, Vector3d::Zero(), F);
  // Centripetal terms of 2500 1/s^2 cancel; what is left is their rounding.
  const double rounding = 1e-14 * rate * rate;
  EXPECT_LE(F.head<3>().norm() + F.segment<3>(7).norm(), rounding);
  Vector3d torque = Vector3d::Zero();
  for (const int at : {3, 10}) torque += 0.5 * body_rate_matrix(lambda) * F.segment<4>(at);
  const Vector3d expected = inertia_per_length * l_0.norm() * acceleration * n_x;
  EXPECT_LE((torque - expected).norm(), rounding);
}

TEST(PlanarBeamMass, InARigidMotionItIsASlenderBar) {
  const Vector3d l_0(0.9, -0.5, 0);
  const double l = l_0.norm(), m = mass_per_length * l, angle = 2.3, omega = 1.7;
  const PlanarBeamMass mass(0, 1, l_0, mass_per_length);
  const Matrix3d R = Eigen::AngleAxisd(angle, Vector3d::UnitZ()).toRotationMatrix();
  const Vector3d centre(0.4, -1.1, 0);
  LocalVector u(8), v(8);
  for (const int end : {0, 1}) {
    const Vector3d b = (end - 0.5) * l_0;
    u.segment<4>(4 * end) << R * b - b, angle;
    v.segment<4>(4 * end) << centre + omega * Vector3d::UnitZ().cross(R * b), omega;
  }
  const double expected = 0.5 * m * centre.squaredNorm() + 0.5 * m * l * l / 12 * omega * omega;
  EXPECT_NEAR(mass.kinetic_energy(u, v), expected, 1e-14 * expected);
  LocalHessian M(8, 8);
  mass.mass(u, M);
  const LocalVector momentum = M * v;
  EXPECT_LE((momentum.head<3>() + momentum.segment<3>(4) - m * centre).norm(), 1e-14 * m);
}

TEST(PlanarBeamMass, IsThatOfTheSpatialBeamInThePlane) {
  const Vector3d l_0(0.9, -0.5, 0), g(0.3, -9.7, 0);
  const PlanarBeamMass planar(0, 1, l_0, mass_per_length);
  const BeamMass spatial(0, 1, l_0, mass_per_length, inertia_per_length);
  std::mt19937 engine(31);
  for (int k = 0; k < 10; ++k) {
    const VectorXd u = random_vector(8, engine), v = random_vector(8, engine),
                   a = random_vector(8, engine);
    LocalVector u_s(14), v_s(14), a_s(14), F(8), F_s(14);
    // lambda = (cos, 0, 0, sin) of half the angle, and its derivative to the angle.
    Vector4 along[2];
    for (const int end : {0, 1}) {
      const double half = 0.5 * u(4 * end + 3), rate = v(4 * end + 3);
      const Vector4 lambda(std::cos(half), 0, 0, std::sin(half));
      along[end] = 0.5 * Vector4(-std::sin(half), 0, 0, std::cos(half));
      u_s.segment<7>(7 * end) << u.segment<3>(4 * end), lambda - Vector4::Unit(0);
      v_s.segment<7>(7 * end) << v.segment<3>(4 * end), rate * along[end];
      a_s.segment<7>(7 * end) << a.segment<3>(4 * end),
          a(4 * end + 3) * along[end] - 0.25 * rate * rate * lambda;
    }
    planar.force(u, v, a, g, F);
    spatial.force(u_s, v_s, a_s, g, F_s);
    for (const int end : {0, 1}) {
      EXPECT_LE((F.segment<3>(4 * end) - F_s.segment<3>(7 * end)).norm(), 1e-14 * F.norm());
      EXPECT_NEAR(F(4 * end + 3), along[end].dot(F_s.segment<4>(7 * end + 3)), 1e-14 * F.norm());
    }
  }
}

}  // namespace
}  // namespace stillframe::test

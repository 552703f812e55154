#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

#include "core/mechanics/dynamics.hpp"
#include "core/mechanics/elements/beam.hpp"
#include "core/mechanics/elements/second_order.hpp"
#include "core/mechanics/linearisation/linearisation.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/numerics/worst.hpp"
#include "tests/core/differences.hpp"
#include "tests/core/scenes.hpp"

// One beam element with second-order terms against the elastica's second order: what shortens a
// leaf spring when it is bent, and what stiffens it when it is pulled.
namespace stillframe::test {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double L = 0.4, EI = 2.0;

/// A leaf spring along x from a clamp, which does not stretch. guided: its tip is held from
/// turning, as by the second spring of a pair. q^d: the deflection of the tip, then the angle if it
/// may turn.
struct Leaf {
  bool planar = true, second_order = true, guided = true;
  Vector3d sideways = Vector3d::UnitY(), tip_force = Vector3d::Zero();
};

SceneElement leaf_element(const Leaf& leaf) {
  SceneElement element;
  element.name = "leaf";
  element.kind = SceneElement::Kind::beam;
  element.node_p = "clamp";
  element.node_q = "tip";
  element.n_deformations = leaf.planar ? 3 : 6;
  element.zero.assign(static_cast<size_t>(element.n_deformations), false);
  element.zero[0] = true;
  element.stiffness = element.damping =
      MatrixXd::Zero(element.n_deformations, element.n_deformations);
  element.preload = VectorXd::Zero(element.n_deformations);
  element.beam.EI_y = element.beam.EI_z = element.beam.GJ = EI;
  element.beam.mass_per_length = 0.1;
  element.beam.orientation = Vector3d::UnitY();
  element.beam.second_order = leaf.second_order;
  return element;
}

Scene leaf_scene(const Leaf& leaf) {
  Scene scene;
  scene.title = scene.file = scene.dofs_place = "leaf";
  scene.planar = leaf.planar;
  scene.nodes = {{"clamp", "", Vector3d::Zero()}, {"tip", "", Vector3d(L, 0, 0)}};
  scene.elements = {leaf_element(leaf)};
  SceneConstraint clamp, guide;
  clamp.node = "clamp";
  clamp.directions = {Vector3d::UnitX(), Vector3d::UnitY()};
  if (!leaf.planar) clamp.directions.push_back(Vector3d::UnitZ());
  clamp.rotation = true;
  guide.node = "tip";
  guide.rotation = leaf.guided;
  if (!leaf.planar) guide.directions = {Vector3d::UnitX().cross(leaf.sideways)};
  scene.supports = {clamp, guide};
  scene.dofs = {dof_along("tip", leaf.sideways)};
  if (!leaf.guided) {
    SceneDof& angle = scene.dofs.emplace_back();
    angle.node = "tip";
    angle.rotation = true;
  }
  if (leaf.tip_force.norm() > 0) scene.loads = {force_at("tip", leaf.tip_force)};
  return scene;
}

double shortening(const Model& model, const Data& data) {
  return -model.translation_row(model.node_index("tip"), Vector3d::UnitX()).dot(data.x);
}

TEST(LeafSpring, OneElementShortensLikeTheBentArc) {
  for (const bool planar : {true, false}) {
    for (const Vector3d& sideways : {Vector3d(0, 1, 0), Vector3d(0, 0, 1)}) {
      if (planar && sideways.z() != 0) continue;
      for (const bool second_order : {true, false}) {
        const Model model =
            make_model(leaf_scene({planar, second_order, true, sideways, Vector3d::Zero()}));
        Data data(model);
        for (const double u : {1e-5, 1e-3, 0.02}) {
          ASSERT_TRUE(
              solve_positions(model, data, position_state(model, VectorXd::Constant(1, u))));
          // V11: 0.6 u^2 / L of an S-shaped leaf, 0.5 u^2 / L of its chord; the next order is
          // (u / L)^2 of it with factors below one.
          const double wanted = (second_order ? 0.6 : 0.5) * u * u / L;
          EXPECT_NEAR(shortening(model, data), wanted, u * u / (L * L) * wanted + 1e-15 * u) << u;
          // The element's own geometry exactly: the chord is shorter than the arc by 0.1 u^2 / L.
          const double chord = L - (second_order ? 0.1 * u * u / L : 0.0);
          EXPECT_NEAR(shortening(model, data), L - std::sqrt(chord * chord - u * u), 2e-16);
        }
      }
    }
  }
}

TEST(LeafSpring, OneElementUnderATipLoadIsTheCantileverToTheSecondOrder) {
  const double P = 0.3;
  const Model model =
      make_model(leaf_scene({true, true, false, Vector3d::UnitY(), P * Vector3d::UnitY()}));
  Data data(model);
  VectorXd q = VectorXd::Zero(2);
  const auto unbalance = [&](const VectorXd& at) -> VectorXd {
    EXPECT_TRUE(
        generalised_forces(model, data, position_state(model, at), VectorXd::Zero(model.n_e)));
    return data.f_dd;
  };
  for (int iteration = 0; iteration < 8; ++iteration) {
    MatrixXd slope(2, 2);
    for (Index i = 0; i < 2; ++i) {
      slope.col(i) =
          derivative([&](double t) { return unbalance(q + t * VectorXd::Unit(2, i)); }, 1e-3);
    }
    q -= slope.lu().solve(unbalance(q));
  }
  EXPECT_LE(unbalance(q).norm(), 1e-14);
  const double u = P * L * L * L / (3 * EI);
  // Of second order and higher: (u / L)^2 = 6.4e-5 and factors of order one.
  const double next = std::pow(u / L, 2);
  EXPECT_NEAR(q(0), u, 2 * next * u);
  EXPECT_NEAR(q(1), 1.5 * u / L, 2 * next * u / L);
  EXPECT_NEAR(shortening(model, data), 0.6 * u * u / L, 2 * next * u * u / L);
}

TEST(LeafSpring, APulledElementHasTheConsistentGeometricStiffness) {
  const double N = 7.0;
  for (const bool second_order : {true, false}) {
    const Scene scene =
        leaf_scene({true, second_order, false, Vector3d::UnitY(), N * Vector3d::UnitX()});
    const LinearModel m = linearise(make_model(scene), {}, {});
    MatrixXd G(2, 2), K(2, 2);
    G << 36, -3 * L, -3 * L, 4 * L * L;
    G *= N / (30 * L);
    if (!second_order) G << N / L, 0, 0, 0;
    K << 12, -6 * L, -6 * L, 4 * L * L;
    K *= EI / (L * L * L);
    EXPECT_LE(relative_error(m.G, G), 1e-14);
    EXPECT_LE(relative_error(m.K, K), 1e-14);
  }
  // Guided and in space, either way: 1.2 N / L.
  for (const Vector3d& sideways : {Vector3d(0, 1, 0), Vector3d(0, 0.6, 0.8)}) {
    const Scene scene = leaf_scene({false, true, true, sideways, N * Vector3d::UnitX()});
    const LinearModel m = linearise(make_model(scene), {}, {});
    EXPECT_NEAR(m.G(0, 0), 1.2 * N / L, 1e-13);
    EXPECT_NEAR(m.K(0, 0), 12 * EI / (L * L * L), 1e-11);
  }
}

/// The displacements of a beam (14) along x whose axis does not stretch and whose curvatures in
/// axes that turn with it are epsilon times given ones, linear in s, with the shear that goes with
/// their slope: in these axes the tangent stands off by -+ Phi l_0^2 / 12 times it.
LocalVector bent_beam(double epsilon, const Vector3d& curvature_p, const Vector3d& curvature_q,
                      double Phi_y, double Phi_z) {
  constexpr int n = 400;
  const double h = L / n;
  Vector3d at = Vector3d::Zero();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  const Vector3d slope = epsilon * (curvature_q - curvature_p) / L;
  Vector3d tangent(0, -Phi_z * L * L / 12 * slope.z(), Phi_y * L * L / 12 * slope.y());
  tangent.x() = std::sqrt(1 - tangent.squaredNorm());
  const auto turn = [&](double s, double step) {
    const Vector3d angle =
        step * epsilon * (curvature_p + (s + step / 2) / L * (curvature_q - curvature_p));
    return Eigen::Quaterniond(Eigen::AngleAxisd(angle.norm(), angle.normalized()));
  };
  // Midpoint rule, of the second order.
  for (int k = 0; k < n; ++k) {
    at += h * ((rotation * turn(k * h, h / 2)) * tangent);
    rotation = rotation * turn(k * h, h);
  }
  LocalVector u = LocalVector::Zero(14);
  u.segment<3>(7) = at - L * Vector3d::UnitX();
  u.segment<4>(10) << rotation.w() - 1, rotation.vec();
  return u;
}

TEST(SecondOrderBeam, ASpaceCurveHasNoDeformationsOfSecondOrder) {
  const Vector3d l_0 = L * Vector3d::UnitX();
  const Beam plain(0, 1, l_0, Vector3d::UnitY());
  const double epsilon = 1e-2;
  std::mt19937 engine(61);
  for (const auto& [Phi_y, Phi_z] : {std::pair(0.0, 0.0), {0.7, 0.0}, {0.0, 2.5}, {1.5, 0.4}}) {
    const SecondOrder beam(std::make_unique<Beam>(0, 1, l_0, Vector3d::UnitY()),
                           spatial_second_order_terms(L, Phi_y, Phi_z));
    for (int k = 0; k < 5; ++k) {
      // Radians per metre: twist constant, bending linear.
      const Vector3d p = 3 * random_vector(3, engine);
      Vector3d q = 3 * random_vector(3, engine);
      q.x() = p.x();
      const auto even_part = [&](const Element& element) {
        LocalDeformation e(6), mirrored(6);
        element.deformations(bent_beam(epsilon, p, q, Phi_y, Phi_z), e);
        element.deformations(bent_beam(-epsilon, p, q, Phi_y, Phi_z), mirrored);
        return VectorXd((e + mirrored) / (2 * epsilon * epsilon * L));
      };
      // What is even in epsilon and left is of the fourth order, epsilon^2 (1.2 rad)^4, and the
      // midpoint rule's h^2 / L^2 = 6e-6.
      EXPECT_LE(worst_of(even_part(beam)), 2e-4)
          << Phi_y << " " << Phi_z << ": " << even_part(beam).transpose();
      EXPECT_GT(worst_of(even_part(plain)), 5e-3);
    }
  }
}

}  // namespace
}  // namespace stillframe::test

#pragma once

#include <functional>
#include <memory>
#include <random>
#include <stdexcept>
#include <string>

#include "core/mechanics/elements/arm_truss.hpp"
#include "core/mechanics/elements/beam.hpp"
#include "core/mechanics/elements/hinge.hpp"
#include "core/mechanics/elements/norm_condition.hpp"
#include "core/mechanics/elements/planar_beam.hpp"
#include "core/mechanics/elements/planar_hinge.hpp"
#include "core/mechanics/elements/rotation.hpp"
#include "core/mechanics/elements/second_order.hpp"
#include "core/mechanics/elements/superelement.hpp"
#include "core/mechanics/elements/truss.hpp"
#include "tests/core/element_formulas.hpp"

// Every kind of element beside its formula, and random states of it.
namespace stillframe::test {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

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

struct Case {
  std::unique_ptr<const Element> element;
  std::function<std::vector<HyperDual>(const std::vector<HyperDual>&)> formula;
  std::function<std::vector<Dual<HyperDual>>(const std::vector<Dual<HyperDual>>&)> third_formula;
  std::function<std::vector<Quad>(const std::vector<Quad>&)> exact_formula;
  Eigen::Vector3d l_0;
  Eigen::Vector3d between = l_0;  ///< from node to node, where that is not l_0
};

template <class Formula>
Case case_of(std::unique_ptr<const Element> element, const Formula& formula,
             const Eigen::Vector3d& l_0) {
  return {std::move(element), formula, formula, formula, l_0, l_0};
}

/// Symmetric matrices for every deformation, of the size of a length's reciprocal.
inline std::vector<LocalStiffness> any_terms(Index n_e) {
  Random random(29);
  std::vector<LocalStiffness> terms;
  for (Index i = 0; i < n_e; ++i) {
    const MatrixXd A = random.vector(n_e * n_e).reshaped(n_e, n_e);
    terms.emplace_back(0.1 * (A + A.transpose()));
  }
  return terms;
}

/// kinds: truss, arm_truss and one_arm_truss, beam, planar_beam, hinge, planar_hinge, superelement,
/// norm; arc_beam and planar_arc_beam with the second-order terms of a beam, quadratic_beam with
/// terms in every deformation.
inline Case make_case(const std::string& kind, Eigen::Vector3d l_0) {
  if (kind == "truss") {
    return case_of(
        std::make_unique<Truss>(0, 1, l_0), [l_0](const auto& u) { return truss_formula(l_0, u); },
        l_0);
  }
  if (kind.ends_with("arm_truss")) {
    const Eigen::Vector3d arm_p(0.3, -0.7, 0.2);
    const Eigen::Vector3d arm_q =
        kind == "arm_truss" ? Eigen::Vector3d(-0.4, 0.1, 0.8) : Eigen::Vector3d::Zero();
    Case c = case_of(
        std::make_unique<ArmTruss>(0, 1, l_0, arm_p, arm_q),
        [=](const auto& u) { return arm_truss_formula(l_0, arm_p, arm_q, u); }, l_0);
    c.between = l_0 + arm_p - arm_q;
    return c;
  }
  if (kind.starts_with("planar")) l_0.z() = 0;
  if (kind == "planar_hinge") {
    return case_of(
        std::make_unique<PlanarHinge>(0, 1), [](const auto& u) { return std::vector{u[1] - u[0]}; },
        l_0);
  }
  if (kind == "planar_beam") {
    return case_of(
        std::make_unique<PlanarBeam>(0, 1, l_0),
        [l_0](const auto& u) { return planar_beam_formula(l_0, u); }, l_0);
  }
  if (kind == "planar_arc_beam") {
    auto inner = std::make_unique<PlanarBeam>(0, 1, l_0);
    return case_of(
        std::make_unique<SecondOrder>(std::move(inner), planar_second_order_terms(l_0.norm(), 0)),
        [l_0](const auto& u) { return arc_formula(l_0, planar_beam_formula(l_0, u)); }, l_0);
  }
  if (kind == "hinge") {
    return case_of(
        std::make_unique<Hinge>(0, 1, l_0), [l_0](const auto& u) { return hinge_formula(l_0, u); },
        l_0);
  }
  if (kind == "norm") {
    return case_of(
        std::make_unique<NormCondition>(0), [](const auto& u) { return norm_formula(u); }, l_0);
  }
  if (kind == "superelement") {
    Eigen::Matrix3Xd s(3, 2);
    s << Eigen::Vector3d::Zero(), l_0;
    return case_of(
        std::make_unique<Superelement>(std::vector<Index>{0, 1}, s, std::vector<Index>{}, 0),
        [l_0](const auto& u) { return superelement_formula(l_0, u); }, l_0);
  }
  // Neither a unit vector nor perpendicular to the beam.
  const Eigen::Vector3d orientation = 0.4 * l_0 + 2.0 * l_0.unitOrthogonal();
  auto beam = std::make_unique<Beam>(0, 1, l_0, orientation);
  if (kind == "beam") {
    return case_of(
        std::move(beam), [=](const auto& u) { return beam_formula(l_0, orientation, u); }, l_0);
  }
  if (kind == "arc_beam") {
    return case_of(
        std::make_unique<SecondOrder>(std::move(beam),
                                      spatial_second_order_terms(l_0.norm(), 0, 0)),
        [=](const auto& u) { return arc_formula(l_0, beam_formula(l_0, orientation, u)); }, l_0);
  }
  if (kind != "quadratic_beam") throw std::invalid_argument("there is no element '" + kind + "'");
  const auto terms = any_terms(6);
  return case_of(
      std::make_unique<SecondOrder>(std::move(beam), terms),
      [=](const auto& u) { return with_quadratic_terms(terms, beam_formula(l_0, orientation, u)); },
      l_0);
}

/// Displacements of the size of the element, and rotations of any angle.
inline LocalVector random_state(const Element& element, const Eigen::Vector3d& l_0,
                                Random& random) {
  LocalVector u(element.n_local());
  Index at = 0;
  for (const NodePart& part : element.parts()) {
    if (part.kind == NodePart::Kind::rotation) {
      u.segment<4>(at) = random.quaternion() - Vector4::Unit(0);
    } else if (part.kind == NodePart::Kind::angle) {
      u(at) = 2.0 * random.vector(1)(0);
    } else {
      u.segment<3>(at) = 0.5 * l_0.norm() * random.vector(3);
    }
    at += part.size();
  }
  return u;
}

/// Second derivative of each deformation in directions v and w; v's first derivative in d1.
inline std::vector<HyperDual> differentiate(const Case& c, const LocalVector& u, const VectorXd& v,
                                            const VectorXd& w) {
  std::vector<HyperDual> seeded;
  for (Index i = 0; i < u.size(); ++i) seeded.push_back(hyper_dual(u(i), v(i), w(i)));
  return c.formula(seeded);
}

inline std::vector<Quad> exact(const Case& c, const LocalVector& u) {
  return c.exact_formula(std::vector<Quad>(u.data(), u.data() + u.size()));
}

}  // namespace stillframe::test

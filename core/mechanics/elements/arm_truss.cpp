#include "core/mechanics/elements/arm_truss.hpp"

#include <stdexcept>

#include "core/mechanics/elements/rotation.hpp"
#include "core/mechanics/elements/span.hpp"

namespace stillframe {

namespace {

std::vector<NodePart> parts_of(Eigen::Index p, Eigen::Index q, bool p_turns, bool q_turns) {
  std::vector<NodePart> parts{translation_of(p)};
  if (p_turns) parts.push_back(rotation_of(p));
  parts.push_back(translation_of(q));
  if (q_turns) parts.push_back(rotation_of(q));
  return parts;
}

}  // namespace

ArmTruss::ArmTruss(Eigen::Index node_p, Eigen::Index node_q, const Eigen::Vector3d& l_0_vector,
                   const Eigen::Vector3d& arm_p, const Eigen::Vector3d& arm_q)
    : Element(parts_of(node_p, node_q, !arm_p.isZero(0), !arm_q.isZero(0)), 1),
      l_0_vector_(l_0_vector),
      l_0_(l_0_vector.norm()) {
  if (!(l_0_ > 0)) throw std::invalid_argument("ArmTruss: zero length");
  const Eigen::Index q = arm_p.isZero(0) ? 3 : 7;
  ends_[0] = {arm_p, 0, arm_p.isZero(0) ? -1 : 3, -1.0};
  ends_[1] = {arm_q, q, arm_q.isZero(0) ? -1 : q + 3, 1.0};
}

Eigen::Vector3d ArmTruss::displacement(const LocalVector& u) const noexcept {
  Eigen::Vector3d d = Eigen::Vector3d::Zero();
  for (const End& end : ends_) {
    d += end.sign * u.segment<3>(end.at);
    if (end.rotation < 0) continue;
    const Vector4 lambda = euler_parameters(u.segment<4>(end.rotation));
    d += end.sign * rotation_form(lambda, lambda, end.arm);
  }
  return d;
}

Eigen::Vector3d ArmTruss::rate(const LocalVector& u, const LocalVector& v) const noexcept {
  Eigen::Vector3d d = Eigen::Vector3d::Zero();
  for (const End& end : ends_) {
    d += end.sign * v.segment<3>(end.at);
    if (end.rotation < 0) continue;
    d += 2.0 * end.sign *
         rotation_form(euler_parameters(u.segment<4>(end.rotation)), v.segment<4>(end.rotation),
                       end.arm);
  }
  return d;
}

Eigen::Vector3d ArmTruss::second(const LocalVector& v, const LocalVector& w) const noexcept {
  Eigen::Vector3d d = Eigen::Vector3d::Zero();
  for (const End& end : ends_) {
    if (end.rotation < 0) continue;
    d += 2.0 * end.sign *
         rotation_form(v.segment<4>(end.rotation), w.segment<4>(end.rotation), end.arm);
  }
  return d;
}

void ArmTruss::row(const Eigen::Vector3d& direction, const LocalVector& u,
                   Row& out) const noexcept {
  out.resize(n_local());
  for (const End& end : ends_) {
    out.segment<3>(end.at) = end.sign * direction.transpose();
    if (end.rotation < 0) continue;
    out.segment<4>(end.rotation) =
        end.sign * direction.transpose() *
        d_rotated_d_lambda(euler_parameters(u.segment<4>(end.rotation)), end.arm);
  }
}

void ArmTruss::turning_row(const Eigen::Vector3d& direction, const LocalVector& v,
                           Row& out) const noexcept {
  out.setZero(n_local());
  for (const End& end : ends_) {
    if (end.rotation < 0) continue;
    out.segment<4>(end.rotation) =
        end.sign * direction.transpose() * d_rotated_d_lambda(v.segment<4>(end.rotation), end.arm);
  }
}

void ArmTruss::deformations(const LocalVector& u, LocalDeformation& e) const noexcept {
  e(0) = Span(l_0_vector_, l_0_, displacement(u)).elongation;
}

void ArmTruss::jacobian(const LocalVector& u, JacobianOut d_e_d_u) const noexcept {
  Row derivative;
  row(Span(l_0_vector_, l_0_, displacement(u)).direction, u, derivative);
  d_e_d_u = derivative;
}

void ArmTruss::second_derivative(const LocalVector& u, const LocalVector& v, const LocalVector& w,
                                 LocalDeformation& result) const noexcept {
  const Span span(l_0_vector_, l_0_, displacement(u));
  result(0) = span.second(rate(u, v), rate(u, w)) + span.direction.dot(second(v, w));
}

void ArmTruss::jacobian_rates(const LocalVector& u, const LocalVector& v, const LocalVector& a,
                              JacobianOut rate_out, JacobianOut second_rate) const noexcept {
  const Span span(l_0_vector_, l_0_, displacement(u));
  const Eigen::Vector3d d_rate = rate(u, v);
  const auto directions = span.direction_rates(d_rate, rate(u, a) + second(v, v));
  // D = n^T A(lambda), A linear in lambda: D' = n'^T A + n^T A(lambda'), and so on.
  Row with_u, with_v, with_a;
  row(directions.first, u, with_u);
  turning_row(span.direction, v, with_v);
  rate_out = with_u + with_v;
  row(directions.second, u, with_u);
  turning_row(directions.first, v, with_v);
  turning_row(span.direction, a, with_a);
  second_rate = with_u + 2.0 * with_v + with_a;
}

void ArmTruss::hessian(const LocalVector& u, const LocalDeformation& sigma,
                       LocalHessian& result) const noexcept {
  const Span span(l_0_vector_, l_0_, displacement(u));
  Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, max_local> A(3, n_local());
  Row axis;
  for (int i = 0; i < 3; ++i) {
    row(Eigen::Vector3d::Unit(i), u, axis);
    A.row(i) = axis;
  }
  result.noalias() = A.transpose() * (sigma(0) * span.curvature()) * A;
  for (const End& end : ends_) {
    if (end.rotation < 0) continue;
    result.block<4, 4>(end.rotation, end.rotation) +=
        sigma(0) * end.sign * rotated_hessian(span.direction, end.arm);
  }
}

}  // namespace stillframe

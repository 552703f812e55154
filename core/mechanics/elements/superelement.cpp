#include "core/mechanics/elements/superelement.hpp"

#include <stdexcept>
#include <string>

#include "core/mechanics/elements/rotation.hpp"

namespace stillframe {

namespace {

using Index = Eigen::Index;
using Matrix34 = Eigen::Matrix<double, 3, 4>;

constexpr Index position(Index k) { return 7 * k; }
constexpr Index rotation(Index k) { return 7 * k + 3; }
constexpr Index row_of(Index k) { return 6 * (k - 1); }

/// Euler parameters of the inverse rotation: R(inverse(lambda)) = R(lambda)^T. Linear, so that it
/// goes for rates as well.
Vector4 inverse(const Vector4& lambda) { return {lambda(0), -lambda(1), -lambda(2), -lambda(3)}; }

/// d(R(lambda)^T n)/d lambda from the same of R.
Matrix34 of_inverse(Matrix34 derivative) {
  derivative.rightCols<3>() *= -1.0;
  return derivative;
}
Matrix34 d_turned_back(const Vector4& lambda, const Vector3& n) {
  return of_inverse(d_rotated_d_lambda(inverse(lambda), n));
}

/// The matrix of n -> 2 B(inverse(a), inverse(b)) n: twice R^T - I, or derivatives of R^T.
Eigen::Matrix3d form_matrix(const Vector4& a, const Vector4& b) {
  Eigen::Matrix3d matrix;
  for (int i = 0; i < 3; ++i) {
    matrix.col(i) = 2.0 * rotation_form(inverse(a), inverse(b), Vector3::Unit(i));
  }
  return matrix;
}

Vector3 between(const LocalVector& u, Index k) {
  return u.segment<3>(position(k)) - u.segment<3>(position(0));
}
Vector4 rate_of(const LocalVector& v, Index k) { return v.segment<4>(rotation(k)); }
Vector4 parameters_of(const LocalVector& u, Index k) {
  return euler_parameters(u.segment<4>(rotation(k)));
}

std::vector<NodePart> parts_of(const std::vector<Index>& nodes,
                               const std::vector<Index>& mode_nodes) {
  std::vector<NodePart> parts;
  for (const Index node : nodes) {
    parts.push_back(translation_of(node));
    parts.push_back(rotation_of(node));
  }
  for (const Index node : mode_nodes) parts.push_back(translation_of(node));
  return parts;
}

}  // namespace

Superelement::Superelement(const std::vector<Index>& nodes, const Eigen::Matrix3Xd& s,
                           const std::vector<Index>& mode_nodes, Index n_modes)
    : Element(parts_of(nodes, mode_nodes), 6 * (static_cast<Index>(nodes.size()) - 1) + n_modes),
      s_(s) {
  if (n_deformations() < 1) {
    throw std::invalid_argument("one interface and no modes: that is a rigid body");
  }
  if (n_deformations() > max_deformations || n_local() > max_local) {
    throw std::invalid_argument(
        std::to_string(nodes.size()) + " interfaces and " + std::to_string(n_modes) +
        " modes are too many: 7 coordinates an interface and 3 for every 3 modes may be " +
        std::to_string(max_local) + " together");
  }
}

void Superelement::deformations(const LocalVector& u, LocalDeformation& e) const noexcept {
  const Vector4 lambda = parameters_of(u, 0), back = inverse(lambda);
  const auto rates = body_rate_matrix(lambda);
  for (Index k = 1; k < n_nodes(); ++k) {
    const Vector3 d = between(u, k);
    e.segment<3>(row_of(k)) = d + rotation_form(back, back, s_.col(k) + d);
    e.segment<3>(row_of(k) + 3) = 2.0 * rates * parameters_of(u, k);
  }
  e.tail(n_modes()) = u.segment(position(n_nodes()), n_modes());
}

void Superelement::jacobian(const LocalVector& u, JacobianOut D) const noexcept {
  const Vector4 lambda = parameters_of(u, 0);
  const Eigen::Matrix3d R_T = Eigen::Matrix3d::Identity() + 0.5 * form_matrix(lambda, lambda);
  const Matrix34 rates = 2.0 * body_rate_matrix(lambda);
  D.setZero();
  for (Index k = 1; k < n_nodes(); ++k) {
    const Index row = row_of(k);
    D.block<3, 3>(row, position(0)) = -R_T;
    D.block<3, 3>(row, position(k)) = R_T;
    D.block<3, 4>(row, rotation(0)) = d_turned_back(lambda, s_.col(k) + between(u, k));
    D.block<3, 4>(row + 3, rotation(0)) = -2.0 * body_rate_matrix(parameters_of(u, k));
    D.block<3, 4>(row + 3, rotation(k)) = rates;
  }
  for (Index i = 0; i < n_modes(); ++i) D(row_of(n_nodes()) + i, position(n_nodes()) + i) = 1.0;
}

void Superelement::second_derivative(const LocalVector& u, const LocalVector& v,
                                     const LocalVector& w,
                                     LocalDeformation& result) const noexcept {
  const Vector4 back = inverse(parameters_of(u, 0));
  const Vector4 v_1 = rate_of(v, 0), w_1 = rate_of(w, 0);
  const Vector4 v_back = inverse(v_1), w_back = inverse(w_1);
  for (Index k = 1; k < n_nodes(); ++k) {
    result.segment<3>(row_of(k)) = 2.0 * (rotation_form(v_back, w_back, s_.col(k) + between(u, k)) +
                                          rotation_form(back, v_back, between(w, k)) +
                                          rotation_form(back, w_back, between(v, k)));
    result.segment<3>(row_of(k) + 3) =
        2.0 * (body_rate_matrix(v_1) * rate_of(w, k) + body_rate_matrix(w_1) * rate_of(v, k));
  }
  result.tail(n_modes()).setZero();
}

void Superelement::jacobian_rates(const LocalVector& u, const LocalVector& v, const LocalVector& a,
                                  JacobianOut rate, JacobianOut second_rate) const noexcept {
  const Vector4 lambda = parameters_of(u, 0), v_1 = rate_of(v, 0), a_1 = rate_of(a, 0);
  const Eigen::Matrix3d R_1 = form_matrix(lambda, v_1);
  const Eigen::Matrix3d R_2 = form_matrix(v_1, v_1) + form_matrix(lambda, a_1);
  rate.setZero();
  second_rate.setZero();
  for (Index k = 1; k < n_nodes(); ++k) {
    const Index row = row_of(k);
    const Vector3 l = s_.col(k) + between(u, k), l_1 = between(v, k), l_2 = between(a, k);
    rate.block<3, 3>(row, position(0)) = -R_1;
    rate.block<3, 3>(row, position(k)) = R_1;
    rate.block<3, 4>(row, rotation(0)) = d_turned_back(v_1, l) + d_turned_back(lambda, l_1);
    rate.block<3, 4>(row + 3, rotation(0)) = -2.0 * body_rate_matrix(rate_of(v, k));
    rate.block<3, 4>(row + 3, rotation(k)) = 2.0 * body_rate_matrix(v_1);
    second_rate.block<3, 3>(row, position(0)) = -R_2;
    second_rate.block<3, 3>(row, position(k)) = R_2;
    second_rate.block<3, 4>(row, rotation(0)) =
        d_turned_back(a_1, l) + 2.0 * d_turned_back(v_1, l_1) + d_turned_back(lambda, l_2);
    second_rate.block<3, 4>(row + 3, rotation(0)) = -2.0 * body_rate_matrix(rate_of(a, k));
    second_rate.block<3, 4>(row + 3, rotation(k)) = 2.0 * body_rate_matrix(a_1);
  }
}

void Superelement::hessian(const LocalVector& u, const LocalDeformation& sigma,
                           LocalHessian& H) const noexcept {
  const Vector4 lambda = parameters_of(u, 0);
  H.setZero();
  for (Index k = 1; k < n_nodes(); ++k) {
    const Vector3 force = sigma.segment<3>(row_of(k)), moment = sigma.segment<3>(row_of(k) + 3);
    // force . R(lambda)^T l is l . R(lambda) force.
    H.block<4, 4>(rotation(0), rotation(0)) += rotated_hessian(s_.col(k) + between(u, k), force);
    const Matrix34 mixed = d_rotated_d_lambda(lambda, force);
    H.block<3, 4>(position(k), rotation(0)) += mixed;
    H.block<4, 3>(rotation(0), position(k)) += mixed.transpose();
    H.block<3, 4>(position(0), rotation(0)) -= mixed;
    H.block<4, 3>(rotation(0), position(0)) -= mixed.transpose();
    const Eigen::Matrix4d turns = 2.0 * d_body_rate_dual(moment);
    H.block<4, 4>(rotation(k), rotation(0)) += turns;
    H.block<4, 4>(rotation(0), rotation(k)) += turns.transpose();
  }
}

}  // namespace stillframe

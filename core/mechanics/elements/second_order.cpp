#include "core/mechanics/elements/second_order.hpp"

namespace stillframe {

SecondOrder::SecondOrder(std::unique_ptr<const Element> inner, std::vector<LocalStiffness> terms)
    : Element(inner->parts(), inner->n_deformations()),
      inner_(std::move(inner)),
      terms_(std::move(terms)) {}

LocalStiffness SecondOrder::rows(const LocalDeformation& c) const noexcept {
  LocalStiffness result(c.size(), c.size());
  for (size_t i = 0; i < terms_.size(); ++i) {
    result.row(static_cast<Eigen::Index>(i)).noalias() = (terms_[i] * c).transpose();
  }
  return result;
}

LocalStiffness SecondOrder::with_identity(const LocalDeformation& c) const noexcept {
  LocalStiffness result = rows(c);
  result.diagonal().array() += 1.0;
  return result;
}

void SecondOrder::deformations(const LocalVector& u, LocalDeformation& e) const noexcept {
  LocalDeformation c(n_deformations());
  inner_->deformations(u, c);
  e.noalias() = 0.5 * rows(c) * c;
  e += c;
}

void SecondOrder::jacobian(const LocalVector& u, JacobianOut d_e_d_u) const noexcept {
  LocalDeformation c(n_deformations());
  LocalJacobian D(n_deformations(), n_local());
  inner_->deformations(u, c);
  inner_->jacobian(u, D);
  d_e_d_u.noalias() = with_identity(c) * D;
}

void SecondOrder::second_derivative(const LocalVector& u, const LocalVector& v,
                                    const LocalVector& w, LocalDeformation& result) const noexcept {
  LocalDeformation c(n_deformations()), c_vw(n_deformations());
  LocalJacobian D(n_deformations(), n_local());
  inner_->deformations(u, c);
  inner_->jacobian(u, D);
  inner_->second_derivative(u, v, w, c_vw);
  const LocalDeformation c_v = D * v, c_w = D * w;
  result.noalias() = with_identity(c) * c_vw;
  result.noalias() += rows(c_v) * c_w;
}

void SecondOrder::jacobian_rates(const LocalVector& u, const LocalVector& v, const LocalVector& a,
                                 JacobianOut rate, JacobianOut second_rate) const noexcept {
  const Eigen::Index n_e = n_deformations();
  LocalDeformation c(n_e);
  LocalJacobian D(n_e, n_local()), D_1(n_e, n_local()), D_2(n_e, n_local());
  inner_->deformations(u, c);
  inner_->jacobian(u, D);
  inner_->jacobian_rates(u, v, a, D_1, D_2);
  const LocalDeformation c_1 = D * v, c_2 = D * a + D_1 * v;
  const LocalStiffness T = with_identity(c), T_1 = rows(c_1), T_2 = rows(c_2);
  rate.noalias() = T * D_1;
  rate.noalias() += T_1 * D;
  second_rate.noalias() = T * D_2;
  second_rate.noalias() += 2.0 * T_1 * D_1;
  second_rate.noalias() += T_2 * D;
}

void SecondOrder::hessian(const LocalVector& u, const LocalDeformation& sigma,
                          LocalHessian& result) const noexcept {
  const Eigen::Index n_e = n_deformations();
  LocalDeformation c(n_e);
  LocalJacobian D(n_e, n_local());
  inner_->deformations(u, c);
  inner_->jacobian(u, D);
  const LocalDeformation chord_sigma = with_identity(c).transpose() * sigma;
  inner_->hessian(u, chord_sigma, result);
  LocalStiffness Q = LocalStiffness::Zero(n_e, n_e);
  for (Eigen::Index i = 0; i < n_e; ++i) Q += sigma(i) * terms_[static_cast<size_t>(i)];
  const LocalJacobian QD = Q * D;
  result.noalias() += D.transpose() * QD;
}

namespace {

/// (5 s^2 + 3 t^2 eta^2) / 30 l_0 of s = (a + b) / 2, t = (a - b) / 2: shortening of an arc that
/// leaves its chord by a / l_0 and b / l_0, of which ends that turn alike, t, bend it by eta t
/// only.
void add_shortening(LocalStiffness& Q, Eigen::Index first, double l_0, double eta) {
  const double same = 2.5 + 1.5 * eta * eta, other = 2.5 - 1.5 * eta * eta;
  Eigen::Matrix2d block;
  block << same, other, other, same;
  Q.block<2, 2>(first, first) += block / (30 * l_0);
}

}  // namespace

std::vector<LocalStiffness> planar_second_order_terms(double l_0, double Phi) {
  std::vector<LocalStiffness> terms(3, LocalStiffness::Zero(3, 3));
  add_shortening(terms[0], 1, l_0, 1 / (1 + Phi));
  return terms;
}

std::vector<LocalStiffness> spatial_second_order_terms(double l_0, double Phi_y, double Phi_z) {
  const double eta_y = 1 / (1 + Phi_y), eta_z = 1 / (1 + Phi_z);
  std::vector<LocalStiffness> terms(6, LocalStiffness::Zero(6, 6));
  add_shortening(terms[0], 2, l_0, eta_y);
  add_shortening(terms[0], 4, l_0, eta_z);
  const auto add = [&](Eigen::Index i, Eigen::Index j, Eigen::Index k, double factor) {
    LocalStiffness& Q = terms[static_cast<size_t>(i)];
    Q(j, k) = Q(k, j) = factor / l_0;
  };
  // Torsion of an axis bent both ways, ((c_3 + c_4)(c_5 - c_6) eta_z - (c_3 - c_4)(c_5 + c_6)
  // eta_y) / (2 l_0); without shear (c_4 c_5 - c_3 c_6) / l_0.
  const double mean = (eta_y + eta_z) / 2, half = (eta_z - eta_y) / 2;
  add(1, 2, 5, -mean);
  add(1, 3, 4, mean);
  add(1, 2, 4, half);
  add(1, 3, 5, -half);
  // Bending in axes that turn with the twist: +- c_2 (c_5 + c_6) / (6 l_0), -+ c_2 (c_3 + c_4) /
  // (6 l_0); and what is sheared keeps its direction while the axes turn.
  const double sheared_y = (1 - eta_y) / 4, sheared_z = (1 - eta_z) / 4;
  add(2, 1, 4, 1.0 / 6 + sheared_z);
  add(2, 1, 5, 1.0 / 6 - sheared_z);
  add(3, 1, 4, -1.0 / 6 + sheared_z);
  add(3, 1, 5, -1.0 / 6 - sheared_z);
  add(4, 1, 2, -1.0 / 6 - sheared_y);
  add(4, 1, 3, -1.0 / 6 + sheared_y);
  add(5, 1, 2, 1.0 / 6 - sheared_y);
  add(5, 1, 3, 1.0 / 6 + sheared_y);
  return terms;
}

}  // namespace stillframe

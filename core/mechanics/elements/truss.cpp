#include "core/mechanics/elements/truss.hpp"

#include <stdexcept>

#include "core/mechanics/elements/span.hpp"

namespace stillframe {

namespace {

Eigen::Vector3d difference(const LocalVector& u) { return u.segment<3>(3) - u.segment<3>(0); }

}  // namespace

Truss::Truss(Eigen::Index node_p, Eigen::Index node_q, const Eigen::Vector3d& l_0_vector)
    : Element({translation_of(node_p), translation_of(node_q)}, 1),
      l_0_vector_(l_0_vector),
      l_0_(l_0_vector.norm()) {
  if (!(l_0_ > 0)) throw std::invalid_argument("Truss: zero length");
}

void Truss::deformations(const LocalVector& u, LocalDeformation& e) const noexcept {
  e(0) = Span(l_0_vector_, l_0_, difference(u)).elongation;
}

void Truss::jacobian(const LocalVector& u, JacobianOut d_e_d_u) const noexcept {
  const Span span(l_0_vector_, l_0_, difference(u));
  d_e_d_u << -span.direction.transpose(), span.direction.transpose();
}

void Truss::second_derivative(const LocalVector& u, const LocalVector& v, const LocalVector& w,
                              LocalDeformation& result) const noexcept {
  result(0) = Span(l_0_vector_, l_0_, difference(u)).second(difference(v), difference(w));
}

void Truss::jacobian_rates(const LocalVector& u, const LocalVector& v, const LocalVector& a,
                           JacobianOut rate, JacobianOut second_rate) const noexcept {
  const auto rates =
      Span(l_0_vector_, l_0_, difference(u)).direction_rates(difference(v), difference(a));
  rate << -rates.first.transpose(), rates.first.transpose();
  second_rate << -rates.second.transpose(), rates.second.transpose();
}

void Truss::hessian(const LocalVector& u, const LocalDeformation& sigma,
                    LocalHessian& result) const noexcept {
  const Eigen::Matrix3d H = sigma(0) * Span(l_0_vector_, l_0_, difference(u)).curvature();
  result << H, -H, -H, H;
}

}  // namespace stillframe

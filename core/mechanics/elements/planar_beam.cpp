#include "core/mechanics/elements/planar_beam.hpp"

#include <stdexcept>

#include "core/mechanics/elements/planar_rotation.hpp"
#include "core/mechanics/elements/span.hpp"

namespace stillframe {

namespace {

using Eigen::Vector3d;

constexpr int p_position = 0, p_angle = 3, q_position = 4, q_angle = 7;

Vector3d difference(const LocalVector& u) {
  return u.segment<3>(q_position) - u.segment<3>(p_position);
}

/// The bending deformations are sign * (R_end n_y) . l.
struct Bending {
  int angle;
  double sign;
};
constexpr Bending bendings[2] = {{p_angle, -1.0}, {q_angle, 1.0}};

}  // namespace

PlanarBeam::PlanarBeam(Eigen::Index node_p, Eigen::Index node_q, const Vector3d& l_0_vector)
    : Element({translation_of(node_p), angle_of(node_p), translation_of(node_q), angle_of(node_q)},
              3),
      l_0_vector_(l_0_vector),
      l_0_(l_0_vector.norm()) {
  if (!(l_0_ > 0)) throw std::invalid_argument("PlanarBeam: zero length");
  n_y_ = quarter_turned(l_0_vector / l_0_);
}

void PlanarBeam::deformations(const LocalVector& u, LocalDeformation& e) const noexcept {
  const Vector3d d = difference(u);
  const Span span(l_0_vector_, l_0_, d);
  e(0) = span.elongation;
  for (int i = 0; i < 2; ++i) {
    // n_y . l_0 = 0 on paper: only the differences from the scene as written are summed.
    e(1 + i) =
        bendings[i].sign * (turned_by(u(bendings[i].angle), n_y_).dot(span.l_vector) + n_y_.dot(d));
  }
}

void PlanarBeam::jacobian(const LocalVector& u, JacobianOut D) const noexcept {
  const Span span(l_0_vector_, l_0_, difference(u));
  D.setZero();
  D.block<1, 3>(0, p_position) = -span.direction.transpose();
  D.block<1, 3>(0, q_position) = span.direction.transpose();
  for (int i = 0; i < 2; ++i) {
    const auto [angle, sign] = bendings[i];
    const Vector3d n = n_y_ + turned_by(u(angle), n_y_);
    D.block<1, 3>(1 + i, p_position) = -sign * n.transpose();
    D.block<1, 3>(1 + i, q_position) = sign * n.transpose();
    D(1 + i, angle) = sign * quarter_turned(n).dot(span.l_vector);
  }
}

void PlanarBeam::second_derivative(const LocalVector& u, const LocalVector& v, const LocalVector& w,
                                   LocalDeformation& result) const noexcept {
  const Span span(l_0_vector_, l_0_, difference(u));
  const Vector3d dv = difference(v), dw = difference(w);
  result(0) = span.second(dv, dw);
  for (int i = 0; i < 2; ++i) {
    const auto [angle, sign] = bendings[i];
    const Vector3d n = n_y_ + turned_by(u(angle), n_y_), t = quarter_turned(n);
    result(1 + i) = sign * (-v(angle) * w(angle) * n.dot(span.l_vector) + v(angle) * t.dot(dw) +
                            w(angle) * t.dot(dv));
  }
}

void PlanarBeam::jacobian_rates(const LocalVector& u, const LocalVector& v, const LocalVector& a,
                                JacobianOut rate, JacobianOut second_rate) const noexcept {
  const Span span(l_0_vector_, l_0_, difference(u));
  const Vector3d l = span.l_vector, l_1 = difference(v), l_2 = difference(a);
  rate.setZero();
  second_rate.setZero();
  const auto elongation = span.direction_rates(l_1, l_2);
  rate.block<1, 3>(0, p_position) = -elongation.first.transpose();
  rate.block<1, 3>(0, q_position) = elongation.first.transpose();
  second_rate.block<1, 3>(0, p_position) = -elongation.second.transpose();
  second_rate.block<1, 3>(0, q_position) = elongation.second.transpose();
  for (int i = 0; i < 2; ++i) {
    const auto [angle, sign] = bendings[i];
    // n and t = dn/dphi, each with two time derivatives: n' = phi' t, t' = -phi' n.
    const Vector3d n = n_y_ + turned_by(u(angle), n_y_), t = quarter_turned(n);
    const double w = v(angle), w_1 = a(angle);
    const Vector3d n_1 = w * t, n_2 = w_1 * t - w * w * n;
    const Vector3d t_1 = -w * n, t_2 = -w_1 * n - w * w * t;
    rate.block<1, 3>(1 + i, p_position) = -sign * n_1.transpose();
    rate.block<1, 3>(1 + i, q_position) = sign * n_1.transpose();
    rate(1 + i, angle) = sign * (t_1.dot(l) + t.dot(l_1));
    second_rate.block<1, 3>(1 + i, p_position) = -sign * n_2.transpose();
    second_rate.block<1, 3>(1 + i, q_position) = sign * n_2.transpose();
    second_rate(1 + i, angle) = sign * (t_2.dot(l) + 2.0 * t_1.dot(l_1) + t.dot(l_2));
  }
}

void PlanarBeam::hessian(const LocalVector& u, const LocalDeformation& sigma,
                         LocalHessian& H) const noexcept {
  const Span span(l_0_vector_, l_0_, difference(u));
  H.setZero();
  const Eigen::Matrix3d curvature = sigma(0) * span.curvature();
  H.block<3, 3>(p_position, p_position) = curvature;
  H.block<3, 3>(q_position, q_position) = curvature;
  H.block<3, 3>(p_position, q_position) = -curvature;
  H.block<3, 3>(q_position, p_position) = -curvature;
  for (int i = 0; i < 2; ++i) {
    const int angle = bendings[i].angle;
    const double s = bendings[i].sign * sigma(1 + i);
    const Vector3d n = n_y_ + turned_by(u(angle), n_y_), t = s * quarter_turned(n);
    H(angle, angle) -= s * n.dot(span.l_vector);
    H.block<3, 1>(q_position, angle) += t;
    H.block<1, 3>(angle, q_position) += t.transpose();
    H.block<3, 1>(p_position, angle) -= t;
    H.block<1, 3>(angle, p_position) -= t.transpose();
  }
}

}  // namespace stillframe

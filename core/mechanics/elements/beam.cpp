#include "core/mechanics/elements/beam.hpp"

#include <stdexcept>

#include "core/mechanics/elements/rotation.hpp"
#include "core/mechanics/elements/span.hpp"

namespace stillframe {

namespace {

constexpr int p_position = 0, p_rotation = 3, q_position = 7, q_rotation = 10;

Vector3 difference(const LocalVector& u) {
  return u.segment<3>(q_position) - u.segment<3>(p_position);
}

/// The four bending deformations are sign * (R_end n) . l; this table says which end, axis and
/// sign.
struct Bending {
  int rotation;
  bool about_z;
  double sign;
};
constexpr Bending bendings[4] = {{p_rotation, true, -1.0},
                                 {q_rotation, true, 1.0},
                                 {p_rotation, false, 1.0},
                                 {q_rotation, false, -1.0}};

}  // namespace

Beam::Beam(Eigen::Index node_p, Eigen::Index node_q, const Eigen::Vector3d& l_0_vector,
           const Eigen::Vector3d& orientation)
    : Element({translation_of(node_p), rotation_of(node_p), translation_of(node_q),
               rotation_of(node_q)},
              6),
      l_0_vector_(l_0_vector),
      l_0_(l_0_vector.norm()) {
  if (!(l_0_ > 0)) throw std::invalid_argument("Beam: zero length");
  const Vector3 n_x = l_0_vector / l_0_;
  n_z_ = n_x.cross(orientation);
  if (!(n_z_.norm() > 1e-6 * orientation.norm())) {
    throw std::invalid_argument("Beam: the orientation is parallel to the beam");
  }
  n_z_.normalize();
  n_y_ = n_z_.cross(n_x);
}

Eigen::Vector3d any_orientation(const Eigen::Vector3d& l_0_vector) {
  return l_0_vector.unitOrthogonal();
}

void Beam::deformations(const LocalVector& u, LocalDeformation& e) const noexcept {
  const Vector3 d = difference(u);
  const Span span(l_0_vector_, l_0_, d);
  e(0) = span.elongation;
  const Vector4 lambda_p = euler_parameters(u.segment<4>(p_rotation));
  const Vector4 lambda_q = euler_parameters(u.segment<4>(q_rotation));
  // With r = (R - I) n the constant parts of every product cancel on paper, not in floating point.
  const Vector3 py = rotation_form(lambda_p, lambda_p, n_y_);
  const Vector3 pz = rotation_form(lambda_p, lambda_p, n_z_);
  const Vector3 qy = rotation_form(lambda_q, lambda_q, n_y_);
  const Vector3 qz = rotation_form(lambda_q, lambda_q, n_z_);
  e(1) = 0.5 * l_0_ *
         (n_z_.dot(qy) + pz.dot(n_y_) + pz.dot(qy) - n_y_.dot(qz) - py.dot(n_z_) - py.dot(qz));
  for (int i = 0; i < 4; ++i) {
    const bool at_p = bendings[i].rotation == p_rotation;
    const Vector3& n = bendings[i].about_z ? n_z_ : n_y_;
    const Vector3& r = bendings[i].about_z ? (at_p ? pz : qz) : (at_p ? py : qy);
    e(2 + i) = bendings[i].sign * (r.dot(span.l_vector) + n.dot(d));
  }
}

void Beam::jacobian(const LocalVector& u, JacobianOut D) const noexcept {
  const Span span(l_0_vector_, l_0_, difference(u));
  const Vector4 lambda_p = euler_parameters(u.segment<4>(p_rotation));
  const Vector4 lambda_q = euler_parameters(u.segment<4>(q_rotation));
  D.setZero();
  D.block<1, 3>(0, p_position) = -span.direction.transpose();
  D.block<1, 3>(0, q_position) = span.direction.transpose();

  const auto rotated = [](const Vector4& lambda, const Vector3& n) -> Vector3 {
    return n + rotation_form(lambda, lambda, n);
  };
  const double h = 0.5 * l_0_;
  D.block<1, 4>(1, p_rotation) =
      h * (rotated(lambda_q, n_y_).transpose() * d_rotated_d_lambda(lambda_p, n_z_) -
           rotated(lambda_q, n_z_).transpose() * d_rotated_d_lambda(lambda_p, n_y_));
  D.block<1, 4>(1, q_rotation) =
      h * (rotated(lambda_p, n_z_).transpose() * d_rotated_d_lambda(lambda_q, n_y_) -
           rotated(lambda_p, n_y_).transpose() * d_rotated_d_lambda(lambda_q, n_z_));
  for (int i = 0; i < 4; ++i) {
    const Vector3& n = bendings[i].about_z ? n_z_ : n_y_;
    const Vector4& lambda = bendings[i].rotation == p_rotation ? lambda_p : lambda_q;
    const Vector3 r = bendings[i].sign * rotated(lambda, n);
    D.block<1, 3>(2 + i, p_position) = -r.transpose();
    D.block<1, 3>(2 + i, q_position) = r.transpose();
    D.block<1, 4>(2 + i, bendings[i].rotation) =
        bendings[i].sign * span.l_vector.transpose() * d_rotated_d_lambda(lambda, n);
  }
}

void Beam::second_derivative(const LocalVector& u, const LocalVector& v, const LocalVector& w,
                             LocalDeformation& result) const noexcept {
  const Span span(l_0_vector_, l_0_, difference(u));
  const Vector3 dv = difference(v), dw = difference(w);
  result(0) = span.second(dv, dw);

  /// R n and its derivatives in the directions v, w and (v, w), for the end whose rotation starts
  /// at r.
  struct Rotated {
    Vector3 value, in_v, in_w, in_vw;
    Rotated(const LocalVector& u, const LocalVector& v, const LocalVector& w, int r,
            const Vector3& n) {
      const Vector4 lambda = euler_parameters(u.segment<4>(r));
      value = n + rotation_form(lambda, lambda, n);
      in_v = 2.0 * rotation_form(lambda, v.segment<4>(r), n);
      in_w = 2.0 * rotation_form(lambda, w.segment<4>(r), n);
      in_vw = 2.0 * rotation_form(v.segment<4>(r), w.segment<4>(r), n);
    }
    double second_of_product(const Rotated& b) const {
      return in_vw.dot(b.value) + in_v.dot(b.in_w) + in_w.dot(b.in_v) + value.dot(b.in_vw);
    }
  };
  const Rotated py(u, v, w, p_rotation, n_y_), pz(u, v, w, p_rotation, n_z_);
  const Rotated qy(u, v, w, q_rotation, n_y_), qz(u, v, w, q_rotation, n_z_);
  result(1) = 0.5 * l_0_ * (pz.second_of_product(qy) - py.second_of_product(qz));
  for (int i = 0; i < 4; ++i) {
    const bool at_p = bendings[i].rotation == p_rotation;
    const Rotated& r = bendings[i].about_z ? (at_p ? pz : qz) : (at_p ? py : qy);
    result(2 + i) =
        bendings[i].sign * (r.in_vw.dot(span.l_vector) + r.in_v.dot(dw) + r.in_w.dot(dv));
  }
}

void Beam::jacobian_rates(const LocalVector& u, const LocalVector& v, const LocalVector& a,
                          JacobianOut rate, JacobianOut second_rate) const noexcept {
  const Span span(l_0_vector_, l_0_, difference(u));
  const Vector3 l[3] = {span.l_vector, difference(v), difference(a)};
  const auto axis = [&](int r, const Vector3& n) {
    return TurningAxis(euler_parameters(u.segment<4>(r)), v.segment<4>(r), a.segment<4>(r), n);
  };
  const TurningAxis py = axis(p_rotation, n_y_), pz = axis(p_rotation, n_z_);
  const TurningAxis qy = axis(q_rotation, n_y_), qz = axis(q_rotation, n_z_);
  rate.setZero();
  second_rate.setZero();

  const auto elongation = span.direction_rates(l[1], l[2]);
  rate.block<1, 3>(0, p_position) = -elongation.first.transpose();
  rate.block<1, 3>(0, q_position) = elongation.first.transpose();
  second_rate.block<1, 3>(0, p_position) = -elongation.second.transpose();
  second_rate.block<1, 3>(0, q_position) = elongation.second.transpose();

  // Derivatives of b . (R a) to the rotation of a, once and twice differentiated in time.
  const auto first = [](const TurningAxis& a_axis, const Vector3* b) -> Eigen::RowVector4d {
    return b[0].transpose() * a_axis.derivative[1] + b[1].transpose() * a_axis.derivative[0];
  };
  const auto second = [](const TurningAxis& a_axis, const Vector3* b) -> Eigen::RowVector4d {
    return b[0].transpose() * a_axis.derivative[2] + 2.0 * b[1].transpose() * a_axis.derivative[1] +
           b[2].transpose() * a_axis.derivative[0];
  };
  const double h = 0.5 * l_0_;
  rate.block<1, 4>(1, p_rotation) = h * (first(pz, qy.value) - first(py, qz.value));
  rate.block<1, 4>(1, q_rotation) = h * (first(qy, pz.value) - first(qz, py.value));
  second_rate.block<1, 4>(1, p_rotation) = h * (second(pz, qy.value) - second(py, qz.value));
  second_rate.block<1, 4>(1, q_rotation) = h * (second(qy, pz.value) - second(qz, py.value));
  for (int i = 0; i < 4; ++i) {
    const auto [r, about_z, sign] = bendings[i];
    const TurningAxis& n = r == p_rotation ? (about_z ? pz : py) : (about_z ? qz : qy);
    rate.block<1, 3>(2 + i, p_position) = -sign * n.value[1].transpose();
    rate.block<1, 3>(2 + i, q_position) = sign * n.value[1].transpose();
    rate.block<1, 4>(2 + i, r) = sign * first(n, l);
    second_rate.block<1, 3>(2 + i, p_position) = -sign * n.value[2].transpose();
    second_rate.block<1, 3>(2 + i, q_position) = sign * n.value[2].transpose();
    second_rate.block<1, 4>(2 + i, r) = sign * second(n, l);
  }
}

void Beam::hessian(const LocalVector& u, const LocalDeformation& sigma,
                   LocalHessian& H) const noexcept {
  const Span span(l_0_vector_, l_0_, difference(u));
  const Vector4 lambda_p = euler_parameters(u.segment<4>(p_rotation));
  const Vector4 lambda_q = euler_parameters(u.segment<4>(q_rotation));
  H.setZero();
  const Eigen::Matrix3d curvature = sigma(0) * span.curvature();
  H.block<3, 3>(p_position, p_position) = curvature;
  H.block<3, 3>(q_position, q_position) = curvature;
  H.block<3, 3>(p_position, q_position) = -curvature;
  H.block<3, 3>(q_position, p_position) = -curvature;

  const double torsion = 0.5 * l_0_ * sigma(1);
  const Vector3 py = n_y_ + rotation_form(lambda_p, lambda_p, n_y_);
  const Vector3 pz = n_z_ + rotation_form(lambda_p, lambda_p, n_z_);
  const Vector3 qy = n_y_ + rotation_form(lambda_q, lambda_q, n_y_);
  const Vector3 qz = n_z_ + rotation_form(lambda_q, lambda_q, n_z_);
  H.block<4, 4>(p_rotation, p_rotation) +=
      torsion * (rotated_hessian(qy, n_z_) - rotated_hessian(qz, n_y_));
  H.block<4, 4>(q_rotation, q_rotation) +=
      torsion * (rotated_hessian(pz, n_y_) - rotated_hessian(py, n_z_));
  const Eigen::Matrix4d mixed =
      torsion *
      (d_rotated_d_lambda(lambda_p, n_z_).transpose() * d_rotated_d_lambda(lambda_q, n_y_) -
       d_rotated_d_lambda(lambda_p, n_y_).transpose() * d_rotated_d_lambda(lambda_q, n_z_));
  H.block<4, 4>(p_rotation, q_rotation) += mixed;
  H.block<4, 4>(q_rotation, p_rotation) += mixed.transpose();

  for (int i = 0; i < 4; ++i) {
    const double s = bendings[i].sign * sigma(2 + i);
    const int r = bendings[i].rotation;
    const Vector3& n = bendings[i].about_z ? n_z_ : n_y_;
    const Vector4& lambda = r == p_rotation ? lambda_p : lambda_q;
    H.block<4, 4>(r, r) += s * rotated_hessian(span.l_vector, n);
    const Eigen::Matrix<double, 3, 4> derivative = s * d_rotated_d_lambda(lambda, n);
    H.block<3, 4>(q_position, r) += derivative;
    H.block<4, 3>(r, q_position) += derivative.transpose();
    H.block<3, 4>(p_position, r) -= derivative;
    H.block<4, 3>(r, p_position) -= derivative.transpose();
  }
}

}  // namespace stillframe

#include "core/mechanics/elements/hinge.hpp"

#include <numbers>
#include <stdexcept>

#include "core/mechanics/elements/rotation.hpp"

namespace stillframe {

namespace {

using Complex = std::complex<double>;
constexpr int p = 0, q = 4;

}  // namespace

Hinge::Hinge(Eigen::Index node_p, Eigen::Index node_q, const Eigen::Vector3d& axis)
    : Element({rotation_of(node_p), rotation_of(node_q)}, 3) {
  if (!(axis.norm() > 0)) throw std::invalid_argument("Hinge: the axis is zero");
  n_x_ = axis.normalized();
  tilt_[1] = n_x_.unitOrthogonal();
  tilt_[0] = -n_x_.cross(tilt_[1]);
  // conj(lambda_p) lambda_q = (lambda_p . lambda_q, lambda_p0 v_q - lambda_q0 v_p - v_p x v_q).
  Z_.setIdentity();
  const Complex i(0, 1);
  Z_.block<1, 3>(0, 1) = i * n_x_.transpose();
  Z_.block<3, 1>(1, 0) = -i * n_x_;
  Z_.bottomRightCorner<3, 3>() += i * cross_matrix(n_x_).cast<Complex>();
}

double Hinge::period() const noexcept { return 4 * std::numbers::pi; }

void Hinge::deformations(const LocalVector& u, LocalDeformation& e) const noexcept {
  const Vector4 lambda_p = euler_parameters(u.segment<4>(p));
  const Vector4 lambda_q = euler_parameters(u.segment<4>(q));
  e(0) = 2.0 * std::arg(Complex(lambda_p.transpose() * (Z_ * lambda_q)));
  const Vector3 qx = rotation_form(lambda_q, lambda_q, n_x_);
  for (int k = 0; k < 2; ++k) {
    // With r = (R - I) n the constant parts cancel on paper, not in floating point.
    const Vector3 r = rotation_form(lambda_p, lambda_p, tilt_[k]);
    e(1 + k) = r.dot(n_x_) + tilt_[k].dot(qx) + r.dot(qx);
  }
}

void Hinge::jacobian(const LocalVector& u, JacobianOut D) const noexcept {
  const Vector4 lambda_p = euler_parameters(u.segment<4>(p));
  const Vector4 lambda_q = euler_parameters(u.segment<4>(q));
  const Vector4c z_p = Z_ * lambda_q, z_q = Z_.transpose() * lambda_p;
  const Complex z = lambda_p.transpose() * z_p;
  D.block<1, 4>(0, p) = 2.0 * (z_p / z).imag().transpose();
  D.block<1, 4>(0, q) = 2.0 * (z_q / z).imag().transpose();
  const Vector3 qx = n_x_ + rotation_form(lambda_q, lambda_q, n_x_);
  for (int k = 0; k < 2; ++k) {
    const Vector3 r = tilt_[k] + rotation_form(lambda_p, lambda_p, tilt_[k]);
    D.block<1, 4>(1 + k, p) = qx.transpose() * d_rotated_d_lambda(lambda_p, tilt_[k]);
    D.block<1, 4>(1 + k, q) = r.transpose() * d_rotated_d_lambda(lambda_q, n_x_);
  }
}

void Hinge::second_derivative(const LocalVector& u, const LocalVector& v, const LocalVector& w,
                              LocalDeformation& result) const noexcept {
  const Vector4 lambda_p = euler_parameters(u.segment<4>(p));
  const Vector4 lambda_q = euler_parameters(u.segment<4>(q));
  const Vector4 vp = v.segment<4>(p), vq = v.segment<4>(q);
  const Vector4 wp = w.segment<4>(p), wq = w.segment<4>(q);
  const auto Z = [&](const Vector4& a, const Vector4& b) -> Complex {
    return a.transpose() * (Z_ * b);
  };
  const Complex z = Z(lambda_p, lambda_q);
  const Complex in_v = Z(vp, lambda_q) + Z(lambda_p, vq), in_w = Z(wp, lambda_q) + Z(lambda_p, wq);
  result(0) = 2.0 * ((Z(vp, wq) + Z(wp, vq)) / z - in_v * in_w / (z * z)).imag();
  const auto turned = [](const Vector4& a, const Vector4& b, const Vector3& n) {
    return rotation_form(a, b, n);
  };
  const Vector3 qx = n_x_ + turned(lambda_q, lambda_q, n_x_);
  for (int k = 0; k < 2; ++k) {
    const Vector3 r = tilt_[k] + turned(lambda_p, lambda_p, tilt_[k]);
    result(1 + k) = 2.0 * turned(vp, wp, tilt_[k]).dot(qx) + 2.0 * r.dot(turned(vq, wq, n_x_)) +
                    4.0 * turned(lambda_p, vp, tilt_[k]).dot(turned(lambda_q, wq, n_x_)) +
                    4.0 * turned(lambda_p, wp, tilt_[k]).dot(turned(lambda_q, vq, n_x_));
  }
}

void Hinge::jacobian_rates(const LocalVector& u, const LocalVector& v, const LocalVector& a,
                           JacobianOut rate, JacobianOut second_rate) const noexcept {
  const Vector4 lambda[2] = {euler_parameters(u.segment<4>(p)), euler_parameters(u.segment<4>(q))};
  const Vector4 vp = v.segment<4>(p), vq = v.segment<4>(q);
  const Vector4 ap = a.segment<4>(p), aq = a.segment<4>(q);
  const Vector4c z_p = Z_ * lambda[1], z_q = Z_.transpose() * lambda[0];
  const Vector4c z_p1 = Z_ * vq, z_q1 = Z_.transpose() * vp;
  const Vector4c z_p2 = Z_ * aq, z_q2 = Z_.transpose() * ap;
  const auto dot = [](const Vector4& b, const Vector4c& c) -> Complex { return b.transpose() * c; };
  const Complex z = dot(lambda[0], z_p);
  const Complex z_1 = (dot(vp, z_p) + dot(vq, z_q)) / z;
  const Complex z_2 = (dot(ap, z_p) + 2.0 * dot(vp, z_p1) + dot(aq, z_q)) / z;
  // d/dt and d2/dt2 of z_i / z, with z_1 = z'/z and z_2 = z''/z.
  const auto first = [&](const Vector4c& c, const Vector4c& c_1) -> Eigen::RowVector4d {
    return 2.0 * ((c_1 - c * z_1) / z).imag().transpose();
  };
  const auto second = [&](const Vector4c& c, const Vector4c& c_1,
                          const Vector4c& c_2) -> Eigen::RowVector4d {
    return 2.0 * ((c_2 - 2.0 * c_1 * z_1 - c * z_2 + 2.0 * c * (z_1 * z_1)) / z).imag().transpose();
  };
  rate.block<1, 4>(0, p) = first(z_p, z_p1);
  rate.block<1, 4>(0, q) = first(z_q, z_q1);
  second_rate.block<1, 4>(0, p) = second(z_p, z_p1, z_p2);
  second_rate.block<1, 4>(0, q) = second(z_q, z_q1, z_q2);

  const TurningAxis qx(lambda[1], vq, aq, n_x_);
  const auto one = [](const TurningAxis& n, const TurningAxis& b) -> Eigen::RowVector4d {
    return b.value[0].transpose() * n.derivative[1] + b.value[1].transpose() * n.derivative[0];
  };
  const auto two = [](const TurningAxis& n, const TurningAxis& b) -> Eigen::RowVector4d {
    return b.value[0].transpose() * n.derivative[2] +
           2.0 * b.value[1].transpose() * n.derivative[1] +
           b.value[2].transpose() * n.derivative[0];
  };
  for (int k = 0; k < 2; ++k) {
    const TurningAxis tilt(lambda[0], vp, ap, tilt_[k]);
    rate.block<1, 4>(1 + k, p) = one(tilt, qx);
    rate.block<1, 4>(1 + k, q) = one(qx, tilt);
    second_rate.block<1, 4>(1 + k, p) = two(tilt, qx);
    second_rate.block<1, 4>(1 + k, q) = two(qx, tilt);
  }
}

void Hinge::hessian(const LocalVector& u, const LocalDeformation& sigma,
                    LocalHessian& H) const noexcept {
  const Vector4 lambda_p = euler_parameters(u.segment<4>(p));
  const Vector4 lambda_q = euler_parameters(u.segment<4>(q));
  Eigen::Matrix<Complex, 8, 1> gradient;
  gradient << Z_ * lambda_q, Z_.transpose() * lambda_p;
  const Complex z = lambda_p.transpose() * gradient.head<4>();
  Eigen::Matrix<Complex, 8, 8> second = -gradient * gradient.transpose() / (z * z);
  second.topRightCorner<4, 4>() += Z_ / z;
  second.bottomLeftCorner<4, 4>() += Z_.transpose() / z;
  H = 2.0 * sigma(0) * second.imag();
  const Vector3 qx = n_x_ + rotation_form(lambda_q, lambda_q, n_x_);
  const Eigen::Matrix<double, 3, 4> Q = d_rotated_d_lambda(lambda_q, n_x_);
  for (int k = 0; k < 2; ++k) {
    const double s = sigma(1 + k);
    const Vector3 r = tilt_[k] + rotation_form(lambda_p, lambda_p, tilt_[k]);
    H.block<4, 4>(p, p) += s * rotated_hessian(qx, tilt_[k]);
    H.block<4, 4>(q, q) += s * rotated_hessian(r, n_x_);
    const Eigen::Matrix4d mixed = s * d_rotated_d_lambda(lambda_p, tilt_[k]).transpose() * Q;
    H.block<4, 4>(p, q) += mixed;
    H.block<4, 4>(q, p) += mixed.transpose();
  }
}

}  // namespace stillframe

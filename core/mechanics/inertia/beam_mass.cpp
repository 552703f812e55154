#include "core/mechanics/inertia/beam_mass.hpp"

#include "core/mechanics/inertia/body.hpp"

namespace stillframe {

namespace {

constexpr int position(int k) { return 7 * k; }
constexpr int rotation(int k) { return 7 * k + 3; }

/// One end: its Euler parameters with rates, the derivative B of its tangent, and its rate about
/// the axis.
struct End {
  Vector4 lambda, v, a;
  Eigen::Matrix<double, 3, 4> B;
  Eigen::Matrix<double, 1, 4> spin;  ///< omega_x = spin lambda'
  double omega = 0, omega_rate = 0;

  End(const LocalVector& u, const Vector3& n_x, int k)
      : lambda(euler_parameters(u.segment<4>(rotation(k)))),
        v(Vector4::Zero()),
        a(Vector4::Zero()),
        B(d_rotated_d_lambda(lambda, n_x)),
        spin(2.0 * n_x.transpose() * body_rate_matrix(lambda)) {}
  End(const LocalVector& u, const LocalVector& rate, const LocalVector& acceleration,
      const Vector3& n_x, int k)
      : End(u, n_x, k) {
    v = rate.segment<4>(rotation(k));
    a = acceleration.segment<4>(rotation(k));
    omega = spin.dot(v);
    omega_rate = spin.dot(a);
  }
};

/// Second time derivatives of (x_p, t_p, x_q, t_q), less gravity.
HermiteVectors accelerations(const End* ends, const LocalVector& a, const Vector3& g,
                             const Vector3& n_x) {
  HermiteVectors w;
  for (int k = 0; k < 2; ++k) {
    w.col(2 * k) = a.segment<3>(position(k)) - g;
    w.col(2 * k + 1) = ends[k].B * ends[k].a + 2.0 * rotation_form(ends[k].v, ends[k].v, n_x);
  }
  return w;
}

}  // namespace

BeamMass::BeamMass(Eigen::Index node_p, Eigen::Index node_q, const Eigen::Vector3d& l_0_vector,
                   double mass_per_length, double inertia_per_length)
    : Inertia({translation_of(node_p), rotation_of(node_p), translation_of(node_q),
               rotation_of(node_q)}),
      n_x_(l_0_vector.normalized()),
      M_(hermite_mass(mass_per_length, l_0_vector.norm())) {
  J_ << 2, 1, 1, 2;
  J_ *= inertia_per_length * l_0_vector.norm() / 6;
}

void BeamMass::mass(const LocalVector& u, LocalHessian& M) const noexcept {
  const End ends[2] = {End(u, n_x_, 0), End(u, n_x_, 1)};
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      M.block<3, 3>(position(i), position(j)) = M_(2 * i, 2 * j) * Eigen::Matrix3d::Identity();
      M.block<3, 4>(position(i), rotation(j)) = M_(2 * i, 2 * j + 1) * ends[j].B;
      M.block<4, 3>(rotation(i), position(j)) = M_(2 * i + 1, 2 * j) * ends[i].B.transpose();
      M.block<4, 4>(rotation(i), rotation(j)) =
          M_(2 * i + 1, 2 * j + 1) * ends[i].B.transpose() * ends[j].B +
          J_(i, j) * ends[i].spin.transpose() * ends[j].spin;
    }
  }
}

void BeamMass::force(const LocalVector& u, const LocalVector& v, const LocalVector& a,
                     const Eigen::Vector3d& g, LocalVector& F) const noexcept {
  const End ends[2] = {End(u, v, a, n_x_, 0), End(u, v, a, n_x_, 1)};
  const HermiteVectors y = accelerations(ends, a, g, n_x_) * M_;
  for (int k = 0; k < 2; ++k) {
    const double p = J_(k, 0) * ends[0].omega + J_(k, 1) * ends[1].omega;
    const double p_rate = J_(k, 0) * ends[0].omega_rate + J_(k, 1) * ends[1].omega_rate;
    F.segment<3>(position(k)) = y.col(2 * k);
    F.segment<4>(rotation(k)) = ends[k].B.transpose() * y.col(2 * k + 1) +
                                rate_force(ends[k].lambda, ends[k].v, p * n_x_, p_rate * n_x_);
  }
}

void BeamMass::tangents(const LocalVector& u, const LocalVector& v, const LocalVector& a,
                        const Eigen::Vector3d& g, LocalHessian& d_F_d_v,
                        LocalHessian& d_F_d_u) const noexcept {
  const End ends[2] = {End(u, v, a, n_x_, 0), End(u, v, a, n_x_, 1)};
  const HermiteVectors y = accelerations(ends, a, g, n_x_) * M_;
  d_F_d_v.setZero();
  d_F_d_u.setZero();
  for (int j = 0; j < 2; ++j) {
    // t'' = B(lambda) lambda'' + 2 B(lambda', lambda') n, by lambda' and by lambda.
    const Eigen::Matrix<double, 3, 4> in_v = 2.0 * d_rotated_d_lambda(ends[j].v, n_x_);
    const Eigen::Matrix<double, 3, 4> in_u = d_rotated_d_lambda(ends[j].a, n_x_);
    // omega = -2 n_x Lambda(lambda') lambda and omega' = -2 n_x Lambda(lambda'') lambda.
    const Eigen::RowVector4d spin_v = 2.0 * n_x_.transpose() * body_rate_matrix(ends[j].v);
    const Eigen::RowVector4d spin_a = 2.0 * n_x_.transpose() * body_rate_matrix(ends[j].a);
    for (int i = 0; i < 2; ++i) {
      const Eigen::RowVector4d spin_v_i = 2.0 * n_x_.transpose() * body_rate_matrix(ends[i].v);
      d_F_d_v.block<3, 4>(position(i), rotation(j)) = M_(2 * i, 2 * j + 1) * in_v;
      d_F_d_u.block<3, 4>(position(i), rotation(j)) = M_(2 * i, 2 * j + 1) * in_u;
      d_F_d_v.block<4, 4>(rotation(i), rotation(j)) =
          M_(2 * i + 1, 2 * j + 1) * ends[i].B.transpose() * in_v +
          2.0 * J_(i, j) * spin_v_i.transpose() * ends[j].spin;
      d_F_d_u.block<4, 4>(rotation(i), rotation(j)) =
          M_(2 * i + 1, 2 * j + 1) * ends[i].B.transpose() * in_u -
          J_(i, j) * (ends[i].spin.transpose() * spin_a + 2.0 * spin_v_i.transpose() * spin_v);
    }
    const double p = J_(j, 0) * ends[0].omega + J_(j, 1) * ends[1].omega;
    const double p_rate = J_(j, 0) * ends[0].omega_rate + J_(j, 1) * ends[1].omega_rate;
    d_F_d_v.block<4, 4>(rotation(j), rotation(j)) += 4.0 * d_body_rate_dual(p * n_x_);
    d_F_d_u.block<4, 4>(rotation(j), rotation(j)) +=
        rotated_hessian(y.col(2 * j + 1), n_x_) + 2.0 * d_body_rate_dual(p_rate * n_x_);
  }
}

double BeamMass::gravity_energy(const LocalVector& u, const Eigen::Vector3d& g) const noexcept {
  HermiteVectors change;
  for (int k = 0; k < 2; ++k) {
    const Vector4 lambda = euler_parameters(u.segment<4>(rotation(k)));
    change.col(2 * k) = u.segment<3>(position(k));
    change.col(2 * k + 1) = rotation_form(lambda, lambda, n_x_);
  }
  return -g.dot(change * (M_.col(0) + M_.col(2)));
}

}  // namespace stillframe

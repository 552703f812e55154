#include "core/mechanics/inertia/planar_beam_mass.hpp"

#include "core/mechanics/elements/planar_rotation.hpp"

namespace stillframe {

namespace {

using Eigen::Vector3d;

/// Local coordinates of end k: position at 4 k, angle at 4 k + 3.
constexpr int position(int k) { return 4 * k; }
constexpr int angle(int k) { return 4 * k + 3; }

/// End tangents t and their derivatives n = dt/dphi.
struct Tangents {
  Vector3d t[2], n[2];
  Tangents(const LocalVector& u, const Vector3d& n_x) {
    for (int k = 0; k < 2; ++k) {
      t[k] = n_x + turned_by(u(angle(k)), n_x);
      n[k] = quarter_turned(t[k]);
    }
  }
};

/// Second time derivatives of (x_p, t_p, x_q, t_q), less gravity.
HermiteVectors accelerations(const Tangents& ends, const LocalVector& v, const LocalVector& a,
                             const Vector3d& g) {
  HermiteVectors w;
  for (int k = 0; k < 2; ++k) {
    const double rate = v(angle(k));
    w.col(2 * k) = a.segment<3>(position(k)) - g;
    w.col(2 * k + 1) = a(angle(k)) * ends.n[k] - rate * rate * ends.t[k];
  }
  return w;
}

}  // namespace

PlanarBeamMass::PlanarBeamMass(Eigen::Index node_p, Eigen::Index node_q, const Vector3d& l_0_vector,
                               double mass_per_length)
    : Inertia({translation_of(node_p), angle_of(node_p), translation_of(node_q), angle_of(node_q)}),
      n_x_(l_0_vector.normalized()),
      M_(hermite_mass(mass_per_length, l_0_vector.norm())) {}

void PlanarBeamMass::mass(const LocalVector& u, LocalHessian& M) const noexcept {
  const Tangents ends(u, n_x_);
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      M.block<3, 3>(position(i), position(j)) = M_(2 * i, 2 * j) * Eigen::Matrix3d::Identity();
      M.block<3, 1>(position(i), angle(j)) = M_(2 * i, 2 * j + 1) * ends.n[j];
      M.block<1, 3>(angle(i), position(j)) = M_(2 * i + 1, 2 * j) * ends.n[i].transpose();
      M(angle(i), angle(j)) = M_(2 * i + 1, 2 * j + 1) * ends.n[i].dot(ends.n[j]);
    }
  }
}

void PlanarBeamMass::force(const LocalVector& u, const LocalVector& v, const LocalVector& a,
                           const Vector3d& g, LocalVector& F) const noexcept {
  const Tangents ends(u, n_x_);
  const HermiteVectors y = accelerations(ends, v, a, g) * M_;
  for (int k = 0; k < 2; ++k) {
    F.segment<3>(position(k)) = y.col(2 * k);
    F(angle(k)) = ends.n[k].dot(y.col(2 * k + 1));
  }
}

void PlanarBeamMass::tangents(const LocalVector& u, const LocalVector& v, const LocalVector& a,
                              const Vector3d& g, LocalHessian& d_F_d_v,
                              LocalHessian& d_F_d_u) const noexcept {
  const Tangents ends(u, n_x_);
  const HermiteVectors y = accelerations(ends, v, a, g) * M_;
  d_F_d_v.setZero();
  d_F_d_u.setZero();
  for (int j = 0; j < 2; ++j) {
    const double w = v(angle(j)), w_1 = a(angle(j));
    // t'' = phi'' n - phi'^2 t changes with phi' and with phi.
    const Vector3d in_v = -2.0 * w * ends.t[j], in_u = -w_1 * ends.t[j] - w * w * ends.n[j];
    for (int i = 0; i < 2; ++i) {
      d_F_d_v.block<3, 1>(position(i), angle(j)) = M_(2 * i, 2 * j + 1) * in_v;
      d_F_d_u.block<3, 1>(position(i), angle(j)) = M_(2 * i, 2 * j + 1) * in_u;
      d_F_d_v(angle(i), angle(j)) = M_(2 * i + 1, 2 * j + 1) * ends.n[i].dot(in_v);
      d_F_d_u(angle(i), angle(j)) = M_(2 * i + 1, 2 * j + 1) * ends.n[i].dot(in_u);
    }
    d_F_d_u(angle(j), angle(j)) -= ends.t[j].dot(y.col(2 * j + 1));
  }
}

double PlanarBeamMass::gravity_energy(const LocalVector& u, const Vector3d& g) const noexcept {
  HermiteVectors change;
  for (int k = 0; k < 2; ++k) {
    change.col(2 * k) = u.segment<3>(position(k));
    change.col(2 * k + 1) = turned_by(u(angle(k)), n_x_);
  }
  return -g.dot(change * (M_.col(0) + M_.col(2)));
}

}  // namespace stillframe

#pragma once

#include "core/mechanics/model/local.hpp"

// What one element or inertia contributes, in node axes, to whoever assembles it: densely in
// minimal coordinates, sparsely in the mixed form, in bands in nodal coordinates. hot.
namespace stillframe {

/// M at the positions x.
inline LocalHessian local_mass(const ModelInertia& item, const Eigen::VectorXd& x) noexcept {
  LocalVector u;
  gather(item.parts, x, u);
  LocalHessian M(u.size(), u.size());
  item.inertia->mass(u, M);
  to_node_axes(item.parts, M);
  return M;
}

/// Geometric stiffness of the stresses sigma of an element: D2^T sigma.
inline LocalHessian stress_stiffness(const ModelElement& item, const Eigen::VectorXd& x,
                                     const LocalDeformation& sigma) noexcept {
  LocalVector u;
  gather(item.parts, x, u);
  LocalHessian H(u.size(), u.size());
  item.element->hessian(u, sigma, H);
  to_node_axes(item.parts, H);
  return H;
}

/// Geometric stiffness of the weight of an inertia in a gravity g.
inline LocalHessian weight_stiffness(const ModelInertia& item, const Eigen::VectorXd& x,
                                     const Eigen::Vector3d& g) noexcept {
  LocalVector u;
  gather(item.parts, x, u);
  const LocalVector rest = LocalVector::Zero(u.size());
  LocalHessian in_v(u.size(), u.size()), in_u(u.size(), u.size());
  item.inertia->tangents(u, rest, rest, g, in_v, in_u);
  to_node_axes(item.parts, in_u);
  return in_u;
}

/// f -= F of every inertia at the positions x, rates x' and accelerations x'', in a gravity g; f:
/// n_x or n_x + n_0, and what it is shorter by is left out.
inline void subtract_inertia_forces(const Model& model, const Eigen::VectorXd& x,
                                    const Eigen::VectorXd& x_dot, const Eigen::VectorXd& x_ddot,
                                    const Eigen::Vector3d& g, Eigen::VectorXd& f) noexcept {
  LocalVector u, v, a, F;
  for (const ModelInertia& item : model.inertias) {
    gather(item.parts, x, u);
    gather(item.parts, x_dot, v);
    gather(item.parts, x_ddot, a);
    F.resize(u.size());
    item.inertia->force(u, v, a, g, F);
    rows_to_node_axes(item.parts, F);
    for_each_column(item.parts, f.size(), [&](Index i, Index column) { f(column) -= F(i); });
  }
}

}  // namespace stillframe

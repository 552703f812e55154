#pragma once

#include "core/mechanics/inertia/inertia.hpp"

namespace stillframe {

/// A point mass, kg, at the translations of a node.
class PointMass final : public Inertia {
 public:
  PointMass(Eigen::Index node, double mass) : Inertia({translation_of(node)}), mass_(mass) {}

  void mass(const LocalVector&, LocalHessian& M) const noexcept override {
    M.setZero();
    M.diagonal().setConstant(mass_);
  }
  void force(const LocalVector&, const LocalVector&, const LocalVector& a, const Eigen::Vector3d& g,
             LocalVector& F) const noexcept override {
    F = mass_ * (a - g);
  }
  void tangents(const LocalVector&, const LocalVector&, const LocalVector&, const Eigen::Vector3d&,
                LocalHessian& d_F_d_v, LocalHessian& d_F_d_u) const noexcept override {
    d_F_d_v.setZero();
    d_F_d_u.setZero();
  }
  double gravity_energy(const LocalVector& u, const Eigen::Vector3d& g) const noexcept override {
    return -mass_ * g.dot(u);
  }

 private:
  double mass_;
};

/// A moment of inertia, kg m^2, at the angle of a node of a planar scene.
class PlanarBody final : public Inertia {
 public:
  PlanarBody(Eigen::Index node, double inertia) : Inertia({angle_of(node)}), inertia_(inertia) {}

  void mass(const LocalVector&, LocalHessian& M) const noexcept override {
    M.setConstant(inertia_);
  }
  void force(const LocalVector&, const LocalVector&, const LocalVector& a, const Eigen::Vector3d&,
             LocalVector& F) const noexcept override {
    F = inertia_ * a;
  }
  void tangents(const LocalVector&, const LocalVector&, const LocalVector&, const Eigen::Vector3d&,
                LocalHessian& d_F_d_v, LocalHessian& d_F_d_u) const noexcept override {
    d_F_d_v.setZero();
    d_F_d_u.setZero();
  }
  double gravity_energy(const LocalVector&, const Eigen::Vector3d&) const noexcept override {
    return 0;
  }

 private:
  double inertia_;
};

}  // namespace stillframe

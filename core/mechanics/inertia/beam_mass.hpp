#pragma once

#include "core/mechanics/elements/rotation.hpp"
#include "core/mechanics/inertia/hermite_mass.hpp"
#include "core/mechanics/inertia/inertia.hpp"

namespace stillframe {

/// Consistent mass of a spatial beam: of its axis, and of its twist, whose body rate about the axis
/// is linear between the ends. Local coordinates: translation p (3), rotation p (4), translation q
/// (3), rotation q (4).
class BeamMass final : public Inertia {
 public:
  /// l_0_vector: from p to q in the scene as written, m; mass_per_length: kg/m;
  /// inertia_per_length: kg m, about the axis.
  BeamMass(Eigen::Index node_p, Eigen::Index node_q, const Eigen::Vector3d& l_0_vector,
           double mass_per_length, double inertia_per_length);

  void mass(const LocalVector& u, LocalHessian& M) const noexcept override;
  void force(const LocalVector& u, const LocalVector& v, const LocalVector& a,
             const Eigen::Vector3d& g, LocalVector& F) const noexcept override;
  void tangents(const LocalVector& u, const LocalVector& v, const LocalVector& a,
                const Eigen::Vector3d& g, LocalHessian& d_F_d_v,
                LocalHessian& d_F_d_u) const noexcept override;
  double gravity_energy(const LocalVector& u, const Eigen::Vector3d& g) const noexcept override;

 private:
  Eigen::Vector3d n_x_;
  Eigen::Matrix4d M_;
  Eigen::Matrix2d J_;  ///< kg m^2, of the rates about the axis at p and q
};

}  // namespace stillframe

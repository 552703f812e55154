#pragma once

#include "core/mechanics/elements/element.hpp"

namespace stillframe {

/// What has mass: the inertia forces of some node parts, with the displacements u of the parts, in
/// global axes, and their rates v and accelerations a,
///   F(u, v, a) = M(u) a - f_in(u, v) - f_g(u),
/// where f_g is the weight in a uniform gravity g. Immutable. hot: noexcept, no allocation. The
/// caller sizes what is written.
class Inertia {
 public:
  virtual ~Inertia() = default;
  const std::vector<NodePart>& parts() const { return parts_; }
  Eigen::Index n_local() const { return n_local_; }

  /// M (n_local x n_local, symmetric).
  virtual void mass(const LocalVector& u, LocalHessian& M) const noexcept = 0;
  /// F (n_local).
  virtual void force(const LocalVector& u, const LocalVector& v, const LocalVector& a,
                     const Eigen::Vector3d& g, LocalVector& F) const noexcept = 0;
  /// dF/dv and dF/du (n_local x n_local each).
  virtual void tangents(const LocalVector& u, const LocalVector& v, const LocalVector& a,
                        const Eigen::Vector3d& g, LocalHessian& d_F_d_v,
                        LocalHessian& d_F_d_u) const noexcept = 0;
  /// J: v^T M v / 2, and what gravity has stored since the scene as written.
  virtual double kinetic_energy(const LocalVector& u, const LocalVector& v) const noexcept;
  virtual double gravity_energy(const LocalVector& u, const Eigen::Vector3d& g) const noexcept = 0;

 protected:
  explicit Inertia(std::vector<NodePart> parts) : parts_(std::move(parts)) {
    for (const NodePart& part : parts_) n_local_ += part.size();
  }

 private:
  std::vector<NodePart> parts_;
  Eigen::Index n_local_ = 0;
};

inline double Inertia::kinetic_energy(const LocalVector& u, const LocalVector& v) const noexcept {
  LocalHessian M(n_local(), n_local());
  mass(u, M);
  return 0.5 * v.dot(M * v);
}

}  // namespace stillframe

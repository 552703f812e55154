#pragma once

#include <Eigen/Core>
#include <memory>
#include <utility>
#include <vector>

namespace stillframe {

/// A group of nodal coordinates of one node: 3 translations, 4 Euler parameters, or the angle of a
/// node of a planar scene.
struct NodePart {
  enum class Kind { translation, rotation, angle };
  Eigen::Index node = 0;
  Kind kind = Kind::translation;
  Eigen::Index size() const {
    return kind == Kind::translation ? 3 : kind == Kind::rotation ? 4 : 1;
  }
};
inline NodePart translation_of(Eigen::Index node) { return {node, NodePart::Kind::translation}; }
inline NodePart rotation_of(Eigen::Index node) { return {node, NodePart::Kind::rotation}; }
inline NodePart angle_of(Eigen::Index node) { return {node, NodePart::Kind::angle}; }

/// Largest numbers of deformations and of local coordinates of any element: local arrays live on
/// the stack. What is kept of an element (its law, its Jacobian) has its own size.
inline constexpr int max_deformations = 90, max_local = 96;
using LocalDeformation = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, max_deformations, 1>;
using LocalVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, max_local, 1>;
using LocalJacobian =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, max_deformations, max_local>;
using LocalHessian = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, max_local, max_local>;
/// Where a Jacobian is written: a local one, or one that is kept.
using JacobianOut = Eigen::Ref<Eigen::MatrixXd>;
using LocalStiffness =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, max_deformations, max_deformations>;

/// A finite element as its deformation functions e = D(u) of the displacements u of its node parts,
/// in global axes, in the order of parts() (deck, section 2). Immutable. hot: noexcept, no
/// allocation. Every e(0) is 0: the scene as written is the undeformed state. The caller sizes what
/// is written.
class Element {
 public:
  virtual ~Element() = default;
  const std::vector<NodePart>& parts() const { return parts_; }
  Eigen::Index n_deformations() const { return n_deformations_; }
  Eigen::Index n_local() const { return n_local_; }

  /// e (n_e), m or rad as the element says.
  virtual void deformations(const LocalVector& u, LocalDeformation& e) const noexcept = 0;
  /// D_x (n_e x n_local).
  virtual void jacobian(const LocalVector& u, JacobianOut d_e_d_u) const noexcept = 0;
  /// D2_x(v, w) (n_e): the second derivative contracted with two directions.
  virtual void second_derivative(const LocalVector& u, const LocalVector& v, const LocalVector& w,
                                 LocalDeformation& result) const noexcept = 0;
  /// First and second time derivatives of D_x (n_e x n_local each) while u' = v and u'' = a:
  /// rate = D2_x v and second_rate = D2_x a + D3_x v v.
  virtual void jacobian_rates(const LocalVector& u, const LocalVector& v, const LocalVector& a,
                              JacobianOut rate, JacobianOut second_rate) const noexcept = 0;
  /// sum_i sigma_i D2_x e_i (n_local x n_local, symmetric): what sigma contributes to G.
  virtual void hessian(const LocalVector& u, const LocalDeformation& sigma,
                       LocalHessian& result) const noexcept = 0;
  /// e_1 and e_1 + period are the same position; 0 if there is no such thing.
  virtual double period() const noexcept { return 0; }

 protected:
  Element(std::vector<NodePart> parts, Eigen::Index n_deformations)
      : parts_(std::move(parts)), n_deformations_(n_deformations) {
    for (const NodePart& part : parts_) n_local_ += part.size();
  }

 private:
  std::vector<NodePart> parts_;
  Eigen::Index n_deformations_ = 0, n_local_ = 0;
};

}  // namespace stillframe

#pragma once

#include <Eigen/SparseCore>
#include <vector>

#include "core/mechanics/model/local.hpp"

namespace stillframe {

using SparseMatrix = Eigen::SparseMatrix<double>;

/// A position at rest of a mixed model: displacements (n_x), stresses of its rows (n_rows), and the
/// share of loads, gravity and preloads that they balance.
struct MixedState {
  Eigen::VectorXd x, s;
  double load_factor = 0;
};

/// A model at rest with nothing eliminated: displacements x^c and stress resultants s are both
/// unknown, which is the mixed form
///   -c s + E x = e_given,   E^T s + (G + K_0) x + M x'' = f,
/// one row for each principal stiffness of an element (c = 1 / it) and for each condition (c = 0:
/// what is rigid is a spring without compliance). K = E^T c^-1 E is never formed: its rounding
/// costs a chain of n beams some eps n^4 of its softest motion, that of E eps n^2. The model is one
/// without dofs (free_model): all of its n_c free coordinates are unknown.
/// Source: deck, sections 2 to 4; docs/decisions/0035-sparse-models.md.
class MixedModel {
 public:
  /// Of which coordinates matrices are wanted: those that move freely (n_c), or the prescribed and
  /// the fixed ones behind them as well (n_x + n_0), for what drives and supports exert.
  enum class Of { free, all };

  /// The model has to outlive this one. Errors: std::invalid_argument if it has dofs, or loads that
  /// turn with their nodes, whose stiffness is not symmetric.
  explicit MixedModel(const Model& model);

  Eigen::Index n_rows() const { return n_rows_; }
  Eigen::Index n_coordinates() const { return model_.n_c; }
  const Eigen::VectorXd& compliance() const { return compliance_; }  ///< n_rows, c
  /// n_rows, 1 / c, and 0 of conditions: what they bear is no matter of strain.
  const Eigen::VectorXd& stiffness() const { return stiffness_; }
  /// Whether conditions hold parts together, beside those of unit Euler parameters.
  bool rigid() const { return rigid_; }
  const Model& model() const { return model_; }

  /// x (n_x) of the scene as written with its prescribed displacements, times a factor.
  Eigen::VectorXd written(double factor) const;

  /// What is strained at x (n_x), less what is prescribed: E's integral, n_rows.
  Eigen::VectorXd strains(const Eigen::VectorXd& x, double load_factor) const;
  /// E (n_rows x n).
  SparseMatrix strain_rows(const Eigen::VectorXd& x, Of of = Of::free) const;
  SparseMatrix mass(const Eigen::VectorXd& x, Of of = Of::free) const;  ///< M (n x n)

  /// Where damping is a time times the stiffness of an element it is in its compliance,
  /// c / (1 + time p) of motions e^(p t): n_rows, 0 where it is not. What is damped otherwise is in
  /// D = E^T S_d E (n x n).
  const Eigen::VectorXd& damping_time() const { return damping_time_; }
  SparseMatrix damping(const Eigen::VectorXd& x, Of of = Of::free) const;
  bool damped() const { return damped_; }
  /// G (n x n) of the stresses and the weight.
  SparseMatrix geometric_stiffness(const MixedState& state, Of of = Of::free) const;
  /// Loads, weight and preloads on the coordinates (n).
  Eigen::VectorXd forces(const Eigen::VectorXd& x, double load_factor, Of of = Of::free) const;

  /// D_x e (n_x + n_0) of one deformation of element k.
  Eigen::VectorXd deformation_row(size_t k, Eigen::Index i, const Eigen::VectorXd& x) const;
  /// Its stress resultant is stress_row s + viscous_row x', beside what is given: n_rows and
  /// n_x + n_0. The second is that of an element whose damping is in D.
  Eigen::VectorXd stress_row(size_t k, Eigen::Index i) const;
  Eigen::VectorXd viscous_row(size_t k, Eigen::Index i, const Eigen::VectorXd& x) const;
  /// All of element k at rest: its deformations at x, and its stress resultants.
  LocalDeformation deformations(size_t k, const Eigen::VectorXd& x) const;
  LocalDeformation stresses(size_t k, const MixedState& state) const;
  /// What prescribed deformations of a pattern of q^r (n_r) strain: the right-hand side of the rows
  /// (n_rows), and the forces that the stresses which do not follow from s exert on all coordinates
  /// (n_x + n_0), of the deformations and of their rates.
  struct Prescribed {
    Eigen::VectorXd e, K, D;
  };
  Prescribed prescribed(const Eigen::VectorXd& pattern, const Eigen::VectorXd& x) const;

 private:
  /// Of one element: sigma = sigma_given + Q s.
  struct Rows {
    Eigen::Index first = 0;
    Eigen::MatrixXd Q;           ///< n_e x rows
    Eigen::VectorXd given;       ///< n_e: preload and the stress of prescribed deformations
    Eigen::VectorXd prescribed;  ///< n_e: prescribed deformations, 0 of the others
    Eigen::MatrixXd S_d;         ///< n_e x n_e, without conditions; empty where not damped
    bool in_D = false;           ///< damped, and not as its stiffness
  };
  Eigen::Index size(Of of) const;
  LocalJacobian local_jacobian(size_t k, const Eigen::VectorXd& x) const;

  const Model& model_;
  std::vector<Rows> rows_;
  Eigen::Index n_rows_ = 0;
  Eigen::VectorXd compliance_, stiffness_, damping_time_;
  bool damped_ = false, rigid_ = false;
};

}  // namespace stillframe

#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/mechanics/condition_factors.hpp"
#include "core/mechanics/model/local.hpp"

namespace stillframe {

/// The state of a moving model: q^d and its rate, and the prescribed q^r with its rate and
/// acceleration.
struct MotionState {
  Eigen::VectorXd q_d, q_d_dot;            ///< n_d
  Eigen::VectorXd q_r, q_r_dot, q_r_ddot;  ///< n_r
  explicit MotionState(const Model& model);
};

/// Work space of one moving model, allocated once; every function below writes only what its
/// comment says.
struct Data {
  explicit Data(const Model& model);

  // Positions: nodal displacements x, deformations e, first derivative D_x e.
  Eigen::VectorXd x;               ///< n_x, m and (rotations) 1
  Eigen::VectorXd e;               ///< n_e, m and rad; the angle of a hinge goes on from the last e
  std::vector<Eigen::MatrixXd> D;  ///< of each element, columns in node axes
  ConditionFactors J;              ///< n_c x n_c, D of the conditions to the dependent coordinates

  // First-order geometric transfer functions to q^d.
  RowMatrix DF;    ///< n_x x n_d, D_d F^(x)
  RowMatrix DF_e;  ///< n_redundant x n_d, D_d F^(e,c)

  // Velocities and the accelerations at zero q^d acceleration (D2F q' q' + D_r F q''^r).
  Eigen::VectorXd x_dot, e_dot;  ///< n_x, n_e
  Eigen::VectorXd x_ddot_0;      ///< n_x

  // Dynamics (core/mechanics/dynamics.hpp).
  double load_factor = 1;  ///< of loads, gravity and preloads, for load stepping
  /// Nodal forces besides those of the model (n_x, N), of whoever moves it; null: none.
  const Eigen::VectorXd* external = nullptr;
  Eigen::MatrixXd M_dd, M_factor;          ///< n_d x n_d, the latter its Cholesky factor
  Eigen::VectorXd sigma, f, f_dd, x_ddot;  ///< n_e, n_x, n_d, n_x
  Eigen::VectorXd sigma_balanced;          ///< n_e, those that balance all nodal forces
  Eigen::VectorXd damper_rates;            ///< n_d or 0, P^T e'
  Eigen::VectorXd condition;               ///< n_c, work space
  RowMatrix conditions;                    ///< n_c x n_d, work space
  RowMatrix local_rows;                    ///< largest n_local of the inertias x n_d, work space
};

/// Writes e, D and the entries of J for the present x. hot: noexcept, no allocation.
void assemble(const Model& model, Data& data) noexcept;

/// Writes x for given q^d and q^r of the state: Newton's method on e^0 = 0, e^m = q^m, starting
/// from the present x with the present factors of J, which are renewed only when they converge
/// slowly. Answers false if it does not converge (a configuration that cannot be reached). hot:
/// noexcept, no allocation.
bool solve_positions(const Model& model, Data& data, const MotionState& state) noexcept;

/// The same from any distance: goes from the present x to q^d and q^r of `to`, those of `from`, in
/// steps in which no node is expected to turn by more than 0.3 rad, so that Newton's method stays
/// on the branch it started from. Leaves data.x as it was if it does not get there. set-up.
bool travel(const Model& model, Data& data, const MotionState& from, const MotionState& to);

/// Writes D, J, DF and DF_e for the present x. Source: deck, section 2; THEORY section 1. hot.
void geometric_transfer_functions(const Model& model, Data& data) noexcept;

/// Writes x_dot, e_dot and x_ddot_0 for the rates of a state, after geometric_transfer_functions.
/// hot.
void velocities(const Model& model, Data& data, const MotionState& state) noexcept;

/// D_r F (n_x x k) for k patterns of prescribed motion (n_r x k), after
/// geometric_transfer_functions. set-up.
RowMatrix prescribed_transfer_functions(const Model& model, Data& data,
                                        const Eigen::MatrixXd& patterns);

/// D_x e as one matrix (n_e x n_x), at the present x and in the scene as written. set-up.
Eigen::MatrixXd dense_jacobian(const Model& model, const Data& data);
Eigen::MatrixXd dense_jacobian(const Model& model);

}  // namespace stillframe

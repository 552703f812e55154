#pragma once

#include <Eigen/Core>
#include <Eigen/LU>

#include "core/model/model.hpp"

namespace stillframe {

/// Work space of one moving model, allocated once; every function below writes only what its
/// comment says.
struct Data {
  explicit Data(const Model& model);

  // Positions: nodal displacements x, deformations e, first derivative D = D_x e.
  Eigen::VectorXd x;  ///< n_x, m and (Euler parameters) 1
  Eigen::VectorXd e;  ///< n_e, m
  Eigen::MatrixXd D;  ///< n_e x n_x
  Eigen::PartialPivLU<Eigen::MatrixXd>
      J;  ///< n_c x n_c, D of the conditions to the dependent coordinates

  // First-order geometric transfer functions to q^d.
  Eigen::MatrixXd DF;    ///< n_x x n_d, D_d F^(x)
  Eigen::MatrixXd DF_e;  ///< n_redundant x n_d, D_d F^(e,c)

  // Velocities and the accelerations at zero q^d acceleration (D2F q' q' + D_r F q''^r).
  Eigen::VectorXd x_dot, e_dot;  ///< n_x, n_e
  Eigen::VectorXd x_ddot_0;      ///< n_x

  // Dynamics (core/dynamics.hpp).
  Eigen::MatrixXd M_dd;                    ///< n_d x n_d
  Eigen::VectorXd sigma, f, f_dd, x_ddot;  ///< n_e, n_x, n_d, n_x
  Eigen::VectorXd condition;               ///< n_c, work space
  Eigen::MatrixXd conditions;              ///< n_c x n_d, work space
  Eigen::MatrixXd permuted;                ///< n_c x max(n_d, 1), work space
};

/// Writes e and D for the present x. hot: noexcept, no allocation.
void assemble(const Model& model, Data& data) noexcept;

/// Writes x for given q^d (n_d) and q^r (n_r): Newton's method on e^0 = 0, e^m = q^m, starting from
/// the present x with the present factors of J, which are renewed only when they converge slowly.
/// Answers false if it does not converge (a configuration that cannot be reached). hot: noexcept,
/// no allocation.
bool solve_positions(const Model& model, Data& data, const Eigen::VectorXd& q_d,
                     const Eigen::VectorXd& q_r) noexcept;

/// Writes D, J, DF and DF_e for the present x. Source: deck, section 2; THEORY section 1. hot.
void geometric_transfer_functions(const Model& model, Data& data) noexcept;

/// Writes x_dot, e_dot and x_ddot_0 for given rates, after geometric_transfer_functions. hot.
void velocities(const Model& model, Data& data, const Eigen::VectorXd& q_d_dot,
                const Eigen::VectorXd& q_r_dot, const Eigen::VectorXd& q_r_ddot) noexcept;

/// D_r F (n_x x k) for k patterns of prescribed motion (n_r x k), after
/// geometric_transfer_functions. set-up.
Eigen::MatrixXd prescribed_transfer_functions(const Model& model, const Data& data,
                                              const Eigen::MatrixXd& patterns);

/// sum_i sigma_i D2_x e_i (n_x x n_x, symmetric) at the present x. set-up.
Eigen::MatrixXd stress_hessian(const Model& model, const Data& data, const Eigen::VectorXd& sigma);

}  // namespace stillframe

#pragma once

#include <Eigen/Core>

#include "core/kinematics.hpp"

namespace stillframe {

/// The state of a moving model: q^d and its rate, and the prescribed q^r with its rate and
/// acceleration.
struct MotionState {
  Eigen::VectorXd q_d, q_d_dot;            ///< n_d
  Eigen::VectorXd q_r, q_r_dot, q_r_ddot;  ///< n_r
  explicit MotionState(const Model& model);
};

enum class DynamicsStatus { ok, position_not_found, mass_matrix_singular };

/// The nonlinear equations of motion in minimal coordinates,
///   M_dd q''^d = D_dF^(x)T (f + f_in - M (D2F q' q' + D_rF q''^r)) - D_dF^(e)T sigma,
///   sigma = sigma_0 + sigma_a + S e + S_d e'.
/// sigma_a (n_e): driving stresses, N. f: the model's constant loads. Source: deck, section 3.
/// Writes q_d_ddot (n_d) and into data: all positions, rates, sigma, x_ddot; M_dd becomes its
/// Cholesky factor. hot: noexcept, no allocation.
DynamicsStatus accelerations(const Model& model, Data& data, const MotionState& state,
                             const Eigen::VectorXd& sigma_a, Eigen::VectorXd& q_d_ddot) noexcept;

/// Kinetic and elastic energy, J, at the positions and rates that accelerations() left in data. The
/// elastic part counts preload (sigma_0 e + S e^2 / 2) and the potential of the constant loads.
double kinetic_energy(const Model& model, const Data& data);
double potential_energy(const Model& model, const Data& data);

/// M_dd (n_d x n_d) for the transfer functions in data, and D_dF^T M a for several accelerations a
/// (n_x x k).
void mass_matrix(const Model& model, Data& data) noexcept;
Eigen::MatrixXd project_mass(const Model& model, const Data& data, const Eigen::MatrixXd& a);

}  // namespace stillframe

#pragma once

#include <Eigen/Core>

#include "core/mechanics/kinematics.hpp"

namespace stillframe {

enum class DynamicsStatus { ok, position_not_found, mass_matrix_singular };

/// The nonlinear equations of motion in minimal coordinates,
///   M_dd q''^d = D_dF^(x)T (f + f_in - M (D2F q' q' + D_rF q''^r)) - D_dF^(e)T sigma,
///   sigma = sigma_0 + sigma_a + S e + S_d e'.
/// sigma_a (n_e): driving stresses, N. f: the model's constant loads, gravity and data.external.
/// Source: deck, section 3. Writes q_d_ddot (n_d) and into data: all positions, rates, sigma of the
/// elastic deformations, M_dd and its factor, x_ddot. hot: noexcept, no allocation.
DynamicsStatus accelerations(const Model& model, Data& data, const MotionState& state,
                             const Eigen::VectorXd& sigma_a, Eigen::VectorXd& q_d_ddot) noexcept;

/// Its right-hand side f_dd (n_d), all but the solution with M_dd: what is out of balance at
/// q''^d = 0. Writes positions, rates, sigma, f and f_dd into data; false if the position cannot be
/// reached. hot.
bool generalised_forces(const Model& model, Data& data, const MotionState& state,
                        const Eigen::VectorXd& sigma_a) noexcept;

/// sigma += S e + S_d e' of all elements; all n_e. hot.
void add_element_stresses(const Model& model, const Eigen::VectorXd& e,
                          const Eigen::VectorXd& e_dot, Eigen::VectorXd& sigma) noexcept;

/// Writes x_ddot for given q''^d, after generalised_forces. hot.
void complete_accelerations(Data& data, const Eigen::VectorXd& q_d_ddot) noexcept;

/// Writes sigma_balanced, the stress resultants that balance all nodal forces: those of the
/// conditions from the equations of reaction J^T sigma = f + f_in - M x'' - D_c^T sigma^c, and into
/// sigma those of the zero and prescribed deformations. Those of dynamic deformations agree with
/// their elastic law where the equations of motion hold. After complete_accelerations. Source:
/// deck, section 4. set-up.
void reaction_stresses(const Model& model, Data& data);

/// Nodal forces (n_x + n_0) that constrain, at the accelerations in data: D^T sigma - f - f_in + M
/// x''. Their entries at fixed coordinates are the reactions f^0, at prescribed ones the driving
/// forces f^m; the others are zero to rounding. After reaction_stresses. set-up.
Eigen::VectorXd constraint_forces(const Model& model, const Data& data);

/// Its parts (n_x + n_0 each): inertia forces M x'' - f_in, and applied forces (loads,
/// data.external and weight). set-up.
Eigen::VectorXd inertia_forces(const Model& model, const Data& data);
Eigen::VectorXd applied_forces(const Model& model, const Data& data);

/// Kinetic, elastic (e^T S e / 2) and potential energy, J, at the positions and rates that
/// accelerations() left in data. The potential counts the elastic energy, preload (sigma_0 e),
/// constant loads and gravity; loads that follow a node and torques in space have no potential.
double kinetic_energy(const Model& model, const Data& data);
double elastic_energy(const Model& model, const Data& data);
double potential_energy(const Model& model, const Data& data);

/// M_dd (n_d x n_d) for the transfer functions in data. hot.
void mass_matrix(const Model& model, Data& data) noexcept;

}  // namespace stillframe

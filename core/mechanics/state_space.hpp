#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "core/errors/input_error.hpp"
#include "core/mechanics/linearisation/linearisation.hpp"
#include "core/systems/sampled_plant.hpp"
#include "core/systems/state_space_model.hpp"

namespace stillframe {

/// Refusal of equations of motion where a dof moves no mass.
class Massless : public Refusal {
 public:
  using Refusal::Refusal;
};

/// Cholesky factors of M (n_d x n_d, kg and the like), by which every state equation is solved.
/// Errors: Massless naming the dof that moves no mass if M is not positive definite to rounding.
Eigen::LLT<Eigen::MatrixXd> mass_factors(const LinearModel& model);

/// A = [0 I; -M^-1 (K + N + G) -M^-1 (C + D)], 2 n_d x 2 n_d, state (q^d, dq^d/dt). Source: deck,
/// section 8.1. Errors: as mass_factors; Refusal naming a dof if what moves it is not finite.
Eigen::MatrixXd state_matrix(const LinearModel& model);

/// Which of its three columns a physical input is itself; direct for forces, torques and stresses.
InputColumns::Kind input_kind(Quantity quantity);

/// The complete first-order form, state (q^d, dq^d/dt),
///   A as above, B_2 = M^-1 [B | -M_r | -(C_r + D_r) | -(K_r + N_r + G_r)],
///   C = [Y_p + Y_a A_21 | Y_v + Y_a A_22],   D = Y_a B_2 + (D_u, R_a, R_v, R_p),
/// with the columns in the order of the inputs: one for a force, torque or stress, (w'', w', w) for
/// a motion. x0 = (q_0, q'_0), u0 and y0 are those of the linear model. Source: deck, sections 8.1
/// to 8.4; THEORY section 2. Errors: as state_matrix; Refusal naming an output that is not finite.
StateSpace state_space(const LinearModel& model);

/// The linear model as the sampled loop needs it: w the first n_w inputs (accelerations and
/// forces), u the remaining m (driving stresses of the legs), y the first n_y outputs, sigma the
/// remaining m (their stress resultants). Where prescribed motion strains elastic elements,
/// velocity and position of w join the state (deck, Note 2). Errors: std::invalid_argument if the
/// inputs or outputs are not of that kind; as state_space.
LoopPlant loop_plant(const LinearModel& model, Eigen::Index n_w, Eigen::Index n_y);

}  // namespace stillframe

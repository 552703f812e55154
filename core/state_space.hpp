#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/linear/sampled_loop.hpp"
#include "core/linearisation.hpp"

namespace stillframe {

/// A = [0 I; -M^-1 (K + G) -M^-1 D], 2 n_d x 2 n_d, state (q^d, dq^d/dt). Source: deck,
/// section 8.1.
Eigen::MatrixXd state_matrix(const LinearModel& model);

/// The linear model as the sampled loop needs it: w the first n_w inputs (all accelerations), u the
/// remaining m (driving stresses of the legs), y the first n_y outputs, sigma the remaining m
/// (their stress resultants). Where prescribed motion strains elastic elements, velocity and
/// position of w join the state (deck, Note 2). Errors: std::invalid_argument if the inputs or
/// outputs are not of that kind.
LoopPlant loop_plant(const LinearModel& model, Eigen::Index n_w, Eigen::Index n_y);

}  // namespace stillframe

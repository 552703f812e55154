#pragma once

#include <Eigen/Core>

#include "core/systems/linear_system.hpp"

namespace stillframe {

/// A sampled plant with what it is judged by and what is measured of it:
///   x[k+1] = A x + B_w w + B_u u,   z = C_z x + D_zw w + D_zu u,   e = C_e x + D_ew w,
/// w white of unit covariance, z the weighted cost (every command has to have one: D_zu^T D_zu
/// regular), e the measurement (every one has to have noise: D_ew D_ew^T regular).
struct H2Problem {
  Eigen::MatrixXd A, B_w, B_u, C_z, D_zw, D_zu, C_e, D_ew;
};

struct H2Law {
  LinearSystem law;   ///< u from e; its states are the predicted x
  double cost = 0;    ///< E|z|^2 with it, the least of all causal laws
  double radius = 0;  ///< the larger spectral radius of control and filter
};

/// The law of least E|z|^2: with X, K of the Riccati equation of control, Y of that of the filter,
///   V = C_e Y C_e^T + D_ew D_ew^T,  R_x = D_zu^T D_zu + B_u^T X B_u,
///   K_w = R_x^-1 (B_u^T X B_w + D_zu^T D_zw),  L = (A Y C_e^T + B_w D_ew^T) V^-1,
///   x[k+1] = A x + B_u u + L (e - C_e x),
///   u = -K x - (K Y C_e^T + K_w D_ew^T) V^-1 (e - C_e x):
/// the predictor of Kalman, whose command knows the measurement that it answers. Source: Zhou,
/// Doyle and Glover, Robust and Optimal Control, chapter 21; Anderson and Moore, Optimal Filtering,
/// chapter 5. Set-up. Errors: as solve_riccati.
H2Law h2_law(const H2Problem& problem);

}  // namespace stillframe

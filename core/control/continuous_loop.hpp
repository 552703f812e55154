#pragma once

#include <Eigen/Core>

#include "core/control/force_feedback.hpp"
#include "core/systems/sampled_plant.hpp"

namespace stillframe {

/// Plant and continuous law as one system, x = (z, law), inputs (w, v) with v the noise of the
/// force sensors (m, N), output y. The law sees the strain force C_sigma z + v. Floor integrators
/// are kept among the states. Errors: as strain_feedback.
LinearSystem continuous_loop(const LoopPlant& plant, const ForceFeedback& feedback);

/// Its poles without the floor integrators, rad/s, slowest first. Errors: Refusal if not found.
Eigen::VectorXcd closed_loop_poles(const LoopPlant& plant, const ForceFeedback& feedback);

/// How far a square transfer matrix is from one curve for all, and from a diagonal.
struct Decoupling {
  double spread_db = 0;  ///< largest over smallest singular value
  /// Largest, over the inputs, of the response at all other outputs (2-norm) over that at its own;
  /// -infinity for a diagonal.
  double crosstalk_db = 0;
};

/// Errors: std::invalid_argument if T is not square or empty.
Decoupling decoupling(const Eigen::MatrixXcd& T);

}  // namespace stillframe

#pragma once

#include <Eigen/Core>
#include <complex>

#include "core/linear/force_feedback.hpp"
#include "core/linearisation.hpp"
#include "core/scene/scene.hpp"

namespace stillframe {

/// What forces on the frame do to it: the displacements at the places and along the directions of
/// the scene's outputs, from forces (N) at the same places along the same directions.
class Compliance {
 public:
  /// Linearises about the scene's equilibrium. Errors: as require_loop_signals and the equilibrium.
  Compliance(const Scene& scene, const Model& model);

  /// n_y x n_y, m/N, without control; s in rad/s.
  Eigen::MatrixXcd open(std::complex<double> s) const;
  /// The same with the continuous law.
  Eigen::MatrixXcd closed(std::complex<double> s, const ForceFeedback& feedback) const;

 private:
  LinearModel model_;
  Eigen::Index n_ = 0;
};

}  // namespace stillframe

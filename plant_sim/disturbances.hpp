#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/mechanics/model/model.hpp"
#include "plant_sim/force_courses.hpp"

namespace stillframe {

/// The scene's disturbances as nodal forces, held over each sample.
///   f[k] = sum_i (translation row of node i along its direction)^T F_i[k]
/// Set-up: construction; the rest is hot.
class Disturbances {
 public:
  /// sample_time: s. Errors: InputError as ForceCourse, and for a force that does nothing because
  /// the node is fixed or prescribed along it.
  Disturbances(const Scene& scene, const Model& model, double sample_time);

  /// Takes sample k, from 0 up: writes the forces that are held over it.
  void take(std::int64_t k) noexcept;
  /// Nodal forces f (n_x, N; empty without disturbances), dual to x: what they add to the
  /// right-hand side of the equations of motion for q^d is D_dF^(x)^T f.
  const Eigen::VectorXd& forces() const noexcept { return forces_; }
  /// The forces F one by one (N), in the scene's order.
  const Eigen::VectorXd& values() const noexcept { return values_; }
  /// n_x x (number of disturbances): forces() = patterns() values().
  const Eigen::MatrixXd& patterns() const noexcept { return patterns_; }

 private:
  std::vector<ForceCourse> courses_;
  Eigen::MatrixXd patterns_;
  Eigen::VectorXd values_, forces_;
};

}  // namespace stillframe

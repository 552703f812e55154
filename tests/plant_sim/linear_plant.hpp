#pragma once

#include <Eigen/Core>
#include <map>
#include <vector>

#include "core/mechanics/model/model.hpp"
#include "core/mechanics/scene/scene.hpp"
#include "plant_sim/plant.hpp"

namespace stillframe::test {

/// The linear plant of a scene with its instruments as one system in continuous time, from sample
/// to sample by the exponential of its matrix: X = (z, f, s, integral of y) and U = (w, c),
///   z' = A z + B_w w + B_u g f,   f' = omega_a (c - f),   s' = omega_s (C_sigma z + g f - s).
/// Nothing of it comes from the plant simulator but the form of a Reading, whose
/// frame_acceleration has the scene's outputs alone.
class LinearPlant {
 public:
  LinearPlant(const Scene& scene, const Model& model);
  /// Commands before and after the fraction of a sample, as Plant::advance, and the floor's w.
  void advance(const Eigen::VectorXd& before, const Eigen::VectorXd& after, double fraction,
               const Eigen::VectorXd& w);
  Reading read() const;

 private:
  void hold(const Eigen::VectorXd& command, double duration, const Eigen::VectorXd& w);

  Instruments instruments_;
  double limit_, sample_time_;
  Eigen::Index n_z_, m_, n_y_;
  Eigen::MatrixXd F_;                        ///< d(X, U)/dt = F (X, U), with rows of zeros for U
  std::map<double, Eigen::MatrixXd> steps_;  ///< its exponential, by duration
  Eigen::MatrixXd C_sigma_;
  Eigen::VectorXd X_, mean_, w_, c_;
  std::vector<Eigen::VectorXd> reports_;
};

}  // namespace stillframe::test

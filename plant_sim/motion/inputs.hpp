#pragma once

#include <Eigen/Core>

namespace stillframe {

/// What acts on a plant during one part of a sample, within which no command and no sample of the
/// floor changes: everything is smooth in t. Hot: noexcept, no allocation.
class Inputs {
 public:
  virtual ~Inputs() = default;
  /// Writes the prescribed motion with its rate and acceleration (n_r each; m, rad) and the driving
  /// stresses (n_e, N or N m; rows without an actuator stay as they are) at t s into the part.
  virtual void at(double t, Eigen::VectorXd& q_r, Eigen::VectorXd& q_r_dot,
                  Eigen::VectorXd& q_r_ddot, Eigen::VectorXd& sigma_a) const noexcept = 0;
  /// Nodal forces besides those of the scene (n_x, N), held over the part; empty if there are none.
  virtual const Eigen::VectorXd& external() const noexcept = 0;
};

}  // namespace stillframe

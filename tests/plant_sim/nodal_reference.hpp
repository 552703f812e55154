#pragma once

#include "core/mechanics/dynamics.hpp"
#include "plant_sim/motion/inputs.hpp"

namespace stillframe::test {

/// Prescribed accelerations and driving stresses held over each part; rates and positions carried
/// on from part to part.
class HeldInputs final : public Inputs {
 public:
  explicit HeldInputs(const Model& model);
  void at(double t, Eigen::VectorXd& q_r, Eigen::VectorXd& q_r_dot, Eigen::VectorXd& q_r_ddot,
          Eigen::VectorXd& sigma) const noexcept override;
  const Eigen::VectorXd& external() const noexcept override { return force; }
  void finish(double duration);

  Eigen::VectorXd position, rate, acceleration;  ///< n_r
  Eigen::VectorXd sigma_a;                       ///< n_e
  Eigen::VectorXd force;                         ///< n_x or empty
};

/// The motion in minimal coordinates from accelerations(), by the classical Runge-Kutta method with
/// so many equal steps a part. Knows no external forces.
class MinimalMotion {
 public:
  MinimalMotion(const Model& model, const MotionState& state, const Eigen::VectorXd& x);
  void advance(const HeldInputs& inputs, double duration, int steps);
  const Data& data() const { return data_; }
  /// Kinetic and potential energy, J.
  double energy() const;

 private:
  Eigen::VectorXd rate(const Eigen::VectorXd& y, double t, const HeldInputs& inputs);

  const Model& model_;
  Data data_;
  MotionState state_;
  Eigen::VectorXd y_;  ///< q^d, q'^d
};

}  // namespace stillframe::test

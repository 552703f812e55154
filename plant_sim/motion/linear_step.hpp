#pragma once

#include "plant_sim/motion/linear_equations.hpp"

namespace stillframe {

class Drive;

/// The exact answer of the linear equations a time tau after the start of a part,
///   y(tau) = Phi y + G_p q^r + G_v q'^r + G_a q''^r + G_s settled + G_t transient + G_f f
/// with the inputs of Drive at its start. Set-up: construction. apply() is hot: noexcept, no
/// allocation.
class LinearStep {
 public:
  /// tau: s; lag_rate: of the actuators, 1/s, 0 without a lag.
  LinearStep(const LinearEquations& equations, double tau, double lag_rate);

  /// What the inputs of a part are at its start, gathered once for all steps from there.
  struct Start {
    Eigen::VectorXd q_r, q_r_dot, settled, transient;
  };
  void apply(const Drive& drive, const Start& start, const Eigen::Ref<const Eigen::VectorXd>& y,
             Eigen::Ref<Eigen::VectorXd> out) const noexcept;

  double tau() const noexcept { return tau_; }

 private:
  double tau_;
  bool lags_, strains_;  ///< whether the prescribed motion strains anything by itself
  Eigen::MatrixXd Phi_, G_p_, G_v_, G_a_, G_s_, G_t_, G_f_;
};

/// Writes what the inputs are a time `from` (s) after the start of the drive's part.
void gather(const Drive& drive, double from, LinearStep::Start& start) noexcept;
LinearStep::Start start_for(const Drive& drive);

}  // namespace stillframe

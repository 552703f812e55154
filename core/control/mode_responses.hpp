#pragma once

#include <Eigen/Core>
#include <complex>

#include "core/control/close_loop.hpp"
#include "core/control/discrete_law.hpp"
#include "core/systems/linear_system.hpp"

namespace stillframe {

/// What one virtual mode is to become, and what that may not cost.
struct ModeGoal {
  double omega_d = 0, zeta = 0;  ///< rad/s, 1: of the target s^2 + 2 zeta omega_d s + omega_d^2
  double to_hz = 0;              ///< up to here, from 1.5 targets on, T is to be as the target's
  double disk = 0.5;             ///< least disk margin, above 0
  double peak_db = 3;            ///< most of T below 1.5 targets
  double above_db = -3;          ///< most of T above to_hz
};

/// What a sampled mode is to its law, commands on their way included:
///   xi[k+1] = A xi + B_w w + B_u u,   y[k+1] = C_y xi + D_yw w + D_yu u,   e[k] = C_e xi,
/// w, y and u of one number, e the strain force that the law hears (m/s^2).
struct LawPorts {
  Eigen::MatrixXd A, B_w, B_u, C_y, D_yw, D_yu, C_e;
};

/// An undamped mode of unit mass on a leg of its own, as sampled: relative motion eta,
/// eta'' = -omega^2 eta - u - w, its acceleration y = -omega^2 eta - u, sigma = omega^2 eta + u,
/// all in m/s^2, with floor w.
class SampledMode {
 public:
  /// omega in rad/s; sampling: of the whole loop, of which gains and delays of single legs are left
  /// out, as a design does not know them; applied_memory: as DiscreteLaw. Set-up. Errors: as
  /// sample_and_hold.
  SampledMode(double omega, const Sampling& sampling, double applied_memory);

  double omega() const { return omega_; }
  const Sampling& sampling() const { return sampling_; }
  const LoopPlant& plant() const { return plant_; }
  const SampledPlant& sampled() const { return sampled_; }
  const LawPorts& ports() const { return ports_; }
  /// The sampled law around a filter F of the strain force.
  DiscreteLaw law_of(const LinearSystem& F) const;

  /// Spectral radius with that filter, the forces times `gain` and the command so many samples
  /// later than known.
  double radius(const LinearSystem& F, double gain = 1, double later = 0) const;
  double disk_margin(const LinearSystem& F) const;

 private:
  double omega_, applied_memory_;
  Sampling sampling_;
  LoopPlant plant_;
  SampledPlant sampled_;
  LawPorts ports_;
};

/// Responses of a mode over a grid of frequencies, with which T and S of any law take one division
/// each.
struct ModeResponses {
  Eigen::VectorXd hz;
  Eigen::VectorXcd z;
  Eigen::VectorXcd y_w, y_u, e_w, e_u;  ///< of LawPorts
  Eigen::VectorXcd sigma_f;             ///< of sigma to the acting force, whole delay included

  /// From a twentieth of the target to next to half the rate, denser where T is to be small.
  ModeResponses(const SampledMode& mode, const ModeGoal& goal);

  /// Of a filter F at every z.
  Eigen::VectorXcd of(const LinearSystem& F) const;
  /// T = y_w + y_u F e_w / (1 - F e_u), S = 1 + F sigma_f / (1 - F e_u).
  Eigen::VectorXcd T(const Eigen::VectorXcd& F) const;
  Eigen::VectorXcd S(const Eigen::VectorXcd& F) const;
};

/// |T| of the target at frequencies in Hz.
Eigen::VectorXd target_size(const ModeGoal& goal, const Eigen::VectorXd& hz);

/// What |T| may be where the band from 1.5 targets to to_hz is to be `level_db` above the target.
Eigen::VectorXd bound_of(const ModeGoal& goal, double level_db, const Eigen::VectorXd& hz);

/// A law of one mode.
struct ModeLaw {
  LinearSystem F;       ///< command from strain force, 1
  double level_db = 0;  ///< largest |T| over the target's from 1.5 targets to to_hz
  double disk = 0;
};

/// Of a T over a grid: the level in dB.
double level_of(const ModeGoal& goal, const Eigen::VectorXd& hz, const Eigen::VectorXcd& T);

}  // namespace stillframe

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/dynamics.hpp"
#include "core/scene/scene.hpp"
#include "plant_sim/actuators.hpp"
#include "plant_sim/floor_motion.hpp"
#include "plant_sim/force_sensors.hpp"
#include "plant_sim/integrator.hpp"

namespace stillframe {

/// What the instruments read at t_k, before anything changes there; see msgs/measurement_t.lcm.
struct Reading {
  Eigen::VectorXd floor_acceleration;  ///< m/s^2, along the scene's inputs
  Eigen::VectorXd sigma;               ///< N, equilibrium value removed
  Eigen::VectorXd applied_force;       ///< N
  Eigen::VectorXd frame_acceleration;  ///< m/s^2, mean over the last sample: outputs, then monitors
};

/// The nonlinear frame and floor with the scene's instruments and the commands to the legs held.
/// Set-up: construction. read() and advance() do not allocate while the motion can go on.
class Plant {
 public:
  /// scene and model must outlive the plant. Errors: InputError as require_loop_signals and
  /// FloorMotion; Refusal if the scene has no equilibrium, in which it starts.
  Plant(const Scene& scene, const Model& model, std::unique_ptr<floor::FloorSource> floor);

  /// The instruments at the present instant.
  const Reading& read() noexcept;

  /// Moves on by one sample with the floor's next sample and with the command `before` to the legs
  /// (m, N) for the first `fraction` (0 to below 1) of it, `after` for the rest. Answers an empty
  /// text, or why the motion cannot go on. Which commands these are is CommandQueue's matter.
  std::string advance(const Eigen::Ref<const Eigen::VectorXd>& before,
                      const Eigen::Ref<const Eigen::VectorXd>& after, double fraction);
  /// The same with one command for the whole sample.
  std::string advance(const Eigen::VectorXd& command) { return advance(command, command, 0); }

  double time() const { return static_cast<double>(k_) * sample_time_; }
  std::int64_t sample() const { return k_; }
  std::int64_t floor_samples() const { return floor_.n_samples(); }
  const MotionState& state() const { return state_; }
  const Data& data() const { return data_; }
  long evaluations() const { return integrator_.evaluations(); }

 private:
  Index n_legs() const noexcept { return static_cast<Index>(leg_rows_.size()); }
  Index n_filtered() const noexcept { return sensors_.filter() ? n_legs() : 0; }
  /// Writes dy/dt at a time t (s) into the present part of the sample, with the forces there.
  bool right_hand_side(double t, const Eigen::Ref<const Eigen::VectorXd>& y,
                       Eigen::Ref<Eigen::VectorXd> dy_dt) noexcept;
  /// The same with the forces in sigma_a_.
  bool motion(double t, const Eigen::Ref<const Eigen::VectorXd>& y,
              Eigen::Ref<Eigen::VectorXd> dy_dt) noexcept;
  /// Goes on for a duration (s) under a command.
  Integrator::Status hold(const Eigen::Ref<const Eigen::VectorXd>& command,
                          double duration) noexcept;

  const Model& model_;
  FloorMotion floor_;
  double sample_time_;
  Data data_;
  MotionState state_;
  std::vector<Index> leg_rows_;
  Actuators actuators_;
  ForceSensors sensors_;
  double stiffness_;  ///< N/m, of the stiffest leg: what stresses in y_ are divided by
  Integrator integrator_;
  Eigen::MatrixXd frame_rows_;     ///< n_frame x n_x
  Eigen::VectorXd x_dot_before_;   ///< n_x, at the start of the last sample
  Eigen::VectorXd x_dot_change_;   ///< n_x, since then
  Eigen::VectorXd q_0_, sigma_0_;  ///< n_d, n_e, of the equilibrium, from which y counts
  /// y_: 2 n_d, or 2 n_d + m with a sensor filter: q^d - q_0, q'^d, s_e / stiffness_.
  Eigen::VectorXd y_, y_rate_, sigma_a_, q_d_ddot_;
  double least_scale_ =
      0;  ///< m/s^2, of what is left of the equilibrium's forces, over the tolerance
  Reading reading_;
  std::int64_t k_ = 0;
};

}  // namespace stillframe

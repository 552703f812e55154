#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/dynamics.hpp"
#include "core/scene/scene.hpp"
#include "plant_sim/floor_motion.hpp"
#include "plant_sim/integrator.hpp"

namespace stillframe {

/// What the instruments read at t_k, before anything changes there; see msgs/measurement_t.lcm.
struct Reading {
  Eigen::VectorXd floor_acceleration;  ///< m/s^2, along the scene's inputs
  Eigen::VectorXd sigma;               ///< N, equilibrium value removed
  Eigen::VectorXd applied_force;       ///< N
  Eigen::VectorXd frame_acceleration;  ///< m/s^2, mean over the last sample: outputs, then monitors
};

/// The nonlinear frame and floor with the forces of the legs held over each sample.
/// Set-up: construction. read() and advance() do not allocate.
class Plant {
 public:
  /// scene and model must outlive the plant. Errors: InputError as require_loop_signals and
  /// FloorMotion; Refusal if the scene has no equilibrium, in which it starts.
  Plant(const Scene& scene, const Model& model, std::unique_ptr<floor::FloorSource> floor);

  /// The instruments at the present instant.
  const Reading& read() noexcept;

  /// Moves on by one sample with the leg forces given (m, N; limited to the scene's force limit)
  /// and the floor's next sample. Answers an empty text, or why the motion cannot go on.
  std::string advance(const Eigen::VectorXd& force);

  double time() const { return static_cast<double>(k_) * sample_time_; }
  std::int64_t sample() const { return k_; }
  std::int64_t floor_samples() const { return floor_.n_samples(); }
  const MotionState& state() const { return state_; }
  const Data& data() const { return data_; }
  long evaluations() const { return integrator_.evaluations(); }

 private:
  bool right_hand_side(double t, const Eigen::Ref<const Eigen::VectorXd>& y,
                       Eigen::Ref<Eigen::VectorXd> dy_dt) noexcept;

  const Scene& scene_;
  const Model& model_;
  FloorMotion floor_;
  double sample_time_;
  Data data_;
  MotionState state_;
  Integrator integrator_;
  Eigen::MatrixXd frame_rows_;  ///< n_frame x n_x
  std::vector<Index> leg_rows_;
  Eigen::VectorXd x_dot_before_;  ///< n_x, at the start of the last sample
  Eigen::VectorXd q_0_, sigma_0_;  ///< n_d, n_e, of the equilibrium, from which y counts
  Eigen::VectorXd y_, y_rate_, sigma_a_, q_d_ddot_;
  Reading reading_;
  std::int64_t k_ = 0;
};

}  // namespace stillframe

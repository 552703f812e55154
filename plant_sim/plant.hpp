#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>

#include "core/mechanics/scene/rigid_bodies.hpp"
#include "plant_sim/force_sensors.hpp"
#include "plant_sim/motion/make_motion.hpp"
#include "plant_sim/sensor_errors.hpp"

namespace stillframe {

/// What the instruments read at t_k, before anything changes there; see msgs/measurement_t.lcm.
struct Reading {
  Eigen::VectorXd floor_acceleration;  ///< m/s^2, along the scene's inputs
  Eigen::VectorXd sigma;               ///< N, equilibrium value removed
  Eigen::VectorXd applied_force;       ///< N
  Eigen::VectorXd frame_acceleration;  ///< m/s^2, mean over the last sample: outputs, then monitors
};

/// The frame and floor of a scene with its instruments and the commands to the legs held, moved by
/// the method that the scene asks for. Rigid bodies are one node each (merge_rigid_bodies).
/// Set-up: construction. read() and advance() do not allocate while the motion can go on.
class Plant {
 public:
  /// Starts at the scene's operating point, its prescribed motion included, which goes on. Errors:
  /// InputError as require_loop_signals, FloorMotion and make_motion; Refusal as nominal_motion.
  Plant(const Scene& scene, std::unique_ptr<floor::FloorSource> floor);
  Plant(const Plant&) = delete;
  Plant& operator=(const Plant&) = delete;

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
  std::int64_t floor_samples() const { return drive_.floor().n_samples(); }
  long evaluations() const { return motion_->evaluations(); }
  const MotionChoice& choice() const { return choice_; }
  /// Readings of force sensors that were out of their range, and cut off there.
  std::int64_t n_out_of_range() const { return n_out_of_range_; }

 private:
  Index n_legs() const noexcept { return static_cast<Index>(drive_.legs().size()); }
  /// sigma of the legs (N) without what the sensors make of it.
  void true_stresses(Eigen::VectorXd& sigma) noexcept;
  /// Goes on for a duration (s) under a command.
  Motion::Status hold(const Eigen::Ref<const Eigen::VectorXd>& command, double duration) noexcept;
  std::string reason_of(Motion::Status status) const;
  /// Where the frame was, and what had come to its limits before.
  std::string circumstances() const;

  double sample_time_;
  MergedScene merged_;
  Model model_;
  Drive drive_;
  ForceSensors sensors_;
  std::optional<ForceSensorNoise> force_noise_;
  std::optional<FloorSensorNoise> floor_noise_;
  MotionChoice choice_;
  std::unique_ptr<Motion> motion_;
  std::vector<std::string> frame_points_;       ///< names of outputs and monitors
  Eigen::VectorXd velocity_before_, velocity_;  ///< of them, one sample apart
  Eigen::VectorXd stress_;
  Reading reading_;
  double force_limit_;  ///< N, may be infinite
  std::int64_t k_ = 0, n_at_limit_ = 0, n_out_of_range_ = 0;
};

}  // namespace stillframe

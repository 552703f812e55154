#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "core/mechanics/model/model.hpp"
#include "core/mechanics/scene/scene.hpp"
#include "plant_sim/floor/floor_source.hpp"

namespace stillframe {

/// How the prescribed coordinates follow a rigid floor: n_r x 6, for translations x, y, z (m) and
/// small rotations rx, ry, rz (rad) about lines through the origin.
///   u = t + theta x r, r the node in the scene as written; each coordinate takes its own part of
///   u, a prescribed angle of a planar scene rz, a prescribed deformation nothing
/// This is linear in the rotation: what it leaves out, theta x (theta x r) / 2 in the position and
/// the centripetal theta' x (theta' x r) in the acceleration, is less than what it keeps by the
/// floor's angle in rad (1e-6 of it at a microradian). Set-up.
Eigen::MatrixXd rigid_floor_map(const Model& model);

/// The names of a scene's inputs, as floor blocks call them.
std::vector<std::string> floor_input_names(const Scene& scene);

/// Coordinates that move at accelerations held over each sample, with the exact integrals of these.
/// They are carried in double-double, so that their rounding does not grow however long it goes on.
/// Set-up: construction; the rest is hot: noexcept, no allocation.
class HeldCourse {
 public:
  /// Where it begins, and at which rate and acceleration (n each).
  HeldCourse(const Eigen::VectorXd& value, const Eigen::VectorXd& rate,
             const Eigen::VectorXd& acceleration);
  /// The acceleration held from here on.
  Eigen::VectorXd& acceleration() noexcept { return acceleration_; }
  const Eigen::VectorXd& acceleration() const noexcept { return acceleration_; }
  /// Position and rate a time t (s) after the last finish().
  void at(double t, Eigen::VectorXd& value, Eigen::VectorXd& rate) const noexcept {
    value = value_ + t * (rate_ + 0.5 * t * acceleration_);
    rate = rate_ + t * acceleration_;
  }
  /// The same, added.
  void add_at(double t, Eigen::VectorXd& value, Eigen::VectorXd& rate) const noexcept {
    value += value_ + t * (rate_ + 0.5 * t * acceleration_);
    rate += rate_ + t * acceleration_;
  }
  /// Goes on by a duration (s).
  void finish(double duration) noexcept;

 private:
  Eigen::VectorXd value_, rate_, acceleration_;
  Eigen::VectorXd value_rest_, rate_rest_;  ///< what value_ and rate_ are too short for
};

/// The motion of a model's prescribed coordinates in a run,
///   q^r(t) = q^r_0 + t q'^r_0 + t^2 q''^r_0 / 2 + w(t),
/// what the scene prescribes, and upon it the floor's: a source whose accelerations w'' are held
/// over each sample, from rest. Set-up: construction; the rest is hot.
class FloorMotion {
 public:
  /// A source of a rigid floor moves every prescribed coordinate; one of inputs moves the scene's
  /// inputs. Errors: InputError if the model has no prescribed coordinates
  /// to move, or if the floor turns and a node on it cannot: a node whose rotation is fixed, or a
  /// planar scene that is to turn out of its plane.
  FloorMotion(std::unique_ptr<floor::FloorSource> source, const Scene& scene, const Model& model);

  /// Takes sample k: the floor's held acceleration.
  void take(std::int64_t k) noexcept;
  /// The floor's part w and w' a time t (s) after the last sample was taken or finish was called.
  void floor_at(double t, Eigen::VectorXd& w, Eigen::VectorXd& w_dot) const noexcept {
    floor_.at(t, w, w_dot);
  }
  /// The whole motion there.
  void at(double t, Eigen::VectorXd& q_r, Eigen::VectorXd& q_r_dot,
          Eigen::VectorXd& q_r_ddot) const noexcept;
  /// Goes on by duration (s), to the end of the present sample or of a part of it.
  void finish(double duration) noexcept;

  /// w'', held over the present sample (n_r).
  const Eigen::VectorXd& floor_acceleration() const noexcept { return floor_.acceleration(); }
  std::int64_t n_samples() const noexcept { return source_->n_samples(); }
  /// What channel by channel of the source moves: w'' = map() w (n_r x channels), and what the
  /// scene's inputs read of it, inputs() w'' (n_inputs x n_r).
  const Eigen::MatrixXd& map() const noexcept { return map_; }
  const Eigen::MatrixXd& inputs() const noexcept { return inputs_; }
  /// Acceleration along each of the scene's inputs, m/s^2, held over the present sample.
  void along_inputs(Eigen::VectorXd& acceleration) const noexcept;

 private:
  std::unique_ptr<floor::FloorSource> source_;
  Eigen::MatrixXd map_;     ///< n_r x channels
  Eigen::MatrixXd inputs_;  ///< n_inputs x n_r
  Eigen::VectorXd channels_;
  HeldCourse stated_, floor_;  ///< n_r: as the scene prescribes it, and w
};

}  // namespace stillframe

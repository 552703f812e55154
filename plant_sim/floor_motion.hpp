#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "core/model/model.hpp"
#include "core/scene/scene.hpp"
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

/// A floor source on the prescribed coordinates of a model: q''^r held over each sample, and its
/// exact integrals q'^r and q^r carried along from sample to sample. They are carried in
/// double-double, so that their rounding does not grow however long it goes on; what is left is
/// what the source itself integrates to. Set-up: construction; the rest is hot.
class FloorMotion {
 public:
  /// A source of translations or of a rigid floor moves every prescribed coordinate; a source of
  /// inputs moves the scene's inputs. Errors: InputError if the model has no prescribed coordinates
  /// to move, or if the floor turns and a node on it cannot: a node whose rotation is fixed, or a
  /// planar scene that is to turn out of its plane.
  FloorMotion(std::unique_ptr<floor::FloorSource> source, const Scene& scene, const Model& model);

  /// Takes sample k: writes the held acceleration q''^r.
  void take(std::int64_t k) noexcept;
  /// q^r and q'^r a time t (s) after the last sample was taken or finish was called.
  void at(double t, Eigen::VectorXd& q_r, Eigen::VectorXd& q_r_dot) const noexcept;
  /// Goes on by duration (s), to the end of the present sample or of a part of it.
  void finish(double duration) noexcept;

  const Eigen::VectorXd& q_r_ddot() const noexcept { return q_r_ddot_; }
  std::int64_t n_samples() const noexcept { return source_->n_samples(); }
  /// Acceleration along each of the scene's inputs, m/s^2, held over the present sample.
  void along_inputs(Eigen::VectorXd& acceleration) const noexcept;

 private:
  std::unique_ptr<floor::FloorSource> source_;
  Eigen::MatrixXd map_;     ///< n_r x channels
  Eigen::MatrixXd inputs_;  ///< n_inputs x n_r
  Eigen::VectorXd channels_, q_r_, q_r_dot_, q_r_ddot_;
  Eigen::VectorXd q_r_rest_, q_r_dot_rest_;  ///< what q_r_ and q_r_dot_ are too short for
};

}  // namespace stillframe

#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "core/model/model.hpp"
#include "core/scene/scene.hpp"
#include "plant_sim/floor/floor_source.hpp"

namespace stillframe {

/// A floor source on the prescribed coordinates of a model: q''^r held over each sample, and its
/// exact integrals q'^r and q^r carried along from sample to sample. Set-up: construction; the rest
/// is hot.
class FloorMotion {
 public:
  /// A source of translations moves every prescribed coordinate; a source of inputs moves the
  /// scene's inputs. Errors: InputError if the model has no prescribed coordinates to move.
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
};

}  // namespace stillframe

#pragma once

#include "core/mechanics/linearisation/linearisation.hpp"
#include "plant_sim/motion/frame_points.hpp"
#include "plant_sim/motion/motion.hpp"
#include "plant_sim/nodal/nodal_motion.hpp"

namespace stillframe {

/// The nonlinear plant in nodal coordinates with constraints.
class NodalPlantMotion final : public NonlinearMotion {
 public:
  /// model outlives the motion; legs: rows of e whose stress is measured; filter_rate: omega_s
  /// (1/s), 0 if there is no filter; relative_tolerance: of a step (see NodalMotion).
  NodalPlantMotion(const Model& model, const NominalMotion& nominal, FramePoints points,
                   std::vector<Index> legs, double filter_rate, double relative_tolerance);

  Status advance(const Drive& drive, double duration) noexcept override;
  void velocities(Eigen::VectorXd& v) const noexcept override;
  void elastic_stresses(Eigen::VectorXd& sigma) const noexcept override;
  void filtered_stresses(Eigen::VectorXd& sigma) const noexcept override;
  long evaluations() const noexcept override { return motion_.evaluations(); }
  Eigen::VectorXd displacements() const override;
  bool hand_over(const Drive& drive, MotionSnapshot& to) noexcept override;
  void take_over(const MotionSnapshot& from) noexcept override;

 private:
  /// Makes the angles of hinges in e (n_e) go on from those that the motion has counted.
  void count_turns(Eigen::VectorXd& e) const noexcept;
  /// Of one dof from the operating point.
  double displacement(Index dof, const Eigen::VectorXd& x, const Eigen::VectorXd& e) const noexcept;

  const Model& model_;
  Data data_;            ///< positions and rates alone, for the points
  Eigen::VectorXd q_0_;  ///< n_d, of the operating point
  FramePoints points_;
  std::vector<Index> legs_;
  double stress_scale_;
  Eigen::VectorXd sigma_0_, driving_;  ///< n_legs: of the operating point, of the actuators
  nodal::NodalMotion motion_;
};

}  // namespace stillframe

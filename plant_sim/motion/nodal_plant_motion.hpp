#pragma once

#include "core/equilibrium.hpp"
#include "plant_sim/motion/frame_points.hpp"
#include "plant_sim/motion/motion.hpp"
#include "plant_sim/nodal/nodal_motion.hpp"

namespace stillframe {

/// The nonlinear plant in nodal coordinates with constraints.
class NodalPlantMotion final : public Motion {
 public:
  /// model outlives the motion; legs: rows of e whose stress is measured; filter_rate: omega_s
  /// (1/s), 0 if there is no filter.
  NodalPlantMotion(const Model& model, const Equilibrium& rest, FramePoints points,
                   std::vector<Index> legs, double filter_rate, double relative_tolerance,
                   nodal::Method method);

  Status advance(const Drive& drive, double duration) noexcept override;
  void velocities(Eigen::VectorXd& v) const noexcept override;
  void elastic_stresses(Eigen::VectorXd& sigma) const noexcept override;
  void filtered_stresses(Eigen::VectorXd& sigma) const noexcept override;
  long evaluations() const noexcept override { return motion_.evaluations(); }
  std::string where() const override;

 private:
  Data data_;  ///< positions and rates alone, for the points
  FramePoints points_;
  std::vector<Index> legs_;
  Eigen::VectorXd sigma_0_, driving_;  ///< n_legs: of the equilibrium, of the actuators
  nodal::NodalMotion motion_;
};

}  // namespace stillframe

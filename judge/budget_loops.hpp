#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/systems/linear_system.hpp"
#include "judge/budget.hpp"
#include "plant_sim/floor_motion.hpp"

namespace stillframe::judge {

/// The exact sampled loops of a design from each of its sources to accelerations by name. Set-up.
class BudgetLoops {
 public:
  /// Errors: InputError for a floor that moves what a loop has no input for, or a name that the
  /// scene has not.
  BudgetLoops(const LoopDesign& design, const FloorMotion& floor,
              const std::vector<std::string>& outputs);

  /// From one channel of the floor, which the feed-forward hears as the scene's inputs measure it.
  SampledLoop of_floor(Eigen::Index channel, BudgetMethod method) const;
  /// From one disturbance of the scene, in their order.
  SampledLoop of_force(Eigen::Index disturbance, BudgetMethod method) const;
  /// From what the force sensors add, m: y[k+1] = C x[k] + D v[k].
  LinearSystem of_force_sensors() const;
  /// From what the floor's sensors add to what the feed-forward hears.
  LinearSystem of_floor_sensors() const;

 private:
  SampledLoop around(const Eigen::VectorXd& moved, const Eigen::VectorXd& heard,
                     BudgetMethod method) const;

  const LoopDesign& design_;
  SampledPlant plant_;     ///< from all prescribed translations and all forces
  Eigen::MatrixXd moved_;  ///< translations x channels
  Eigen::MatrixXd heard_;  ///< inputs x channels
};

}  // namespace stillframe::judge

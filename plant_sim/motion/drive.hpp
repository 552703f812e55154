#pragma once

#include <vector>

#include "plant_sim/actuators.hpp"
#include "plant_sim/disturbances.hpp"
#include "plant_sim/floor_motion.hpp"
#include "plant_sim/motion/inputs.hpp"

namespace stillframe {

/// The inputs of a plant in a run: its floor, the actuators of its legs, what disturbs its frame.
/// Set-up: construction. The rest is hot: noexcept, no allocation.
class Drive final : public Inputs {
 public:
  /// legs: rows of e that the actuators drive.
  Drive(FloorMotion floor, Actuators actuators, Disturbances disturbances,
        std::vector<Eigen::Index> legs)
      : floor_(std::move(floor)),
        actuators_(std::move(actuators)),
        disturbances_(std::move(disturbances)),
        legs_(std::move(legs)) {}

  /// Takes sample k of everything that is held over it.
  void take(std::int64_t k) noexcept {
    floor_.take(k);
    disturbances_.take(k);
  }

  void at(double t, Eigen::VectorXd& q_r, Eigen::VectorXd& q_r_dot, Eigen::VectorXd& q_r_ddot,
          Eigen::VectorXd& sigma_a) const noexcept override {
    floor_.at(t, q_r, q_r_dot, q_r_ddot);
    for (size_t i = 0; i < legs_.size(); ++i) {
      sigma_a(legs_[i]) = actuators_.acting(static_cast<Eigen::Index>(i), t);
    }
  }
  const Eigen::VectorXd& external() const noexcept override { return disturbances_.forces(); }

  /// The part of the inputs that a linear plant answers in closed form, at the start of the part:
  ///   w(t) = w + t w' + t^2 w'' / 2,   sigma_a(t) = settled + transient exp(-rate t).
  const FloorMotion& floor() const noexcept { return floor_; }
  const Actuators& actuators() const noexcept { return actuators_; }
  FloorMotion& floor() noexcept { return floor_; }
  Actuators& actuators() noexcept { return actuators_; }
  const std::vector<Eigen::Index>& legs() const noexcept { return legs_; }

 private:
  FloorMotion floor_;
  Actuators actuators_;
  Disturbances disturbances_;
  std::vector<Eigen::Index> legs_;
};

}  // namespace stillframe

#pragma once

#include <vector>

#include "core/mechanics/kinematics.hpp"
#include "core/mechanics/scene/rigid_bodies.hpp"

namespace stillframe {

/// Points of the frame whose velocity along a direction is looked at: nodes, and nodes that a rigid
/// body carries. Set-up: construction. velocities() is hot: noexcept, no allocation.
class FramePoints {
 public:
  /// signals: their node and direction. carried: of the scene that the model was made from.
  FramePoints(const Model& model, const std::map<std::string, CarriedNode>& carried,
              const std::vector<SceneSignal>& signals);

  Eigen::Index size() const noexcept { return static_cast<Eigen::Index>(points_.size()); }
  /// v (size, m/s) at positions x and rates x_dot (n_x each).
  void velocities(const Eigen::VectorXd& x, const Eigen::VectorXd& x_dot,
                  Eigen::VectorXd& v) const noexcept;
  /// dv/dx' (size x n_x) at the positions in data. Set-up.
  Eigen::MatrixXd jacobian(const Data& data) const;

 private:
  struct Point {
    Eigen::RowVectorXd row;  ///< n_x, of its node
    Eigen::Vector3d direction;
    PartMap rotation;  ///< of the body, empty for a node
    Eigen::Vector3d arm;
  };
  const Model& model_;
  std::vector<Point> points_;
};

}  // namespace stillframe

#include "plant_sim/motion/frame_points.hpp"

#include "core/mechanics/elements/rotation.hpp"

namespace stillframe {

namespace {

/// Euler parameters as displacements (or rates) of a node; zero where they are fixed.
Vector4 gathered(const PartMap& rotation, const Eigen::VectorXd& x) noexcept {
  Vector4 values = Vector4::Zero();
  for (Index i = 0; i < rotation.size; ++i) {
    const Index column = rotation.column[static_cast<size_t>(i)];
    if (column < x.size()) values(i) = x(column);
  }
  return values;
}

}  // namespace

FramePoints::FramePoints(const Model& model, const std::map<std::string, CarriedNode>& carried,
                         const std::vector<SceneSignal>& signals)
    : model_(model) {
  for (const SceneSignal& signal : signals) {
    const auto found = carried.find(signal.node);
    const bool is_carried = found != carried.end();
    const Index node = model.node_index(is_carried ? found->second.body : signal.node);
    Point point{model.translation_row(node, signal.direction),
                signal.direction,
                {},
                Eigen::Vector3d::Zero()};
    if (is_carried && !found->second.arm.isZero(0)) {
      point.rotation = model.nodes[static_cast<size_t>(node)].rotation;
      point.arm = found->second.arm;
    }
    points_.push_back(point);
  }
}

void FramePoints::velocities(const Eigen::VectorXd& x, const Eigen::VectorXd& x_dot,
                             Eigen::VectorXd& v) const noexcept {
  for (size_t i = 0; i < points_.size(); ++i) {
    const Point& point = points_[i];
    double speed = point.row.dot(x_dot);
    if (point.rotation.size > 0) {
      const Vector4 lambda = euler_parameters(gathered(point.rotation, x));
      speed += 2.0 * point.direction.dot(
                         rotation_form(lambda, gathered(point.rotation, x_dot), point.arm));
    }
    v(static_cast<Index>(i)) = speed;
  }
}

Eigen::MatrixXd FramePoints::jacobian(const Data& data) const {
  Eigen::MatrixXd rows(size(), model_.n_x);
  for (Index i = 0; i < size(); ++i) {
    const Point& point = points_[static_cast<size_t>(i)];
    rows.row(i) = point.row;
    if (point.rotation.size == 0) continue;
    const Vector4 lambda = euler_parameters(gathered(point.rotation, data.x));
    const Eigen::RowVector4d turn =
        point.direction.transpose() * d_rotated_d_lambda(lambda, point.arm);
    for (Index j = 0; j < 4; ++j) {
      const Index column = point.rotation.column[static_cast<size_t>(j)];
      if (column < model_.n_x) rows(i, column) += turn(j);
    }
  }
  return rows;
}

}  // namespace stillframe

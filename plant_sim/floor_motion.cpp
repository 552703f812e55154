#include "plant_sim/floor_motion.hpp"

#include <Eigen/Geometry>
#include <algorithm>

#include "core/errors/input_error.hpp"
#include "core/numerics/extended/double_double.hpp"

namespace stillframe {

namespace {

using floor::FloorChannels;

/// A floor that turns takes the rotations of the nodes that stand on it with it; a fixed rotation
/// would stay behind.
void require_rotations(const floor::FloorSource& source, const Scene& scene, const Model& model) {
  const auto turns = [&](Index axis) { return source.moves(3 + axis); };
  if (!turns(0) && !turns(1) && !turns(2)) return;
  if (model.planar && (turns(0) || turns(1))) {
    throw InputError(scene.file +
                     ": the floor turns about x or y, but in a planar scene nothing does; allowed "
                     "are x, y and rz");
  }
  for (const ModelNode& node : model.nodes) {
    const auto prescribed = [&](Index column) {
      return column >= model.n_x - model.n_rx && column < model.n_x;
    };
    const auto& columns = node.translation.column;
    if (node.has_rotation() && node.rotation.column[0] >= model.n_x &&
        std::any_of(columns.begin(), columns.end(), prescribed)) {
      throw InputError(scene.file + ": the floor turns and moves node '" + node.name +
                       "', whose rotation is fixed; " +
                       (model.planar ? "prescribe its rotation instead"
                                     : "the rotation of a spatial node cannot follow the floor, "
                                       "only nodes without rotation can"));
    }
  }
}

/// n_r x channels.
Eigen::MatrixXd map_of(const floor::FloorSource& source, const Scene& scene, const Model& model,
                       const Eigen::MatrixXd& inputs) {
  if (source.meaning() == FloorChannels::inputs) return inputs.transpose();
  const Eigen::MatrixXd rigid = rigid_floor_map(model);
  require_rotations(source, scene, model);
  if (source.meaning() == FloorChannels::rigid) return rigid;
  Eigen::MatrixXd map(model.n_r, 6 + inputs.rows());
  map << rigid, inputs.transpose();
  return map;
}

/// value + rest += more, all that fits into two doubles.
void add(double& value, double& rest, DoubleDouble more) noexcept {
  const DoubleDouble sum = DoubleDouble(value, rest) + more;
  value = sum.high;
  rest = sum.low;
}

}  // namespace

HeldCourse::HeldCourse(const Eigen::VectorXd& value, const Eigen::VectorXd& rate,
                       const Eigen::VectorXd& acceleration)
    : value_(value),
      rate_(rate),
      acceleration_(acceleration),
      value_rest_(Eigen::VectorXd::Zero(value.size())),
      rate_rest_(value_rest_) {}

void HeldCourse::finish(double duration) noexcept {
  for (Index i = 0; i < value_.size(); ++i) {
    const DoubleDouble gain = DoubleDouble::product(duration, acceleration_(i));
    const DoubleDouble mean =
        DoubleDouble(rate_(i), rate_rest_(i)) + DoubleDouble(0.5 * gain.high, 0.5 * gain.low);
    add(value_(i), value_rest_(i), DoubleDouble(duration) * mean);
    add(rate_(i), rate_rest_(i), gain);
  }
}

Eigen::MatrixXd rigid_floor_map(const Model& model) {
  Eigen::MatrixXd map = Eigen::MatrixXd::Zero(model.n_r, 6);
  const Index first = model.n_x - model.n_rx;
  const auto prescribed = [&](Index column) { return column >= first && column < model.n_x; };
  for (const ModelNode& node : model.nodes) {
    for (Index i = 0; i < 3; ++i) {
      const Index column = node.translation.column[static_cast<size_t>(i)];
      if (!prescribed(column)) continue;
      const Eigen::Vector3d direction = node.translation.basis.col(i);
      map.row(column - first) << direction.transpose(), node.position.cross(direction).transpose();
    }
    const Index angle = node.rotation.column[0];
    if (model.planar && node.has_rotation() && prescribed(angle)) map(angle - first, 5) = 1.0;
  }
  return map;
}

std::vector<std::string> floor_input_names(const Scene& scene) {
  std::vector<std::string> names;
  for (const SceneSignal& input : scene.inputs) names.push_back(input.name);
  return names;
}

FloorMotion::FloorMotion(std::unique_ptr<floor::FloorSource> source, const Scene& scene,
                         const Model& model)
    : source_(std::move(source)),
      inputs_(static_cast<Index>(scene.inputs.size()), model.n_r),
      channels_(Eigen::VectorXd::Zero(source_->channels())),
      stated_(model.q_r_0, model.q_r_dot_0, model.q_r_ddot_0),
      floor_(0 * model.q_r_0, 0 * model.q_r_0, 0 * model.q_r_0) {
  if (model.n_r == 0) {
    throw InputError(scene.file + ": the floor has nothing to move: no node is under 'prescribed'");
  }
  for (Index i = 0; i < inputs_.rows(); ++i) {
    const SceneSignal& input = scene.inputs[static_cast<size_t>(i)];
    inputs_.row(i) =
        model.prescribed_pattern(model.node_index(input.node), input.direction, input.place)
            .transpose();
  }
  map_ = map_of(*source_, scene, model, inputs_);
}

void FloorMotion::take(std::int64_t k) noexcept {
  source_->sample(k, channels_);
  floor_.acceleration().noalias() = map_ * channels_;
}

void FloorMotion::at(double t, Eigen::VectorXd& q_r, Eigen::VectorXd& q_r_dot,
                     Eigen::VectorXd& q_r_ddot) const noexcept {
  floor_.at(t, q_r, q_r_dot);
  stated_.add_at(t, q_r, q_r_dot);
  q_r_ddot = stated_.acceleration() + floor_.acceleration();
}

void FloorMotion::finish(double duration) noexcept {
  stated_.finish(duration);
  floor_.finish(duration);
}

void FloorMotion::along_inputs(Eigen::VectorXd& acceleration) const noexcept {
  acceleration.noalias() = inputs_ * floor_.acceleration();
  acceleration.noalias() += inputs_ * stated_.acceleration();
}

}  // namespace stillframe

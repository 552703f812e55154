#include "plant_sim/floor_motion.hpp"

#include "core/yaml/input_error.hpp"

namespace stillframe {

namespace {

Eigen::MatrixXd translation_map(const Model& model) {
  Eigen::MatrixXd map = Eigen::MatrixXd::Zero(model.n_r, 3);
  for (Index node = 0; node < static_cast<Index>(model.nodes.size()); ++node) {
    for (int axis = 0; axis < 3; ++axis) {
      map.col(axis) +=
          model.translation_row(node, Eigen::Vector3d::Unit(axis)).tail(model.n_r).transpose();
    }
  }
  return map;
}

}  // namespace

FloorMotion::FloorMotion(std::unique_ptr<floor::FloorSource> source, const Scene& scene,
                         const Model& model)
    : source_(std::move(source)),
      inputs_(static_cast<Index>(scene.inputs.size()), model.n_r),
      channels_(Eigen::VectorXd::Zero(source_->channels())),
      q_r_(Eigen::VectorXd::Zero(model.n_r)),
      q_r_dot_(Eigen::VectorXd::Zero(model.n_r)),
      q_r_ddot_(Eigen::VectorXd::Zero(model.n_r)) {
  if (model.n_r == 0) {
    throw InputError(scene.file + ": the floor has nothing to move: no node is under 'prescribed'");
  }
  for (Index i = 0; i < inputs_.rows(); ++i) {
    const SceneSignal& input = scene.inputs[static_cast<size_t>(i)];
    inputs_.row(i) =
        model.prescribed_pattern(model.node_index(input.node), input.direction, input.place)
            .transpose();
  }
  map_ = source_->meaning() == floor::FloorChannels::translations ? translation_map(model)
                                                                  : inputs_.transpose();
}

void FloorMotion::take(std::int64_t k) noexcept {
  source_->sample(k, channels_);
  q_r_ddot_.noalias() = map_ * channels_;
}

void FloorMotion::at(double t, Eigen::VectorXd& q_r, Eigen::VectorXd& q_r_dot) const noexcept {
  q_r = q_r_ + t * (q_r_dot_ + 0.5 * t * q_r_ddot_);
  q_r_dot = q_r_dot_ + t * q_r_ddot_;
}

void FloorMotion::finish(double duration) noexcept {
  q_r_ += duration * (q_r_dot_ + 0.5 * duration * q_r_ddot_);
  q_r_dot_ += duration * q_r_ddot_;
}

void FloorMotion::along_inputs(Eigen::VectorXd& acceleration) const noexcept {
  acceleration.noalias() = inputs_ * q_r_ddot_;
}

}  // namespace stillframe

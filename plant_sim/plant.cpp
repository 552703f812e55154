#include "plant_sim/plant.hpp"

#include <algorithm>
#include <limits>

#include "core/control_loop.hpp"
#include "core/equilibrium.hpp"

namespace stillframe {

namespace {

const Scene& checked(const Scene& scene) {
  require_loop_signals(scene);
  return scene;
}

std::string reason_of(Integrator::Status status, const std::string& where) {
  switch (status) {
    case Integrator::Status::ok:
      return "";
    case Integrator::Status::right_hand_side_failed:
      return where +
             ": the equations of motion cannot be evaluated there (a position that the elements "
             "cannot "
             "reach, or a mass matrix that became singular)";
    case Integrator::Status::too_many_steps:
      return where + ": the integrator needs more than 100000 steps within one sample";
    case Integrator::Status::failed:
      return where + ": the integrator cannot go on";
  }
  return where;
}

}  // namespace

Plant::Plant(const Scene& scene, const Model& model, std::unique_ptr<floor::FloorSource> floor)
    : scene_(checked(scene)),
      model_(model),
      floor_(std::move(floor), scene, model),
      sample_time_(1.0 / scene.controller->sample_rate_hz),
      data_(model),
      state_(model),
      integrator_(
          model.n_d,
          [this](double t, const Eigen::Ref<const Eigen::VectorXd>& y,
                 Eigen::Ref<Eigen::VectorXd> dy_dt) { return right_hand_side(t, y, dy_dt); },
          scene.simulation.relative_tolerance),
      x_dot_before_(Eigen::VectorXd::Zero(model.n_x)),
      y_(Eigen::VectorXd::Zero(2 * model.n_d)),
      y_rate_(Eigen::VectorXd::Zero(2 * model.n_d)),
      sigma_a_(Eigen::VectorXd::Zero(model.n_e)),
      q_d_ddot_(Eigen::VectorXd::Zero(model.n_d)) {
  const Equilibrium rest = solve_equilibrium(model);
  q_0_ = rest.motion.state.q_d;
  data_.x = rest.motion.x;
  accelerations(model, data_, rest.motion.state, sigma_a_, q_d_ddot_);
  sigma_0_ = data_.sigma;
  q_d_ddot_.setZero();
  const auto n_outputs = static_cast<Index>(scene.outputs.size());
  const auto n_frame = n_outputs + static_cast<Index>(scene.monitors.size());
  frame_rows_.resize(n_frame, model.n_x);
  for (Index i = 0; i < n_frame; ++i) {
    const SceneSignal& signal = i < n_outputs ? scene.outputs[static_cast<size_t>(i)]
                                              : scene.monitors[static_cast<size_t>(i - n_outputs)];
    frame_rows_.row(i) = model.translation_row(model.node_index(signal.node), signal.direction);
  }
  for (const std::string& leg : scene.controller->legs) {
    leg_rows_.push_back(model.deformation_row(leg));
  }
  const auto n_legs = static_cast<Index>(leg_rows_.size());
  reading_ = {Eigen::VectorXd::Zero(static_cast<Index>(scene.inputs.size())),
              Eigen::VectorXd::Zero(n_legs), Eigen::VectorXd::Zero(n_legs),
              Eigen::VectorXd::Zero(n_frame)};
}

bool Plant::right_hand_side(double t, const Eigen::Ref<const Eigen::VectorXd>& y,
                            Eigen::Ref<Eigen::VectorXd> dy_dt) noexcept {
  state_.q_d = q_0_ + y.head(model_.n_d);
  state_.q_d_dot = y.tail(model_.n_d);
  floor_.at(t, state_.q_r, state_.q_r_dot);
  state_.q_r_ddot = floor_.q_r_ddot();
  if (accelerations(model_, data_, state_, sigma_a_, q_d_ddot_) != DynamicsStatus::ok) return false;
  dy_dt.head(model_.n_d) = state_.q_d_dot;
  dy_dt.tail(model_.n_d) = q_d_ddot_;
  return true;
}

const Reading& Plant::read() noexcept {
  // data_ holds the end of the last sample; before the first sample it holds the scene as written,
  // at rest. Directions are fixed in space, so a mean acceleration along one is the change of
  // velocity along it.
  reading_.frame_acceleration.noalias() =
      frame_rows_ * (data_.x_dot - x_dot_before_) / sample_time_;
  floor_.along_inputs(reading_.floor_acceleration);
  for (size_t i = 0; i < leg_rows_.size(); ++i) {
    const Index row = leg_rows_[i];
    reading_.applied_force(static_cast<Index>(i)) = sigma_a_(row);
    reading_.sigma(static_cast<Index>(i)) = k_ == 0 ? 0.0 : data_.sigma(row) - sigma_0_(row);
  }
  return reading_;
}

std::string Plant::advance(const Eigen::VectorXd& force) {
  const double limit =
      scene_.controller->force_limit_n.value_or(std::numeric_limits<double>::infinity());
  for (size_t i = 0; i < leg_rows_.size(); ++i) {
    sigma_a_(leg_rows_[i]) = std::clamp(force(static_cast<Index>(i)), -limit, limit);
  }
  x_dot_before_ = data_.x_dot;
  floor_.take(k_);
  const std::string where = "plant at t = " + std::to_string(time()) + " s";
  // The accelerations at the end of the last sample scale the error of this one; after rest they
  // are zero.
  if (q_d_ddot_.isZero(0) && !right_hand_side(0.0, y_, y_rate_)) {
    return reason_of(Integrator::Status::right_hand_side_failed, where);
  }
  const double scale = q_d_ddot_.lpNorm<Eigen::Infinity>();
  const auto status = integrator_.advance(y_, sample_time_, scale);
  if (status != Integrator::Status::ok) return reason_of(status, where);
  if (!right_hand_side(sample_time_, y_, y_rate_)) {
    return reason_of(Integrator::Status::right_hand_side_failed, where);
  }
  floor_.finish(sample_time_);
  ++k_;
  return "";
}

}  // namespace stillframe

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

std::vector<Index> rows_of(const std::vector<std::string>& legs, const Model& model) {
  std::vector<Index> rows;
  for (const std::string& leg : legs) rows.push_back(model.deformation_row(leg));
  return rows;
}

/// Of the stiffest of these deformations (N/m), 1 if none resists.
double largest_stiffness(const std::vector<Index>& rows, const Model& model) {
  double largest = 0;
  for (const Index row : rows) {
    const auto [element, i] = model.owner_of_row(row);
    const LocalStiffness& S = model.elements[element].S;
    if (S.size() > 0) largest = std::max(largest, S(i, i));
  }
  return largest > 0 ? largest : 1;
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
    : model_(model),
      floor_(std::move(floor), checked(scene), model),
      sample_time_(1.0 / scene.controller->sample_rate_hz),
      data_(model),
      state_(model),
      leg_rows_(rows_of(scene.controller->legs, model)),
      actuators_(static_cast<Index>(leg_rows_.size()),
                 scene.controller->force_limit_n.value_or(std::numeric_limits<double>::infinity()),
                 scene.instruments),
      sensors_(static_cast<Index>(leg_rows_.size()), scene.instruments.sensor_filter_hz),
      stiffness_(largest_stiffness(leg_rows_, model)),
      integrator_(
          model.n_d,
          [this](double t, const Eigen::Ref<const Eigen::VectorXd>& y,
                 Eigen::Ref<Eigen::VectorXd> dy_dt) { return right_hand_side(t, y, dy_dt); },
          scene.simulation.relative_tolerance, n_filtered()),
      x_dot_before_(Eigen::VectorXd::Zero(model.n_x)),
      x_dot_change_(Eigen::VectorXd::Zero(model.n_x)),
      y_(Eigen::VectorXd::Zero(2 * model.n_d + n_filtered())),
      y_rate_(y_),
      sigma_a_(Eigen::VectorXd::Zero(model.n_e)),
      q_d_ddot_(Eigen::VectorXd::Zero(model.n_d)) {
  const Equilibrium rest = solve_equilibrium(model);
  q_0_ = rest.motion.state.q_d;
  data_.x = rest.motion.x;
  accelerations(model, data_, rest.motion.state, sigma_a_, q_d_ddot_);
  // Preloads balance up to rounding only. Errors of that size can be met by no step, so they set
  // the least acceleration that counts.
  least_scale_ = 100 * q_d_ddot_.lpNorm<Eigen::Infinity>() / scene.simulation.relative_tolerance;
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
  reading_ = {Eigen::VectorXd::Zero(static_cast<Index>(scene.inputs.size())),
              Eigen::VectorXd::Zero(n_legs()), Eigen::VectorXd::Zero(n_legs()),
              Eigen::VectorXd::Zero(n_frame)};
}

bool Plant::motion(double t, const Eigen::Ref<const Eigen::VectorXd>& y,
                   Eigen::Ref<Eigen::VectorXd> dy_dt) noexcept {
  const Index n_d = model_.n_d;
  state_.q_d = q_0_ + y.head(n_d);
  state_.q_d_dot = y.segment(n_d, n_d);
  floor_.at(t, state_.q_r, state_.q_r_dot);
  state_.q_r_ddot = floor_.q_r_ddot();
  if (accelerations(model_, data_, state_, sigma_a_, q_d_ddot_) != DynamicsStatus::ok) return false;
  dy_dt.head(n_d) = state_.q_d_dot;
  dy_dt.segment(n_d, n_d) = q_d_ddot_;
  for (Index i = 0; i < n_filtered(); ++i) {
    const Index row = leg_rows_[static_cast<size_t>(i)];
    const double elastic = data_.sigma(row) - sigma_a_(row) - sigma_0_(row);
    dy_dt(2 * n_d + i) = sensors_.rate() * (elastic / stiffness_ - y(2 * n_d + i));
  }
  return true;
}

bool Plant::right_hand_side(double t, const Eigen::Ref<const Eigen::VectorXd>& y,
                            Eigen::Ref<Eigen::VectorXd> dy_dt) noexcept {
  for (Index i = 0; actuators_.lags() && i < n_legs(); ++i) {
    sigma_a_(leg_rows_[static_cast<size_t>(i)]) = actuators_.acting(i, t);
  }
  return motion(t, y, dy_dt);
}

const Reading& Plant::read() noexcept {
  // data_ holds the end of the last sample; before the first sample it holds the scene as written,
  // at rest. Directions are fixed in space, so a mean acceleration along one is the change of
  // velocity along it.
  x_dot_change_ = data_.x_dot - x_dot_before_;
  reading_.frame_acceleration.noalias() = frame_rows_ * x_dot_change_;
  reading_.frame_acceleration /= sample_time_;
  floor_.along_inputs(reading_.floor_acceleration);
  reading_.applied_force = actuators_.report();
  if (sensors_.filter()) {
    reading_.sigma = sensors_.actuator_part() + stiffness_ * y_.tail(n_legs());
  } else if (k_ > 0) {
    for (Index i = 0; i < n_legs(); ++i) {
      const Index row = leg_rows_[static_cast<size_t>(i)];
      reading_.sigma(i) = data_.sigma(row) - sigma_0_(row);
    }
  }
  return reading_;
}

Integrator::Status Plant::hold(const Eigen::Ref<const Eigen::VectorXd>& command,
                               double duration) noexcept {
  actuators_.command(command);
  for (Index i = 0; i < n_legs(); ++i) {
    sigma_a_(leg_rows_[static_cast<size_t>(i)]) = actuators_.settled(i);
  }
  // The accelerations at the end of what was before scale the error of this part; after rest they
  // are zero, and those under the whole command do.
  if (q_d_ddot_.isZero(0) && !motion(0.0, y_, y_rate_)) {
    return Integrator::Status::right_hand_side_failed;
  }
  const double scale = std::max(q_d_ddot_.lpNorm<Eigen::Infinity>(), least_scale_);
  const auto status = integrator_.advance(y_, duration, scale);
  if (status != Integrator::Status::ok) return status;
  if (!right_hand_side(duration, y_, y_rate_)) return Integrator::Status::right_hand_side_failed;
  floor_.finish(duration);
  sensors_.finish(duration, actuators_);
  actuators_.finish(duration);
  return status;
}

std::string Plant::advance(const Eigen::Ref<const Eigen::VectorXd>& before,
                           const Eigen::Ref<const Eigen::VectorXd>& after, double fraction) {
  x_dot_before_ = data_.x_dot;
  floor_.take(k_);
  auto status = Integrator::Status::ok;
  if (fraction > 0) status = hold(before, fraction * sample_time_);
  if (status == Integrator::Status::ok) status = hold(after, (1 - fraction) * sample_time_);
  if (status != Integrator::Status::ok) {
    return reason_of(status, "plant at t = " + std::to_string(time()) + " s");
  }
  actuators_.sample();
  ++k_;
  return "";
}

}  // namespace stillframe

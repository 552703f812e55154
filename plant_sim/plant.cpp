#include "plant_sim/plant.hpp"

#include <cmath>
#include <sstream>

#include "core/control/design/control_loop.hpp"
#include "core/numerics/infinity.hpp"

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

double force_limit(const Scene& scene) {
  return scene.controller->force_limit_n.value_or(infinity);
}

Drive make_drive(const Scene& scene, const Model& model,
                 std::unique_ptr<floor::FloorSource> floor) {
  const auto n_legs = static_cast<Index>(scene.controller->legs.size());
  return {FloorMotion(std::move(floor), scene, model),
          Actuators(n_legs, force_limit(scene), scene.instruments),
          Disturbances(scene, model, 1 / scene.controller->sample_rate_hz),
          rows_of(scene.controller->legs, model)};
}

/// Of the two parts of a sample between which the command changes.
std::vector<double> durations(const SceneController& controller) {
  const double T = 1 / controller.sample_rate_hz;
  const double fraction = controller.delay_samples - std::floor(controller.delay_samples);
  if (fraction == 0) return {T};
  return {fraction * T, (1 - fraction) * T};
}

}  // namespace

Plant::Plant(const Scene& scene, std::unique_ptr<floor::FloorSource> floor)
    : sample_time_(1.0 / checked(scene).controller->sample_rate_hz),
      merged_(merge_rigid_bodies(scene)),
      model_(make_model(merged_.scene)),
      drive_(make_drive(merged_.scene, model_, std::move(floor))),
      sensors_(n_legs(), scene.instruments.sensor_filter_hz),
      choice_(choose_method(merged_.scene, model_, drive_)),
      motion_(make_motion(merged_, model_, choice_, drive_, durations(*scene.controller))),
      force_limit_(force_limit(scene)) {
  if (scene.instruments.force_sensors) {
    force_noise_.emplace(n_legs(), *scene.instruments.force_sensors, sample_time_,
                         scene.instruments.sensor_filter_hz);
  }
  if (scene.instruments.floor_sensors) {
    floor_noise_.emplace(static_cast<Index>(scene.inputs.size()), *scene.instruments.floor_sensors,
                         sample_time_);
  }
  for (const auto* signals : {&scene.outputs, &scene.monitors}) {
    for (const SceneSignal& signal : *signals) frame_points_.push_back(signal.name);
  }
  const auto n_frame = static_cast<Index>(frame_points_.size());
  velocity_before_ = velocity_ = Eigen::VectorXd::Zero(n_frame);
  motion_->velocities(velocity_);
  velocity_before_ = velocity_;
  stress_ = Eigen::VectorXd::Zero(n_legs());
  reading_ = {Eigen::VectorXd::Zero(static_cast<Index>(scene.inputs.size())), stress_, stress_,
              velocity_};
}

const Reading& Plant::read() noexcept {
  // Directions are fixed in space, so a mean acceleration along one is the change of velocity along
  // it.
  reading_.frame_acceleration = (velocity_ - velocity_before_) / sample_time_;
  drive_.floor().along_inputs(reading_.floor_acceleration);
  reading_.applied_force = drive_.actuators().report();
  reading_.sigma.setZero();
  if (k_ > 0) true_stresses(reading_.sigma);
  if (force_noise_) n_out_of_range_ += force_noise_->apply(reading_.sigma);
  if (floor_noise_) floor_noise_->apply(k_, reading_.floor_acceleration);
  return reading_;
}

void Plant::true_stresses(Eigen::VectorXd& sigma) noexcept {
  if (sensors_.filter()) {
    motion_->filtered_stresses(stress_);
    sigma = sensors_.actuator_part() + stress_;
    return;
  }
  motion_->elastic_stresses(stress_);
  for (Index i = 0; i < n_legs(); ++i) sigma(i) = stress_(i) + drive_.actuators().acting(i, 0);
}

Motion::Status Plant::hold(const Eigen::Ref<const Eigen::VectorXd>& command,
                           double duration) noexcept {
  drive_.actuators().command(command);
  auto status = Motion::Status::ok;
  double left = duration;
  while (left > 0 && status == Motion::Status::ok) {
    // Where slewing ends the force has a kink, which no method should step over.
    const double part = drive_.actuators().smooth_for(left);
    status = motion_->advance(drive_, part);
    if (status != Motion::Status::ok) break;
    drive_.floor().finish(part);
    sensors_.finish(part, drive_.actuators());
    drive_.actuators().finish(part);
    left = part < left ? left - part : 0;
  }
  return status;
}

std::string Plant::advance(const Eigen::Ref<const Eigen::VectorXd>& before,
                           const Eigen::Ref<const Eigen::VectorXd>& after, double fraction) {
  velocity_before_ = velocity_;
  drive_.take(k_);
  if ((after.array().abs() >= force_limit_).any()) ++n_at_limit_;
  auto status = Motion::Status::ok;
  if (fraction > 0) status = hold(before, fraction * sample_time_);
  if (status == Motion::Status::ok) status = hold(after, (1 - fraction) * sample_time_);
  if (status != Motion::Status::ok) return reason_of(status);
  motion_->velocities(velocity_);
  drive_.actuators().sample();
  if (force_noise_) force_noise_->next();
  ++k_;
  return "";
}

std::string Plant::reason_of(Motion::Status status) const {
  const std::string reason = "plant at t = " + std::to_string(time()) + " s: ";
  switch (status) {
    case Motion::Status::ok:
      return "";
    case Motion::Status::equations_failed:
      return reason +
             "the equations of motion cannot be evaluated from there on (a position that the "
             "elements cannot reach, or a mass matrix that became singular)" +
             circumstances();
    case Motion::Status::too_many_steps:
      return reason + "the integrator needs more than 100000 steps within one sample" +
             circumstances();
    case Motion::Status::failed:
      return reason + "the integrator cannot go on" + circumstances();
  }
  return reason;
}

std::string Plant::circumstances() const {
  std::ostringstream text;
  text.precision(3);
  text << ". By then";
  const Eigen::VectorXd q = motion_->displacements();
  for (const char* unit : {"m", "rad"}) {
    Index farthest = -1;
    for (Index i = 0; i < q.size(); ++i) {
      if (model_.dofs[static_cast<size_t>(i)].unit != unit) continue;
      if (farthest < 0 || !(std::abs(q(i)) <= std::abs(q(farthest)))) farthest = i;
    }
    if (farthest < 0) continue;
    text << ' ' << model_.dofs[static_cast<size_t>(farthest)].name << " was " << q(farthest) << ' '
         << unit << " from the operating point,";
  }
  if (velocity_.size() > 0) {
    Index fastest = 0;
    velocity_.cwiseAbs().maxCoeff(&fastest);
    text << ' ' << frame_points_[static_cast<size_t>(fastest)] << " moved at " << velocity_(fastest)
         << " m/s,";
  }
  text << " and " << n_at_limit_ << " of " << k_ + 1 << " samples had a command at the force limit";
  if (std::isinf(force_limit_)) text << " (there is none)";
  if (n_out_of_range_ > 0) {
    text << "; " << n_out_of_range_ << " readings of force sensors were cut off at their range";
  }
  return text.str();
}

}  // namespace stillframe

#include "plant_sim/motion/nodal_plant_motion.hpp"

#include "core/dynamics.hpp"
#include "plant_sim/motion/state_in_words.hpp"

namespace stillframe {

using Eigen::VectorXd;

namespace {

/// Positions, rates and stresses of a model at rest.
Data at_rest(const Model& model, const Equilibrium& rest) {
  Data data(model);
  data.x = rest.motion.x;
  VectorXd q_d_ddot(model.n_d);
  accelerations(model, data, rest.motion.state, VectorXd::Zero(model.n_e), q_d_ddot);
  return data;
}

}  // namespace

NodalPlantMotion::NodalPlantMotion(const Model& model, const Equilibrium& rest, FramePoints points,
                                   std::vector<Index> legs, double filter_rate,
                                   double relative_tolerance, nodal::Method method)
    : data_(at_rest(model, rest)),
      points_(std::move(points)),
      legs_(std::move(legs)),
      sigma_0_(static_cast<Index>(legs_.size())),
      driving_(VectorXd::Zero(sigma_0_.size())),
      motion_(model, data_, relative_tolerance, method) {
  for (Index i = 0; i < sigma_0_.size(); ++i) {
    sigma_0_(i) = data_.sigma(legs_[static_cast<size_t>(i)]);
  }
  if (filter_rate > 0) motion_.filter(legs_, filter_rate);
}

Motion::Status NodalPlantMotion::advance(const Drive& drive, double duration) noexcept {
  const nodal::Status status = motion_.advance(drive, duration);
  data_.x = motion_.x();
  data_.x_dot = motion_.x_dot();
  for (Index i = 0; i < driving_.size(); ++i) {
    driving_(i) = drive.actuators().acting(i, duration);
  }
  switch (status) {
    case nodal::Status::ok:
      return Status::ok;
    case nodal::Status::too_many_steps:
      return Status::too_many_steps;
    case nodal::Status::failed:
      return Status::failed;
    case nodal::Status::position_not_found:
    case nodal::Status::matrix_singular:
      break;
  }
  return Status::equations_failed;
}

void NodalPlantMotion::velocities(VectorXd& v) const noexcept {
  points_.velocities(data_.x, data_.x_dot, v);
}

void NodalPlantMotion::elastic_stresses(VectorXd& sigma) const noexcept {
  for (Index i = 0; i < sigma_0_.size(); ++i) {
    sigma(i) = motion_.sigma()(legs_[static_cast<size_t>(i)]) - driving_(i) - sigma_0_(i);
  }
}

void NodalPlantMotion::filtered_stresses(VectorXd& sigma) const noexcept {
  sigma = motion_.filtered() - sigma_0_;
}

std::string NodalPlantMotion::where() const {
  VectorXd y(data_.x.size() + data_.x_dot.size());
  y << data_.x, data_.x_dot;
  return state_in_words(y, data_.x.size());
}

}  // namespace stillframe

#include "plant_sim/motion/nodal_plant_motion.hpp"

#include <cmath>

#include "core/mechanics/dynamics.hpp"
#include "plant_sim/motion/minimal_equations.hpp"

namespace stillframe {

using Eigen::VectorXd;

namespace {

/// Positions, rates and stresses of a model at its operating point.
Data data_at(const Model& model, const NominalMotion& nominal) {
  Data data(model);
  nominal.place(data);
  VectorXd q_d_ddot(model.n_d);
  accelerations(model, data, nominal.state, VectorXd::Zero(model.n_e), q_d_ddot);
  return data;
}

/// D x_dot on a row of the deformations, D in data.
double rate_of(const Model& model, Index row, const Data& data, const VectorXd& x_dot) {
  const auto [element, mode] = model.owner_of_row(row);
  double rate = 0;
  for_each_column(model.elements[element].parts, model.n_x,
                  [&, k = element, i = mode](Index j, Index column) {
                    rate += data.D[k](i, j) * x_dot(column);
                  });
  return rate;
}

}  // namespace

NodalPlantMotion::NodalPlantMotion(const Model& model, const NominalMotion& nominal,
                                   FramePoints points, std::vector<Index> legs, double filter_rate,
                                   double relative_tolerance)
    : model_(model),
      data_(data_at(model, nominal)),
      q_0_(nominal.state.q_d),
      points_(std::move(points)),
      legs_(std::move(legs)),
      stress_scale_(largest_stiffness(model, legs_)),
      sigma_0_(static_cast<Index>(legs_.size())),
      driving_(VectorXd::Zero(sigma_0_.size())),
      motion_(model, data_, relative_tolerance) {
  for (Index i = 0; i < sigma_0_.size(); ++i) {
    sigma_0_(i) = data_.sigma(legs_[static_cast<size_t>(i)]);
  }
  if (filter_rate > 0) motion_.filter(legs_, filter_rate);
}

Motion::Status NodalPlantMotion::advance(const Drive& drive, double duration) noexcept {
  const Status status = motion_.advance(drive, duration);
  data_.x = motion_.x();
  data_.x_dot = motion_.x_dot();
  for (Index i = 0; i < driving_.size(); ++i) {
    driving_(i) = drive.actuators().acting(i, duration);
  }
  return status;
}

bool NodalPlantMotion::hand_over(const Drive&, MotionSnapshot& to) noexcept {
  to.x = motion_.x();
  to.x_dot = motion_.x_dot();
  data_.x = to.x;
  assemble(model_, data_);
  to.e = data_.e;
  count_turns(to.e);
  const Index n = model_.n_d;
  for (Index i = 0; i < n; ++i) {
    const Model::Dof& dof = model_.dofs[static_cast<size_t>(i)];
    to.y(i) = displacement(i, to.x, to.e);
    to.y(n + i) =
        dof.is_deformation ? rate_of(model_, dof.index, data_, to.x_dot) : to.x_dot(dof.index);
  }
  if (to.y.size() > 2 * n) {
    to.y.tail(to.y.size() - 2 * n) = (motion_.filtered() - sigma_0_) / stress_scale_;
  }
  return true;
}

void NodalPlantMotion::take_over(const MotionSnapshot& from) noexcept {
  data_.x = from.x;
  data_.x_dot = from.x_dot;
  VectorXd filtered = from.y.tail(from.y.size() - 2 * model_.n_d);
  if (filtered.size() > 0) filtered = sigma_0_ + stress_scale_ * filtered;
  motion_.take_over(from.x, from.x_dot, filtered, from.e);
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

VectorXd NodalPlantMotion::displacements() const {
  Data data = data_;
  assemble(model_, data);
  count_turns(data.e);
  VectorXd q(model_.n_d);
  for (Index i = 0; i < q.size(); ++i) q(i) = displacement(i, data.x, data.e);
  return q;
}

void NodalPlantMotion::count_turns(VectorXd& e) const noexcept {
  for (const ModelElement& item : model_.elements) {  // the angles of hinges go on from the last
    const double period = item.element->period();
    if (period == 0) continue;
    const double turned = motion_.turns()(item.row[0]);
    e(item.row[0]) = turned + std::remainder(e(item.row[0]) - turned, period);
  }
}

double NodalPlantMotion::displacement(Index i, const VectorXd& x,
                                      const VectorXd& e) const noexcept {
  const Model::Dof& dof = model_.dofs[static_cast<size_t>(i)];
  return (dof.is_deformation ? e(dof.index) : x(dof.index)) - q_0_(i);
}

}  // namespace stillframe

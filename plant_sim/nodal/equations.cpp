#include "plant_sim/nodal/equations.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/mechanics/model/local.hpp"
#include "core/mechanics/turning_load.hpp"

namespace stillframe::nodal {

namespace {

void add_local(const std::vector<Index>& unknown, const LocalVector& local,
               Eigen::VectorXd& r) noexcept {
  for (Index i = 0; i < local.size(); ++i) {
    const Index k = unknown[static_cast<size_t>(i)];
    if (k >= 0) r(k) += local(i);
  }
}

}  // namespace

Equations::Equations(const Model& model)
    : model_(model),
      n_free_(model.n_x - model.n_rx),
      held_of_row_(static_cast<size_t>(model.n_e), -1),
      period_(static_cast<size_t>(model.n_e), 0.0),
      q_r_(Eigen::VectorXd::Zero(model.n_r)),
      q_r_dot_(q_r_),
      q_r_ddot_(q_r_),
      sigma_a_(Eigen::VectorXd::Zero(model.n_e)),
      sigma_(sigma_a_),
      turn_(sigma_a_) {
  number_held();
  for (const ModelElement& item : model.elements) {
    Place place{&item, unknowns_of(item.parts), {}};
    for (Index i = 0; i < item.element->n_deformations(); ++i) {
      const Index row = item.row[static_cast<size_t>(i)];
      const Index held = held_of_row_[static_cast<size_t>(row)];
      place.held.push_back(held);
      (held >= 0 ? place.any_held : place.any_elastic) = true;
    }
    period_[static_cast<size_t>(item.row[0])] = item.element->period();
    places_.push_back(std::move(place));
  }
  for (const ModelInertia& item : model.inertias) {
    masses_.push_back({&item, unknowns_of(item.parts)});
  }
  order_unknowns();
}

void Equations::number_held() {
  for (Index row = 0; row < model_.n_e; ++row) {
    if (model_.is_elastic(row)) continue;
    held_of_row_[static_cast<size_t>(row)] = n_held_++;
    prescribed_of_.push_back(model_.conditions[static_cast<size_t>(row)].prescribed);
  }
}

std::vector<Index> Equations::unknowns_of(const std::vector<PartMap>& parts) const {
  std::vector<Index> unknown(static_cast<size_t>(local_size(parts)), -1);
  for_each_column(parts, n_free_,
                  [&](Index i, Index column) { unknown[static_cast<size_t>(i)] = column; });
  return unknown;
}

void Equations::order_unknowns() {
  Groups groups;
  const auto add_group = [&](const std::vector<Index>& unknown, const std::vector<Index>& held) {
    groups.emplace_back();
    for (const Index k : unknown) {
      if (k >= 0) groups.back().push_back(k);
    }
    for (const Index k : held) {
      if (k >= 0) groups.back().push_back(n_free_ + k);
    }
  };
  for (const Place& place : places_) add_group(place.unknown, place.held);
  for (const Mass& mass : masses_) add_group(mass.unknown, {});
  for (const ModelLoad& load : model_.turning_loads) {
    add_group(unknowns_of(parts_of(model_, load)), {});
  }
  order_ = narrow_ordering(size(), groups);
  const Index b = nodal::half_bandwidth(order_, groups);
  mass_ = damping_ = stiffness_ = BandMatrix(size(), b);
  ordered_ = Eigen::VectorXd::Zero(size());
  product_ = Eigen::VectorXd::Zero(size());
}

NodalState Equations::zero_state() const {
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(model_.n_x);
  return {zero, zero, zero, Eigen::VectorXd::Zero(n_held_)};
}

void Equations::take_inputs(const Inputs& inputs, double t, NodalState& state) noexcept {
  inputs.at(t, q_r_, q_r_dot_, q_r_ddot_, sigma_a_);
  external_ = inputs.external().size() > 0 ? &inputs.external() : nullptr;
  const Index n = model_.n_rx;
  state.x.tail(n) = q_r_.head(n);
  state.x_dot.tail(n) = q_r_dot_.head(n);
  state.x_ddot.tail(n) = q_r_ddot_.head(n);
}

void Equations::count_turns_from(const NodalState& state) noexcept {
  LocalVector u;
  for (const Place& place : places_) {
    const double period = place.item->element->period();
    if (period == 0) continue;
    gather(place.item->parts, state.x, u);
    LocalDeformation e(place.item->element->n_deformations());
    place.item->element->deformations(u, e);
    double& turn = turn_(place.item->row[0]);
    turn += std::remainder(e(0) - turn, period);
  }
}

void Equations::stresses(const Place& place, const LocalVector& u, const LocalVector& v,
                         const LocalJacobian& D, const NodalState& state,
                         LocalDeformation& s) noexcept {
  const ModelElement& item = *place.item;
  LocalDeformation e(s.size()), e_dot(s.size());
  const bool resists = place.any_elastic && item.S.size() > 0;
  if (resists) {
    item.element->deformations(u, e);
    const double period = item.element->period();
    if (period > 0) {
      const double turn = turn_(item.row[0]);
      e(0) = turn + std::remainder(e(0) - turn, period);
    }
    if (item.damped) e_dot.noalias() = D * v;
  }
  for (Index i = 0; i < s.size(); ++i) {
    const Index row = item.row[static_cast<size_t>(i)];
    const Index held = place.held[static_cast<size_t>(i)];
    if (held >= 0) {
      s(i) = state.lambda(held);
    } else {
      s(i) = model_.preload(row) + sigma_a_(row);
      for (Index j = 0; resists && j < s.size(); ++j) {
        if (item.zero[static_cast<size_t>(j)]) continue;
        s(i) += item.S(i, j) * e(j);
        if (item.damped) s(i) += item.S_d(i, j) * e_dot(j);
      }
    }
    sigma_(row) = s(i);
  }
}

void Equations::add_element(const Place& place, const NodalState& state,
                            Eigen::VectorXd& r) noexcept {
  const ModelElement& item = *place.item;
  const Index n_e = item.element->n_deformations();
  LocalVector u, v, a;
  gather(item.parts, state.x, u);
  gather(item.parts, state.x_dot, v);
  LocalJacobian D(n_e, item.element->n_local());
  item.element->jacobian(u, D);
  LocalDeformation s(n_e);
  stresses(place, u, v, D, state, s);
  LocalVector force = D.transpose() * s;
  rows_to_node_axes(item.parts, force);
  add_local(place.unknown, force, r);
  if (!place.any_held) return;
  gather(item.parts, state.x_ddot, a);
  LocalDeformation e_ddot(n_e);
  item.element->second_derivative(u, v, v, e_ddot);
  e_ddot.noalias() += D * a;
  for (Index i = 0; i < n_e; ++i) {
    const Index held = place.held[static_cast<size_t>(i)];
    if (held >= 0) r(n_free_ + held) += e_ddot(i);
  }
}

void Equations::add_mass(const Mass& mass, const NodalState& state, Eigen::VectorXd& r) noexcept {
  LocalVector u, v, a, F(mass.item->inertia->n_local());
  gather(mass.item->parts, state.x, u);
  gather(mass.item->parts, state.x_dot, v);
  gather(mass.item->parts, state.x_ddot, a);
  mass.item->inertia->force(u, v, a, model_.gravity, F);
  rows_to_node_axes(mass.item->parts, F);
  add_local(mass.unknown, F, r);
}

void Equations::residual(const NodalState& state, Eigen::VectorXd& r) noexcept {
  r.setZero();
  r.head(n_free_) -= model_.load.head(n_free_);
  if (external_) r.head(n_free_) -= external_->head(n_free_);
  for (Index i = 0; i < n_held_; ++i) {
    const Index prescribed = prescribed_of_[static_cast<size_t>(i)];
    if (prescribed >= 0) r(n_free_ + i) -= q_r_ddot_(model_.n_rx + prescribed);
  }
  for (const Place& place : places_) add_element(place, state, r);
  for (const Mass& mass : masses_) add_mass(mass, state, r);
  add_turning_loads(model_, state.x, -1, n_free_, r);
}

void Equations::position_errors(const NodalState& state, Eigen::VectorXd& r) noexcept {
  r.setZero();
  LocalVector u;
  for (const Place& place : places_) {
    if (!place.any_held) continue;
    gather(place.item->parts, state.x, u);
    LocalDeformation e(place.item->element->n_deformations());
    place.item->element->deformations(u, e);
    const double period = place.item->element->period();
    for (Index i = 0; i < e.size(); ++i) {
      const Index held = place.held[static_cast<size_t>(i)];
      if (held < 0) continue;
      const Index prescribed = prescribed_of_[static_cast<size_t>(held)];
      const double wanted = prescribed >= 0 ? q_r_(model_.n_rx + prescribed) : 0.0;
      // The remainder of the wanted angle alone is exact, also after many revolutions.
      r(n_free_ + held) = period > 0 && i == 0
                              ? std::remainder(e(i) - std::remainder(wanted, period), period)
                              : e(i) - wanted;
    }
  }
}

void Equations::rate_errors(const NodalState& state, Eigen::VectorXd& r) noexcept {
  r.setZero();
  LocalVector u, v;
  for (const Place& place : places_) {
    if (!place.any_held) continue;
    const Element& element = *place.item->element;
    gather(place.item->parts, state.x, u);
    gather(place.item->parts, state.x_dot, v);
    LocalJacobian D(element.n_deformations(), element.n_local());
    element.jacobian(u, D);
    for (Index i = 0; i < D.rows(); ++i) {
      const Index held = place.held[static_cast<size_t>(i)];
      if (held < 0) continue;
      const Index prescribed = prescribed_of_[static_cast<size_t>(held)];
      const double wanted = prescribed >= 0 ? q_r_dot_(model_.n_rx + prescribed) : 0.0;
      r(n_free_ + held) = D.row(i).dot(v) - wanted;
    }
  }
}

Eigen::VectorXd Equations::rounding(const NodalState& state) const {
  const double epsilon = std::numeric_limits<double>::epsilon();
  Eigen::VectorXd total = model_.load.head(n_free_).cwiseAbs();
  LocalVector u;
  for (const Place& place : places_) {
    const Element& element = *place.item->element;
    gather(place.item->parts, state.x, u);
    LocalJacobian D(element.n_deformations(), element.n_local());
    element.jacobian(u, D);
    columns_to_node_axes(place.item->parts, D);
    LocalDeformation s(D.rows());
    for (Index i = 0; i < D.rows(); ++i) {
      s(i) = std::abs(sigma_(place.item->row[static_cast<size_t>(i)]));
      if (place.item->S.size() == 0 || place.held[static_cast<size_t>(i)] >= 0) continue;
      s(i) += place.item->S.row(i).cwiseAbs().maxCoeff() * u.lpNorm<Eigen::Infinity>();
    }
    const LocalVector force = D.cwiseAbs().transpose() * s;
    add_local(place.unknown, force, total);
  }
  return epsilon * total;
}

}  // namespace stillframe::nodal

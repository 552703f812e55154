// The derivatives of the equations in nodal coordinates.
#include "core/mechanics/model/local_terms.hpp"
#include "core/mechanics/turning_load.hpp"
#include "plant_sim/nodal/equations.hpp"

namespace stillframe::nodal {

void Equations::add_square(const std::vector<Index>& unknown, const LocalHessian& block,
                           BandMatrix& matrix) noexcept {
  for (Index j = 0; j < block.cols(); ++j) {
    const Index column = unknown[static_cast<size_t>(j)];
    if (column < 0) continue;
    for (Index i = 0; i < block.rows(); ++i) {
      const Index row = unknown[static_cast<size_t>(i)];
      if (row >= 0) matrix.add(place_of(row), place_of(column), block(i, j));
    }
  }
}

void Equations::differentiate_element(const Place& place, const NodalState& state,
                                      bool all) noexcept {
  const ModelElement& item = *place.item;
  if (!all && !place.any_held) return;
  const Index n_e = item.element->n_deformations(), n = item.element->n_local();
  LocalVector u, v, a;
  gather(item.parts, state.x, u);
  LocalJacobian D(n_e, n), rate(n_e, n), second_rate(n_e, n);
  item.element->jacobian(u, D);
  if (all) {
    gather(item.parts, state.x_dot, v);
    gather(item.parts, state.x_ddot, a);
    item.element->jacobian_rates(u, v, a, rate, second_rate);
    LocalDeformation s(n_e);
    stresses(place, u, v, D, state, s);
    LocalHessian K(n, n);
    item.element->hessian(u, s, K);
    if (item.S.size() > 0) {
      // What the stresses of the elastic deformations have of those that are not zero.
      LocalStiffness S = item.S, S_d = item.S_d;
      for (Index i = 0; i < n_e; ++i) {
        if (place.held[static_cast<size_t>(i)] >= 0) {
          S.row(i).setZero();
          if (item.damped) S_d.row(i).setZero();
        }
        if (item.zero[static_cast<size_t>(i)]) {
          S.col(i).setZero();
          if (item.damped) S_d.col(i).setZero();
        }
      }
      const LocalJacobian product = S * D;
      K.noalias() += D.transpose() * product;
      if (item.damped) {
        const LocalJacobian damped = S_d * D, damped_rate = S_d * rate;
        LocalHessian C = D.transpose() * damped;
        K.noalias() += D.transpose() * damped_rate;
        to_node_axes(item.parts, C);
        add_square(place.unknown, C, damping_);
      }
    }
    to_node_axes(item.parts, K);
    add_square(place.unknown, K, stiffness_);
    columns_to_node_axes(item.parts, rate);
    columns_to_node_axes(item.parts, second_rate);
  }
  if (!place.any_held) return;
  columns_to_node_axes(item.parts, D);
  for (Index i = 0; i < n_e; ++i) {
    const Index held = place.held[static_cast<size_t>(i)];
    if (held < 0) continue;
    const Index row = place_of(n_free_ + held);
    for (Index j = 0; j < n; ++j) {
      const Index unknown = place.unknown[static_cast<size_t>(j)];
      if (unknown < 0) continue;
      const Index column = place_of(unknown);
      mass_.add(row, column, D(i, j));
      mass_.add(column, row, D(i, j));
      if (!all) continue;
      damping_.add(row, column, 2 * rate(i, j));
      stiffness_.add(row, column, second_rate(i, j));
    }
  }
}

void Equations::differentiate_mass(const Mass& mass, const NodalState& state, bool all) noexcept {
  const LocalHessian M = local_mass(*mass.item, state.x);
  add_square(mass.unknown, M, mass_);
  if (!all) return;
  LocalVector u, v, a;
  gather(mass.item->parts, state.x, u);
  gather(mass.item->parts, state.x_dot, v);
  gather(mass.item->parts, state.x_ddot, a);
  LocalHessian C(M.rows(), M.rows()), K(M.rows(), M.rows());
  mass.item->inertia->tangents(u, v, a, model_.gravity, C, K);
  to_node_axes(mass.item->parts, C);
  to_node_axes(mass.item->parts, K);
  add_square(mass.unknown, C, damping_);
  add_square(mass.unknown, K, stiffness_);
}

void Equations::differentiate_turning_loads(const NodalState& state) noexcept {
  for (const ModelLoad& load : model_.turning_loads) {
    const ModelNode& node = model_.nodes[static_cast<size_t>(load.node)];
    const TurnedLoad turned(load, rotation_displacement(node, state.x), model_.planar);
    const Eigen::Matrix<double, 3, 4> d_force = node.translation.basis.transpose() * turned.d_force;
    const auto number = [&](const PartMap& map, Index i) {
      const Index column = map.column[static_cast<size_t>(i)];
      return column < n_free_ ? column : -1;
    };
    for (Index j = 0; j < node.rotation.size; ++j) {
      const Index column = number(node.rotation, j);
      if (column < 0) continue;
      for (Index i = 0; i < node.translation.size; ++i) {
        const Index row = number(node.translation, i);
        if (row >= 0) stiffness_.add(place_of(row), place_of(column), -d_force(i, j));
      }
      for (Index i = 0; i < node.rotation.size; ++i) {
        const Index row = number(node.rotation, i);
        if (row >= 0) stiffness_.add(place_of(row), place_of(column), -turned.d_moment(i, j));
      }
    }
  }
}

void Equations::differentiate(const NodalState& state, bool all) noexcept {
  mass_.set_zero();
  if (all) {
    damping_.set_zero();
    stiffness_.set_zero();
  }
  for (const Place& place : places_) differentiate_element(place, state, all);
  for (const Mass& mass : masses_) differentiate_mass(mass, state, all);
  if (all) differentiate_turning_loads(state);
}

void Equations::add_product(const BandMatrix& matrix, double factor,
                            const Eigen::Ref<const Eigen::VectorXd>& dx,
                            Eigen::VectorXd& r) noexcept {
  ordered_.setZero();
  product_.setZero();
  for (Index i = 0; i < n_free_; ++i) ordered_(place_of(i)) = dx(i);
  matrix.add_product(ordered_, product_);
  for (Index i = 0; i < size(); ++i) r(i) += factor * product_(place_of(i));
}

}  // namespace stillframe::nodal

#include "core/mechanics/dynamics.hpp"

#include <Eigen/Cholesky>

#include "core/mechanics/model/local_terms.hpp"
#include "core/mechanics/turning_load.hpp"

namespace stillframe {

namespace {

void stress_resultants(const Model& model, Data& data, const MotionState& state,
                       const Eigen::VectorXd& sigma_a) noexcept {
  // The prescribed value of a dynamic deformation is exact, what the nodes give is rounded.
  for (Index i = 0; i < model.n_d; ++i) {
    const Model::Dof& dof = model.dofs[static_cast<size_t>(i)];
    if (dof.is_deformation) data.e(dof.index) = state.q_d(i);
  }
  for (size_t i = 0; i < model.prescribed_rows.size(); ++i) {
    data.e(model.prescribed_rows[i]) = state.q_r(model.n_rx + static_cast<Index>(i));
  }
  data.sigma = data.load_factor * model.preload + sigma_a;
  add_element_stresses(model, data.e, data.e_dot, data.sigma);
  if (model.modal_dampers.size() == 0) return;
  data.damper_rates.noalias() = model.modal_dampers.transpose() * data.e_dot;
  data.sigma.noalias() += model.modal_dampers * data.damper_rates;
}

}  // namespace

void add_element_stresses(const Model& model, const Eigen::VectorXd& e,
                          const Eigen::VectorXd& e_dot, Eigen::VectorXd& sigma) noexcept {
  for (const ModelElement& item : model.elements) {
    if (item.S.size() == 0) continue;
    const Index n_e = item.S.rows();
    for (Index i = 0; i < n_e; ++i) {
      double sum = 0;
      for (Index j = 0; j < n_e; ++j) {
        if (item.zero[static_cast<size_t>(j)]) continue;
        const Index row = item.row[static_cast<size_t>(j)];
        sum += item.S(i, j) * e(row);
        if (item.damped) sum += item.S_d(i, j) * e_dot(row);
      }
      sigma(item.row[static_cast<size_t>(i)]) += sum;
    }
  }
}

void mass_matrix(const Model& model, Data& data) noexcept {
  data.M_dd.setZero();
  for (const ModelInertia& item : model.inertias) {
    const LocalHessian M = local_mass(item, data.x);
    const Index n = M.rows();
    auto product = data.local_rows.topRows(n);
    product.setZero();
    for_each_column(item.parts, model.n_x, [&](Index j, Index column) {
      for (Index i = 0; i < n; ++i) {
        if (M(i, j) != 0.0) product.row(i) += M(i, j) * data.DF.row(column);
      }
    });
    for_each_column(item.parts, model.n_x, [&](Index i, Index column) {
      data.M_dd.noalias() += data.DF.row(column).transpose() * product.row(i);
    });
  }
}

bool generalised_forces(const Model& model, Data& data, const MotionState& state,
                        const Eigen::VectorXd& sigma_a) noexcept {
  if (!solve_positions(model, data, state)) return false;
  geometric_transfer_functions(model, data);
  velocities(model, data, state);
  stress_resultants(model, data, state, sigma_a);
  data.f = data.load_factor * model.load;
  if (data.external != nullptr) data.f += *data.external;
  add_turning_loads(model, data.x, data.load_factor, model.n_x, data.f);
  subtract_inertia_forces(model, data.x, data.x_dot, data.x_ddot_0,
                          data.load_factor * model.gravity, data.f);
  data.f_dd.noalias() = data.DF.transpose() * data.f;
  for (Index i = 0; i < model.n_d; ++i) {
    const Model::Dof& dof = model.dofs[static_cast<size_t>(i)];
    if (dof.is_deformation) data.f_dd(i) -= data.sigma(dof.index);
  }
  if (model.n_redundant > 0) {
    data.f_dd.noalias() -= data.DF_e.transpose() * data.sigma.tail(model.n_redundant);
  }
  return true;
}

void complete_accelerations(Data& data, const Eigen::VectorXd& q_d_ddot) noexcept {
  data.x_ddot = data.x_ddot_0;
  data.x_ddot.noalias() += data.DF * q_d_ddot;
}

DynamicsStatus accelerations(const Model& model, Data& data, const MotionState& state,
                             const Eigen::VectorXd& sigma_a, Eigen::VectorXd& q_d_ddot) noexcept {
  if (!generalised_forces(model, data, state, sigma_a)) return DynamicsStatus::position_not_found;
  mass_matrix(model, data);
  data.M_factor = data.M_dd;
  Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factors(data.M_factor);  // in place
  if (factors.info() != Eigen::Success) return DynamicsStatus::mass_matrix_singular;
  q_d_ddot = data.f_dd;
  factors.solveInPlace(q_d_ddot);
  complete_accelerations(data, q_d_ddot);
  return DynamicsStatus::ok;
}

namespace {

/// f -= D^T sigma, of the redundant deformations alone or of all.
void subtract_stresses(const Model& model, const Data& data, bool redundant_only,
                       Eigen::VectorXd& f) {
  for (size_t k = 0; k < model.elements.size(); ++k) {
    const ModelElement& item = model.elements[k];
    for_each_column(item.parts, f.size(), [&](Index j, Index column) {
      for (Index i = 0; i < data.D[k].rows(); ++i) {
        const Index row = item.row[static_cast<size_t>(i)];
        if (row >= model.n_c) f(column) -= data.D[k](i, j) * data.sigma(row);
        if (row < model.n_c && !redundant_only) {
          f(column) -= data.D[k](i, j) * data.sigma_balanced(row);
        }
      }
    });
  }
}

}  // namespace

Eigen::VectorXd inertia_forces(const Model& model, const Data& data) {
  Eigen::VectorXd f = Eigen::VectorXd::Zero(model.n_x + model.n_0);
  subtract_inertia_forces(model, data.x, data.x_dot, data.x_ddot, Eigen::Vector3d::Zero(), f);
  return -f;
}

Eigen::VectorXd applied_forces(const Model& model, const Data& data) {
  Eigen::VectorXd f(model.n_x + model.n_0);
  f << model.load, model.fixed_load;
  f *= data.load_factor;
  if (data.external != nullptr) f.head(model.n_x) += *data.external;
  add_turning_loads(model, data.x, data.load_factor, f.size(), f);
  if (model.gravity.isZero(0)) return f;
  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(model.n_x);
  subtract_inertia_forces(model, data.x, rest, rest, data.load_factor * model.gravity, f);
  return f;
}

void reaction_stresses(const Model& model, Data& data) {
  Eigen::VectorXd f = applied_forces(model, data) - inertia_forces(model, data);
  subtract_stresses(model, data, true, f);
  Eigen::VectorXd right = f.head(model.n_c);
  data.J.solve_transposed(right);
  data.sigma_balanced = data.sigma;
  data.sigma_balanced.head(model.n_c) = right;
  for (Index row = 0; row < model.n_c; ++row) {
    if (!model.is_elastic(row)) data.sigma(row) = right(row);
  }
}

Eigen::VectorXd constraint_forces(const Model& model, const Data& data) {
  Eigen::VectorXd f = applied_forces(model, data) - inertia_forces(model, data);
  subtract_stresses(model, data, false, f);
  return -f;
}

double kinetic_energy(const Model& model, const Data& data) {
  double energy = 0;
  LocalVector u, v;
  for (const ModelInertia& item : model.inertias) {
    gather(item.parts, data.x, u);
    gather(item.parts, data.x_dot, v);
    energy += item.inertia->kinetic_energy(u, v);
  }
  return energy;
}

double elastic_energy(const Model& model, const Data& data) {
  double energy = 0;
  for (const ModelElement& item : model.elements) {
    if (item.S.size() == 0) continue;
    LocalDeformation e(item.S.rows());
    for (Index i = 0; i < e.size(); ++i) {
      const auto k = static_cast<size_t>(i);
      e(i) = item.zero[k] ? 0.0 : data.e(item.row[k]);
    }
    energy += 0.5 * e.dot(item.S * e);
  }
  return energy;
}

double potential_energy(const Model& model, const Data& data) {
  double energy = elastic_energy(model, data) + model.preload.dot(data.e) - model.load.dot(data.x);
  LocalVector u;
  for (const ModelInertia& item : model.inertias) {
    gather(item.parts, data.x, u);
    energy += item.inertia->gravity_energy(u, model.gravity);
  }
  return energy;
}

}  // namespace stillframe

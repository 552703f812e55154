#include "core/dynamics.hpp"

#include <Eigen/Cholesky>

#include "core/elements/rotation.hpp"

namespace stillframe {

namespace {

Vector4 rotation_part(const PartMap& map, const Eigen::VectorXd& x) noexcept {
  Vector4 part = Vector4::Zero();
  for (size_t i = 0; i < 4; ++i) {
    if (map.column[i] >= 0) part(static_cast<Index>(i)) = x(map.column[i]);
  }
  return part;
}

/// Calls use(column, component) for every coordinate of a part that can move.
template <class Use>
void for_each_column(const PartMap& map, size_t size, const Use& use) noexcept {
  for (size_t i = 0; i < size; ++i) {
    if (map.column[i] >= 0) use(map.column[i], static_cast<Index>(i));
  }
}

const ModelNode& node_of(const Model& model, const LumpedMass& mass) noexcept {
  return model.nodes[static_cast<size_t>(mass.node)];
}

/// Subtracts M x_ddot_0 from f and adds f_in = -8 Lambda(lambda')^T J Lambda(lambda) lambda'.
void add_inertia_forces(const Model& model, Data& data) noexcept {
  for (const LumpedMass& mass : model.masses) {
    const ModelNode& node = node_of(model, mass);
    for_each_column(node.translation, 3,
                    [&](Index c, Index) { data.f(c) -= mass.mass * data.x_ddot_0(c); });
    if (!mass.has_inertia) continue;
    const Vector4 lambda = euler_parameters(rotation_part(node.rotation, data.x));
    const Vector4 rate = rotation_part(node.rotation, data.x_dot);
    const Vector4 acceleration = rotation_part(node.rotation, data.x_ddot_0);
    const Eigen::Matrix<double, 3, 4> L = body_rate_matrix(lambda);
    const Vector4 force = -8.0 * body_rate_matrix(rate).transpose() * (mass.inertia * (L * rate)) -
                          4.0 * L.transpose() * (mass.inertia * (L * acceleration));
    for_each_column(node.rotation, 4, [&](Index c, Index i) { data.f(c) += force(i); });
  }
}

void stress_resultants(const Model& model, Data& data, const MotionState& state,
                       const Eigen::VectorXd& sigma_a) noexcept {
  // The prescribed value of a dynamic deformation is exact, what the nodes give is rounded.
  for (Index i = 0; i < model.n_d; ++i) {
    const Model::Dof& dof = model.dofs[static_cast<size_t>(i)];
    if (dof.is_deformation) data.e(dof.index) = state.q_d(i);
  }
  data.sigma = model.preload + sigma_a + model.stiffness.cwiseProduct(data.e) +
               model.damping.cwiseProduct(data.e_dot);
}

}  // namespace

MotionState::MotionState(const Model& model)
    : q_d(Eigen::VectorXd::Zero(model.n_d)),
      q_d_dot(Eigen::VectorXd::Zero(model.n_d)),
      q_r(Eigen::VectorXd::Zero(model.n_r)),
      q_r_dot(Eigen::VectorXd::Zero(model.n_r)),
      q_r_ddot(Eigen::VectorXd::Zero(model.n_r)) {}

void mass_matrix(const Model& model, Data& data) noexcept {
  data.M_dd.setZero();
  for (const LumpedMass& mass : model.masses) {
    const ModelNode& node = node_of(model, mass);
    for_each_column(node.translation, 3, [&](Index c, Index) {
      data.M_dd.noalias() += mass.mass * data.DF.row(c).transpose() * data.DF.row(c);
    });
    if (!mass.has_inertia) continue;
    const Eigen::Matrix<double, 3, 4> L =
        body_rate_matrix(euler_parameters(rotation_part(node.rotation, data.x)));
    for (Index a = 0; a < model.n_d; ++a) {
      Vector4 column = Vector4::Zero();
      for_each_column(node.rotation, 4, [&](Index c, Index i) { column(i) = data.DF(c, a); });
      const Vector3 momentum = mass.inertia * (2.0 * (L * column));
      const Vector4 dual = 2.0 * (L.transpose() * momentum);
      for (Index b = 0; b < model.n_d; ++b) {
        double sum = 0;
        for_each_column(node.rotation, 4,
                        [&](Index c, Index i) { sum += dual(i) * data.DF(c, b); });
        data.M_dd(b, a) += sum;
      }
    }
  }
}

Eigen::MatrixXd project_mass(const Model& model, const Data& data, const Eigen::MatrixXd& a) {
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(model.n_x, a.cols());
  for (const LumpedMass& mass : model.masses) {
    const ModelNode& node = node_of(model, mass);
    for_each_column(node.translation, 3,
                    [&](Index c, Index) { product.row(c) += mass.mass * a.row(c); });
    if (!mass.has_inertia) continue;
    const Eigen::Matrix<double, 3, 4> L =
        body_rate_matrix(euler_parameters(rotation_part(node.rotation, data.x)));
    const Eigen::Matrix4d M = 4.0 * L.transpose() * mass.inertia * L;
    for_each_column(node.rotation, 4, [&](Index row, Index i) {
      for_each_column(node.rotation, 4,
                      [&](Index c, Index j) { product.row(row) += M(i, j) * a.row(c); });
    });
  }
  return data.DF.transpose() * product;
}

DynamicsStatus accelerations(const Model& model, Data& data, const MotionState& state,
                             const Eigen::VectorXd& sigma_a, Eigen::VectorXd& q_d_ddot) noexcept {
  if (!solve_positions(model, data, state.q_d, state.q_r))
    return DynamicsStatus::position_not_found;
  geometric_transfer_functions(model, data);
  velocities(model, data, state.q_d_dot, state.q_r_dot, state.q_r_ddot);
  stress_resultants(model, data, state, sigma_a);

  data.f = model.load;
  add_inertia_forces(model, data);
  data.f_dd.noalias() = data.DF.transpose() * data.f;
  for (Index i = 0; i < model.n_d; ++i) {
    const Model::Dof& dof = model.dofs[static_cast<size_t>(i)];
    if (dof.is_deformation) data.f_dd(i) -= data.sigma(dof.index);
  }
  if (model.n_redundant > 0) {
    data.f_dd.noalias() -= data.DF_e.transpose() * data.sigma.tail(model.n_redundant);
  }

  mass_matrix(model, data);
  Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factors(data.M_dd);  // in place
  if (factors.info() != Eigen::Success) return DynamicsStatus::mass_matrix_singular;
  q_d_ddot = data.f_dd;
  factors.solveInPlace(q_d_ddot);
  data.x_ddot = data.x_ddot_0;
  data.x_ddot.noalias() += data.DF * q_d_ddot;
  return DynamicsStatus::ok;
}

double kinetic_energy(const Model& model, const Data& data) {
  double energy = 0;
  for (const LumpedMass& mass : model.masses) {
    const ModelNode& node = node_of(model, mass);
    for_each_column(node.translation, 3, [&](Index c, Index) {
      energy += 0.5 * mass.mass * data.x_dot(c) * data.x_dot(c);
    });
    if (!mass.has_inertia) continue;
    const Vector4 lambda = euler_parameters(rotation_part(node.rotation, data.x));
    const Vector3 omega = 2.0 * body_rate_matrix(lambda) * rotation_part(node.rotation, data.x_dot);
    energy += 0.5 * omega.dot(mass.inertia * omega);
  }
  return energy;
}

double potential_energy(const Model& model, const Data& data) {
  return model.preload.dot(data.e) + 0.5 * data.e.dot(model.stiffness.cwiseProduct(data.e)) -
         model.load.dot(data.x);
}

}  // namespace stillframe

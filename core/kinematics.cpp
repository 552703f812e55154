#include "core/kinematics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stillframe {

namespace {

/// The global displacements (or rates) of an element's parts out of a vector of moving coordinates.
void gather(const ModelElement& item, const Eigen::VectorXd& x, LocalVector& local) noexcept {
  local.resize(item.element->n_local());
  Index at = 0;
  for (size_t p = 0; p < item.parts.size(); ++p) {
    const PartMap& map = item.parts[p];
    const Index size = item.element->parts()[p].size();
    for (Index i = 0; i < size; ++i) {
      const Index column = map.column[static_cast<size_t>(i)];
      local(at + i) = column >= 0 ? x(column) : 0.0;
    }
    if (!map.global_axes) local.segment<3>(at) = (map.basis * local.segment<3>(at)).eval();
    at += size;
  }
}

/// Columns of a local matrix, turned into the node's own basis, added to the columns of the moving
/// coordinates.
template <class Add>
void scatter_columns(const ModelElement& item, LocalJacobian& local, const Add& add) noexcept {
  Index at = 0;
  for (size_t p = 0; p < item.parts.size(); ++p) {
    const PartMap& map = item.parts[p];
    const Index size = item.element->parts()[p].size();
    if (!map.global_axes) local.middleCols<3>(at) = (local.middleCols<3>(at) * map.basis).eval();
    for (Index i = 0; i < size; ++i) {
      const Index column = map.column[static_cast<size_t>(i)];
      if (column >= 0) add(column, local.col(at + i));
    }
    at += size;
  }
}

void assemble_deformations(const Model& model, Data& data) noexcept {
  LocalVector u;
  LocalDeformation e;
  for (const ModelElement& item : model.elements) {
    gather(item, data.x, u);
    e.resize(item.element->n_deformations());
    item.element->deformations(u, e);
    for (Index i = 0; i < e.size(); ++i) data.e(item.row[static_cast<size_t>(i)]) = e(i);
  }
}

void assemble_jacobian(const Model& model, Data& data) noexcept {
  LocalVector u;
  LocalJacobian D;
  data.D.setZero();
  for (const ModelElement& item : model.elements) {
    gather(item, data.x, u);
    D.resize(item.element->n_deformations(), item.element->n_local());
    item.element->jacobian(u, D);
    scatter_columns(item, D, [&](Index column, const auto& values) {
      for (Index i = 0; i < D.rows(); ++i) {
        data.D(item.row[static_cast<size_t>(i)], column) += values(i);
      }
    });
  }
}

/// Residual of the conditions, e - e_prescribed, in data.condition.
void condition_residual(const Model& model, Data& data, const Eigen::VectorXd& q_d) noexcept {
  assemble_deformations(model, data);
  data.condition = data.e.head(model.n_c);
  for (Index i = 0; i < model.n_d; ++i) {
    const Model::Dof& dof = model.dofs[static_cast<size_t>(i)];
    if (dof.is_deformation) data.condition(dof.index) -= q_d(i);
  }
}

void factorise(const Model& model, Data& data) noexcept {
  assemble_jacobian(model, data);
  data.J.compute(data.D.topLeftCorner(model.n_c, model.n_c));
}

/// J^-1 b in place. Eigen permutes in place with a mask that it allocates, so the rows go by way of
/// work space.
template <class Matrix>
void solve_conditions(Data& data, Matrix& b) noexcept {
  if (b.size() == 0) return;
  auto permuted = data.permuted.leftCols(b.cols());
  permuted = b;
  const auto& target = data.J.permutationP().indices();
  for (Index i = 0; i < b.rows(); ++i) b.row(target(i)) = permuted.row(i);
  data.J.matrixLU().template triangularView<Eigen::UnitLower>().solveInPlace(b);
  data.J.matrixLU().template triangularView<Eigen::Upper>().solveInPlace(b);
}

}  // namespace

Data::Data(const Model& model)
    : x(Eigen::VectorXd::Zero(model.n_x)),
      e(Eigen::VectorXd::Zero(model.n_e)),
      D(Eigen::MatrixXd::Zero(model.n_e, model.n_x)),
      J(model.n_c),
      DF(Eigen::MatrixXd::Zero(model.n_x, model.n_d)),
      DF_e(Eigen::MatrixXd::Zero(model.n_redundant, model.n_d)),
      x_dot(Eigen::VectorXd::Zero(model.n_x)),
      e_dot(Eigen::VectorXd::Zero(model.n_e)),
      x_ddot_0(Eigen::VectorXd::Zero(model.n_x)),
      M_dd(Eigen::MatrixXd::Zero(model.n_d, model.n_d)),
      sigma(Eigen::VectorXd::Zero(model.n_e)),
      f(Eigen::VectorXd::Zero(model.n_x)),
      f_dd(Eigen::VectorXd::Zero(model.n_d)),
      x_ddot(Eigen::VectorXd::Zero(model.n_x)),
      condition(Eigen::VectorXd::Zero(model.n_c)),
      conditions(Eigen::MatrixXd::Zero(model.n_c, model.n_d)),
      permuted(Eigen::MatrixXd::Zero(model.n_c, std::max<Index>(model.n_d, 1))) {
  const bool square = model.n_c == model.n_e - model.n_redundant;
  if (square) factorise(model, *this);
}

void assemble(const Model& model, Data& data) noexcept {
  assemble_deformations(model, data);
  assemble_jacobian(model, data);
}

bool solve_positions(const Model& model, Data& data, const Eigen::VectorXd& q_d,
                     const Eigen::VectorXd& q_r) noexcept {
  for (Index i = 0; i < model.n_d; ++i) {
    const Model::Dof& dof = model.dofs[static_cast<size_t>(i)];
    if (!dof.is_deformation) data.x(dof.index) = q_d(i);
  }
  data.x.tail(model.n_r) = q_r;
  if (model.n_c == 0) {
    assemble_deformations(model, data);
    return true;
  }
  constexpr double epsilon = std::numeric_limits<double>::epsilon();
  double last_step = std::numeric_limits<double>::infinity();
  bool fresh = false;
  for (int iteration = 0; iteration < 50; ++iteration) {
    condition_residual(model, data, q_d);
    solve_conditions(data, data.condition);
    data.x.head(model.n_c) -= data.condition;
    const double step = data.condition.lpNorm<Eigen::Infinity>();
    const double size = data.x.lpNorm<Eigen::Infinity>();
    if (!std::isfinite(step)) return false;
    // Displacements carry a relative rounding of a few epsilon; below that a step is noise. On the
    // way to displacements that are exactly zero the size shrinks with the step, so that 1e-30 (m,
    // rad), far below all motion that counts, ends it.
    if (step <= 8 * epsilon * size || step < 1e-30) return true;
    if (step > 0.25 * last_step) {
      // With fresh factors only the rounding of a badly conditioned J stops Newton's method so
      // close.
      if (fresh && step <= 1e-8 * size) return true;
      factorise(model, data);
      fresh = true;
    } else {
      fresh = false;
    }
    last_step = step;
  }
  return false;
}

void geometric_transfer_functions(const Model& model, Data& data) noexcept {
  factorise(model, data);
  data.DF.setZero();
  data.conditions.setZero();
  for (Index i = 0; i < model.n_d; ++i) {
    const Model::Dof& dof = model.dofs[static_cast<size_t>(i)];
    if (dof.is_deformation) {
      data.conditions(dof.index, i) = 1.0;
    } else {
      data.conditions.col(i) = -data.D.col(dof.index).head(model.n_c);
      data.DF(dof.index, i) = 1.0;
    }
  }
  solve_conditions(data, data.conditions);
  data.DF.topRows(model.n_c) = data.conditions;
  if (model.n_redundant > 0) {
    data.DF_e.noalias() = data.D.bottomRows(model.n_redundant) * data.DF;
  }
}

void velocities(const Model& model, Data& data, const Eigen::VectorXd& q_d_dot,
                const Eigen::VectorXd& q_r_dot, const Eigen::VectorXd& q_r_ddot) noexcept {
  const Index n_c = model.n_c, n_r = model.n_r;
  data.condition.noalias() = -data.D.topRightCorner(n_c, n_r) * q_r_dot;
  solve_conditions(data, data.condition);
  data.x_dot.noalias() = data.DF * q_d_dot;
  data.x_dot.head(n_c) += data.condition;
  data.x_dot.tail(n_r) = q_r_dot;
  data.e_dot.head(n_c).setZero();
  for (Index i = 0; i < model.n_d; ++i) {
    const Model::Dof& dof = model.dofs[static_cast<size_t>(i)];
    if (dof.is_deformation) data.e_dot(dof.index) = q_d_dot(i);
  }
  data.e_dot.tail(model.n_redundant).noalias() = data.D.bottomRows(model.n_redundant) * data.x_dot;

  // J x_ddot_0 = -D2(x_dot, x_dot) - D_r q_r_ddot: the conditions differentiated twice with
  // q_d_ddot = 0.
  data.condition.noalias() = -data.D.topRightCorner(n_c, n_r) * q_r_ddot;
  LocalVector u, rate;
  LocalDeformation second;
  for (const ModelElement& item : model.elements) {
    gather(item, data.x, u);
    gather(item, data.x_dot, rate);
    second.resize(item.element->n_deformations());
    item.element->second_derivative(u, rate, rate, second);
    for (Index i = 0; i < second.size(); ++i) {
      const Index row = item.row[static_cast<size_t>(i)];
      if (row < n_c) data.condition(row) -= second(i);
    }
  }
  solve_conditions(data, data.condition);
  data.x_ddot_0.setZero();
  data.x_ddot_0.head(n_c) = data.condition;
  data.x_ddot_0.tail(n_r) = q_r_ddot;
}

Eigen::MatrixXd prescribed_transfer_functions(const Model& model, const Data& data,
                                              const Eigen::MatrixXd& patterns) {
  Eigen::MatrixXd DF_r = Eigen::MatrixXd::Zero(model.n_x, patterns.cols());
  if (model.n_c > 0 && patterns.size() > 0) {
    DF_r.topRows(model.n_c) = data.J.solve(-data.D.topRightCorner(model.n_c, model.n_r) * patterns);
  }
  DF_r.bottomRows(model.n_r) = patterns;
  return DF_r;
}

Eigen::MatrixXd stress_hessian(const Model& model, const Data& data, const Eigen::VectorXd& sigma) {
  // Every moving coordinate's unit rate, gathered as an element sees it, would be simple and slow;
  // instead the local matrix is turned by the same scatter, once for its columns and once for its
  // rows.
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(model.n_x, model.n_x);
  LocalVector u;
  for (const ModelElement& item : model.elements) {
    const Index n_local = item.element->n_local(), n_e = item.element->n_deformations();
    gather(item, data.x, u);
    LocalDeformation local_sigma(n_e);
    for (Index i = 0; i < n_e; ++i) local_sigma(i) = sigma(item.row[static_cast<size_t>(i)]);
    if (local_sigma.isZero(0)) continue;
    LocalHessian local(n_local, n_local);
    item.element->hessian(u, local_sigma, local);
    Eigen::MatrixXd turn = Eigen::MatrixXd::Zero(n_local, model.n_x);
    Index at = 0;
    for (size_t p = 0; p < item.parts.size(); ++p) {
      const PartMap& map = item.parts[p];
      const Index size = item.element->parts()[p].size();
      for (Index i = 0; i < size; ++i) {
        const Index column = map.column[static_cast<size_t>(i)];
        if (column < 0) continue;
        if (size == 3) {
          turn.block<3, 1>(at, column) = map.basis.col(i);
        } else {
          turn(at + i, column) = 1.0;
        }
      }
      at += size;
    }
    H.noalias() += turn.transpose() * local * turn;
  }
  return H;
}

}  // namespace stillframe

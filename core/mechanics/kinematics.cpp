#include "core/mechanics/kinematics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/mechanics/node_moves.hpp"
#include "core/numerics/infinity.hpp"

namespace stillframe {

namespace {

void assemble_deformations(const Model& model, Data& data) noexcept {
  LocalVector u;
  LocalDeformation e;
  for (const ModelElement& item : model.elements) {
    gather(item.parts, data.x, u);
    e.resize(item.element->n_deformations());
    item.element->deformations(u, e);
    // The nodes of a hinge are where they were after every period; its angle goes on from the last.
    // That of a condition is known to be what it has to be (condition_residual).
    const double period = item.element->period();
    if (period > 0 && item.row[0] >= model.n_c) {
      e(0) += period * std::round((data.e(item.row[0]) - e(0)) / period);
    }
    for (Index i = 0; i < e.size(); ++i) data.e(item.row[static_cast<size_t>(i)]) = e(i);
  }
}

void assemble_jacobian(const Model& model, Data& data) noexcept {
  LocalVector u;
  const bool square = data.J.size() == model.n_c;  // not so while a partition is being sought
  data.J.clear();
  for (size_t k = 0; k < model.elements.size(); ++k) {
    const ModelElement& item = model.elements[k];
    Eigen::MatrixXd& D = data.D[k];
    gather(item.parts, data.x, u);
    item.element->jacobian(u, D);
    columns_to_node_axes(item.parts, D);
    if (!square) continue;
    // J is empty where the conditions are not as many as the dependent coordinates.
    for_each_column(item.parts, data.J.size(), [&](Index j, Index column) {
      for (Index i = 0; i < D.rows(); ++i) {
        const Index row = item.row[static_cast<size_t>(i)];
        if (row < data.J.size()) data.J.add(row, column, D(i, j));
      }
    });
  }
}

/// Residual of the conditions, e - e_prescribed, in data.condition.
void condition_residual(const Model& model, Data& data, const MotionState& state) noexcept {
  assemble_deformations(model, data);
  data.condition = data.e.head(model.n_c);
  for (Index i = 0; i < model.n_d; ++i) {
    const Model::Dof& dof = model.dofs[static_cast<size_t>(i)];
    if (dof.is_deformation) data.condition(dof.index) -= state.q_d(i);
  }
  for (size_t i = 0; i < model.prescribed_rows.size(); ++i) {
    data.condition(model.prescribed_rows[i]) -= state.q_r(model.n_rx + static_cast<Index>(i));
  }
  // A hinge is at the same place after a whole number of its periods. The remainder of the wanted
  // angle alone is exact; that of a difference would have lost digits after many revolutions.
  for (const ModelElement& item : model.elements) {
    const double period = item.element->period();
    if (period == 0 || item.row[0] >= model.n_c) continue;
    const auto [dof, prescribed] = model.conditions[static_cast<size_t>(item.row[0])];
    const double wanted = dof >= 0          ? state.q_d(dof)
                          : prescribed >= 0 ? state.q_r(model.n_rx + prescribed)
                                            : 0.0;
    data.condition(item.row[0]) =
        std::remainder(data.e(item.row[0]) - std::remainder(wanted, period), period);
  }
}

void factorise(const Model& model, Data& data) noexcept {
  assemble_jacobian(model, data);
  data.J.factorise();
}

/// out(row) = D x on the redundant rows.
void redundant_rates(const Model& model, const Data& data, const Eigen::VectorXd& x,
                     Eigen::VectorXd& out) noexcept {
  LocalVector local;
  for (size_t k = 0; k < model.elements.size(); ++k) {
    const ModelElement& item = model.elements[k];
    const Eigen::MatrixXd& D = data.D[k];
    bool gathered = false;
    for (Index i = 0; i < D.rows(); ++i) {
      const Index row = item.row[static_cast<size_t>(i)];
      if (row < model.n_c) continue;
      if (!gathered) gather_in_node_axes(item.parts, x, local);
      gathered = true;
      out(row) = D.row(i).dot(local);
    }
  }
}

/// data.condition -= D_r q_r, on the rows of the conditions.
void subtract_prescribed(const Model& model, Data& data, const Eigen::VectorXd& q_r) noexcept {
  const Index first = model.n_x - model.n_rx;
  for (size_t k = 0; k < model.elements.size(); ++k) {
    const ModelElement& item = model.elements[k];
    const Eigen::MatrixXd& D = data.D[k];
    for_each_column(item.parts, model.n_x, [&](Index j, Index column) {
      if (column < first) return;
      for (Index i = 0; i < D.rows(); ++i) {
        const Index row = item.row[static_cast<size_t>(i)];
        if (row < model.n_c) data.condition(row) -= D(i, j) * q_r(column - first);
      }
    });
  }
  for (size_t i = 0; i < model.prescribed_rows.size(); ++i) {
    data.condition(model.prescribed_rows[i]) += q_r(model.n_rx + static_cast<Index>(i));
  }
}

}  // namespace

MotionState::MotionState(const Model& model)
    : q_d(Eigen::VectorXd::Zero(model.n_d)),
      q_d_dot(Eigen::VectorXd::Zero(model.n_d)),
      q_r(Eigen::VectorXd::Zero(model.n_r)),
      q_r_dot(Eigen::VectorXd::Zero(model.n_r)),
      q_r_ddot(Eigen::VectorXd::Zero(model.n_r)) {}

namespace {

Index largest_inertia(const Model& model) {
  Index n = 0;
  for (const ModelInertia& item : model.inertias) n = std::max(n, item.inertia->n_local());
  return n;
}

}  // namespace

Data::Data(const Model& model)
    : x(Eigen::VectorXd::Zero(model.n_x)),
      e(Eigen::VectorXd::Zero(model.n_e)),
      J(model.n_c == model.n_e - model.n_redundant ? model.n_c : 0, model.n_d),
      DF(RowMatrix::Zero(model.n_x, model.n_d)),
      DF_e(RowMatrix::Zero(model.n_redundant, model.n_d)),
      x_dot(Eigen::VectorXd::Zero(model.n_x)),
      e_dot(Eigen::VectorXd::Zero(model.n_e)),
      x_ddot_0(Eigen::VectorXd::Zero(model.n_x)),
      M_dd(Eigen::MatrixXd::Zero(model.n_d, model.n_d)),
      M_factor(Eigen::MatrixXd::Zero(model.n_d, model.n_d)),
      sigma(Eigen::VectorXd::Zero(model.n_e)),
      f(Eigen::VectorXd::Zero(model.n_x)),
      f_dd(Eigen::VectorXd::Zero(model.n_d)),
      x_ddot(Eigen::VectorXd::Zero(model.n_x)),
      sigma_balanced(Eigen::VectorXd::Zero(model.n_e)),
      damper_rates(Eigen::VectorXd::Zero(model.modal_dampers.cols())),
      condition(Eigen::VectorXd::Zero(model.n_c)),
      conditions(RowMatrix::Zero(model.n_c, model.n_d)),
      local_rows(RowMatrix::Zero(largest_inertia(model), model.n_d)) {
  for (const ModelElement& item : model.elements) {
    D.push_back(Eigen::MatrixXd::Zero(item.element->n_deformations(), item.element->n_local()));
  }
  if (J.size() == model.n_c) factorise(model, *this);
}

void assemble(const Model& model, Data& data) noexcept {
  assemble_deformations(model, data);
  assemble_jacobian(model, data);
}

bool solve_positions(const Model& model, Data& data, const MotionState& state) noexcept {
  for (Index i = 0; i < model.n_d; ++i) {
    const Model::Dof& dof = model.dofs[static_cast<size_t>(i)];
    if (!dof.is_deformation) data.x(dof.index) = state.q_d(i);
  }
  data.x.tail(model.n_rx) = state.q_r.head(model.n_rx);
  if (model.n_c == 0) {
    assemble_deformations(model, data);
    return true;
  }
  constexpr double epsilon = std::numeric_limits<double>::epsilon();
  constexpr double close =
      1e-8;  // of the displacements: factors from there contract as new ones do
  double last_step = infinity;
  double moved = infinity;  // since J was factorised, which the caller may have done anywhere
  bool last_was_near = false;
  for (int iteration = 0; iteration < 50; ++iteration) {
    condition_residual(model, data, state);
    data.J.solve(data.condition);
    data.x.head(model.n_c) -= data.condition;
    const double step = data.condition.lpNorm<Eigen::Infinity>();
    const double size = data.x.lpNorm<Eigen::Infinity>();
    if (!std::isfinite(step)) return false;
    // Displacements carry a relative rounding of a few epsilon; below that a step is noise. On the
    // way to displacements that are exactly zero the size shrinks with the step, so that 1e-30 (m,
    // rad), far below all motion that counts, ends it.
    if (step <= 8 * epsilon * size || step < 1e-30) return true;
    const bool near = moved <= close * size;
    moved += step;
    if (step > 0.25 * last_step) {
      // With factors of this place only the rounding of a badly conditioned J stops Newton's method
      // so close. Both steps have to be such: the first one with them may have to undo what the
      // last ones with old factors did, and e is that of before it.
      if (near && last_was_near && step <= close * size) return true;
      if (moved > close * size) {
        factorise(model, data);
        moved = 0;
      }
    }
    last_step = step;
    last_was_near = near;
  }
  return false;
}

void geometric_transfer_functions(const Model& model, Data& data) noexcept {
  factorise(model, data);
  data.DF.setZero();
  data.conditions.setZero();
  for (Index i = 0; i < model.n_d; ++i) {
    const Model::Dof& dof = model.dofs[static_cast<size_t>(i)];
    (dof.is_deformation ? data.conditions : data.DF)(dof.index, i) = 1.0;
  }
  const Index n_c = model.n_c, last = model.n_c + model.n_xd;
  if (model.n_xd > 0) {
    for (size_t k = 0; k < model.elements.size(); ++k) {
      const ModelElement& item = model.elements[k];
      const Eigen::MatrixXd& D = data.D[k];
      for_each_column(item.parts, last, [&](Index j, Index column) {
        if (column < n_c) return;
        const Index dof = model.dof_of_column[static_cast<size_t>(column - n_c)];
        for (Index i = 0; i < D.rows(); ++i) {
          const Index row = item.row[static_cast<size_t>(i)];
          if (row < n_c) data.conditions(row, dof) -= D(i, j);
        }
      });
    }
  }
  data.J.solve(data.conditions);
  data.DF.topRows(n_c) = data.conditions;
  data.DF_e.setZero();
  for (size_t k = 0; k < model.elements.size() && model.n_redundant > 0; ++k) {
    const ModelElement& item = model.elements[k];
    const Eigen::MatrixXd& D = data.D[k];
    for_each_column(item.parts, model.n_x, [&](Index j, Index column) {
      for (Index i = 0; i < D.rows(); ++i) {
        const Index row = item.row[static_cast<size_t>(i)];
        if (row >= n_c) data.DF_e.row(row - n_c) += D(i, j) * data.DF.row(column);
      }
    });
  }
}

void velocities(const Model& model, Data& data, const MotionState& state) noexcept {
  const Index n_c = model.n_c, n_rx = model.n_rx;
  data.condition.setZero();
  subtract_prescribed(model, data, state.q_r_dot);
  data.J.solve(data.condition);
  data.x_dot.noalias() = data.DF * state.q_d_dot;
  data.x_dot.head(n_c) += data.condition;
  data.x_dot.tail(n_rx) = state.q_r_dot.head(n_rx);
  data.e_dot.head(n_c).setZero();
  for (Index i = 0; i < model.n_d; ++i) {
    const Model::Dof& dof = model.dofs[static_cast<size_t>(i)];
    if (dof.is_deformation) data.e_dot(dof.index) = state.q_d_dot(i);
  }
  for (size_t i = 0; i < model.prescribed_rows.size(); ++i) {
    data.e_dot(model.prescribed_rows[i]) = state.q_r_dot(n_rx + static_cast<Index>(i));
  }
  redundant_rates(model, data, data.x_dot, data.e_dot);

  // J x_ddot_0 = -D2(x_dot, x_dot) - D_r q_r_ddot: the conditions differentiated twice with
  // q_d_ddot = 0.
  data.condition.setZero();
  subtract_prescribed(model, data, state.q_r_ddot);
  LocalVector u, rate;
  LocalDeformation second;
  for (const ModelElement& item : model.elements) {
    gather(item.parts, data.x, u);
    gather(item.parts, data.x_dot, rate);
    second.resize(item.element->n_deformations());
    item.element->second_derivative(u, rate, rate, second);
    for (Index i = 0; i < second.size(); ++i) {
      const Index row = item.row[static_cast<size_t>(i)];
      if (row < n_c) data.condition(row) -= second(i);
    }
  }
  data.J.solve(data.condition);
  data.x_ddot_0.setZero();
  data.x_ddot_0.head(n_c) = data.condition;
  data.x_ddot_0.tail(n_rx) = state.q_r_ddot.head(n_rx);
}

namespace {

/// D_q F (q_to - q_from) at the present x.
Eigen::VectorXd expected_displacement(const Model& model, Data& data, const MotionState& from,
                                      const MotionState& to) {
  geometric_transfer_functions(model, data);
  Eigen::VectorXd displacement = data.DF * (to.q_d - from.q_d);
  if (model.n_r > 0) {
    displacement += prescribed_transfer_functions(model, data, to.q_r - from.q_r);
  }
  return displacement;
}

}  // namespace

bool travel(const Model& model, Data& data, const MotionState& from, const MotionState& to) {
  const Eigen::VectorXd start = data.x;
  constexpr double largest_step = 0.3;  // rad
  MotionState at = from;
  double travelled = 0, limit = 1;
  while (travelled < 1) {
    const Eigen::VectorXd x = data.x;
    const Eigen::VectorXd ahead = expected_displacement(model, data, at, to);
    const double turn = largest_turn(model, ahead);
    const double share = std::min({1.0, limit, turn > 0 ? largest_step / turn : 1.0});
    const double left = 1 - travelled;
    MotionState next = to;
    if (share < 1) {
      next.q_d = at.q_d + share * (to.q_d - at.q_d);
      next.q_r = at.q_r + share * (to.q_r - at.q_r);
    }
    data.x += share * ahead;
    // Where the position curves so much that twice the expected step is made, a smaller step shows
    // whether that is the way or another branch.
    const bool reached = solve_positions(model, data, next) && data.x.allFinite() &&
                         largest_turn(model, data.x - x) <= 2 * largest_step;
    if (reached) {
      at = next;
      travelled = share < 1 ? travelled + share * left : 1;
      limit = std::min(1.0, 2 * limit);
    } else {
      data.x = x;
      limit = 0.5 * share;
      if (limit < 1e-4) {
        data.x = start;
        return false;
      }
    }
  }
  return true;
}

RowMatrix prescribed_transfer_functions(const Model& model, Data& data,
                                        const Eigen::MatrixXd& patterns) {
  RowMatrix DF_r = RowMatrix::Zero(model.n_x, patterns.cols());
  for (Index j = 0; j < patterns.cols(); ++j) {
    data.condition.setZero();
    subtract_prescribed(model, data, patterns.col(j));
    data.J.solve(data.condition);
    DF_r.col(j).head(model.n_c) = data.condition;
  }
  DF_r.bottomRows(model.n_rx) = patterns.topRows(model.n_rx);
  return DF_r;
}

Eigen::MatrixXd dense_jacobian(const Model& model, const Data& data) {
  Eigen::MatrixXd D = Eigen::MatrixXd::Zero(model.n_e, model.n_x);
  for (size_t k = 0; k < model.elements.size(); ++k) {
    const ModelElement& item = model.elements[k];
    for_each_column(item.parts, model.n_x, [&](Index j, Index column) {
      for (Index i = 0; i < data.D[k].rows(); ++i) {
        D(item.row[static_cast<size_t>(i)], column) += data.D[k](i, j);
      }
    });
  }
  return D;
}

Eigen::MatrixXd dense_jacobian(const Model& model) {
  Data data(model);
  assemble(model, data);
  return dense_jacobian(model, data);
}

}  // namespace stillframe

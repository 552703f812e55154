#include "core/mechanics/state_space.hpp"

#include <Eigen/Eigenvalues>
#include <limits>
#include <stdexcept>

#include "core/errors/input_error.hpp"

namespace stillframe {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// The dof with the largest part in the motion that has the least mass, M scaled to a unit diagonal
/// so that metres and radians compare.
std::string massless_dof(const LinearModel& model) {
  const VectorXd scale = model.M.diagonal().unaryExpr(
      [](double mass) { return mass > 0 ? 1 / std::sqrt(mass) : 1.0; });
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(scale.asDiagonal() * model.M *
                                                       scale.asDiagonal());
  Index largest = 0;
  solver.eigenvectors().col(0).cwiseAbs().maxCoeff(&largest);
  return model.q_names[static_cast<size_t>(largest)];
}

}  // namespace

Eigen::LLT<MatrixXd> mass_factors(const LinearModel& model) {
  Eigen::LLT<MatrixXd> factors(model.M);
  // Rounding leaves a pivot of some n epsilon of the diagonal where there is no mass at all.
  const double least =
      10 * static_cast<double>(model.M.rows()) * std::numeric_limits<double>::epsilon();
  const bool positive =
      factors.info() == Eigen::Success &&
      (factors.matrixLLT().diagonal().array().square() > least * model.M.diagonal().array()).all();
  if (!positive) {
    throw Massless(
        "the mass matrix is not positive definite: dof " + massless_dof(model) +
        " moves no mass; give a node that it moves a mass or an inertia, or hold it; the "
        "nodes within a divided beam turn about its axis with inertia_per_length alone");
  }
  return factors;
}

namespace {

/// Numbers that are each within their range may lead beyond all numbers together. A row each of
/// what `name_of` names.
template <class NameOf>
void require_finite(const MatrixXd& rows, const NameOf& name_of) {
  for (Index i = 0; i < rows.rows(); ++i) {
    if (rows.row(i).allFinite()) continue;
    throw Refusal("numbers of the model overflow: " + name_of(static_cast<size_t>(i)) +
                  " is not finite; look for a length, stiffness, mass or damping with a wrong "
                  "power of ten");
  }
}

void require_finite_accelerations(const MatrixXd& rows, const LinearModel& model) {
  require_finite(rows, [&](size_t i) { return "the acceleration of dof " + model.q_names[i]; });
}

/// Rows of the outputs from `first` on.
void require_finite_outputs(const MatrixXd& rows, const LinearModel& model, size_t first = 0) {
  require_finite(rows, [&](size_t i) { return "output '" + model.outputs[first + i].name + "'"; });
}

MatrixXd state_matrix(const LinearModel& model, const Eigen::LLT<MatrixXd>& M) {
  const Index n = model.M.rows();
  MatrixXd A = MatrixXd::Zero(2 * n, 2 * n);
  A.topRightCorner(n, n).setIdentity();
  A.bottomLeftCorner(n, n) = -M.solve(model.stiffness());
  A.bottomRightCorner(n, n) = -M.solve(model.damping());
  require_finite_accelerations(A.bottomRows(n), model);
  return A;
}

}  // namespace

MatrixXd state_matrix(const LinearModel& model) { return state_matrix(model, mass_factors(model)); }

InputColumns::Kind input_kind(Quantity quantity) {
  using Kind = InputColumns::Kind;
  constexpr Kind of_motion[] = {Kind::position, Kind::velocity, Kind::acceleration};
  return is_motion(quantity) ? of_motion[traits_of(quantity).derivative] : Kind::direct;
}

namespace {

/// Names, and which columns belong to which input; answers the number of columns.
Index name_signals(const LinearModel& model, StateSpace& system) {
  Index next = 0;
  for (const SignalInfo& input : model.inputs) {
    system.inputs.push_back({input.name, input.unit});
    system.columns.push_back({input_kind(input.quantity), next});
    next += system.columns.back().width();
  }
  for (const SignalInfo& output : model.outputs)
    system.outputs.push_back({output.name, output.unit});
  for (size_t i = 0; i < model.q_names.size(); ++i) {
    system.states.push_back({model.q_names[i], model.q_units[i]});
  }
  for (size_t i = 0; i < model.q_names.size(); ++i) {
    system.states.push_back({"d/dt " + model.q_names[i], model.q_units[i] + "/s"});
  }
  return next;
}

}  // namespace

StateSpace state_space(const LinearModel& model) {
  const Index n = model.M.rows();
  const Eigen::LLT<MatrixXd> M = mass_factors(model);
  StateSpace system;
  const Index n_columns = name_signals(model, system);
  MatrixXd forces(n, n_columns);
  system.D.resize(model.Y_p.rows(), n_columns);
  for (size_t j = 0; j < system.columns.size(); ++j) {
    const Index from = static_cast<Index>(j), to = system.columns[j].first;
    if (system.columns[j].kind == InputColumns::Kind::direct) {
      forces.col(to) = model.B.col(from);
      system.D.col(to) = model.D_u.col(from);
      continue;
    }
    forces.col(to) = -model.M_r.col(from);
    forces.col(to + 1) = -(model.C_r.col(from) + model.D_r.col(from));
    forces.col(to + 2) = -(model.K_r.col(from) + model.N_r.col(from) + model.G_r.col(from));
    system.D.col(to) = model.R_a.col(from);
    system.D.col(to + 1) = model.R_v.col(from);
    system.D.col(to + 2) = model.R_p.col(from);
  }
  const MatrixXd B_2 = M.solve(forces);
  require_finite_accelerations(B_2, model);
  system.A = state_matrix(model, M);
  system.B = MatrixXd::Zero(2 * n, n_columns);
  system.B.bottomRows(n) = B_2;
  system.C.resize(model.Y_p.rows(), 2 * n);
  system.C << model.Y_p, model.Y_v;
  system.C += model.Y_a * system.A.bottomRows(n);
  system.D += model.Y_a * B_2;
  require_finite_outputs(system.C, model);
  require_finite_outputs(system.D, model);
  system.x0.resize(2 * n);
  system.x0 << model.q_0, model.q_dot_0;
  system.u0 = model.u_0;
  system.y0 = model.y_0;
  return system;
}

namespace {

void check_signals(const LinearModel& model, Index n_w, Index n_y) {
  for (size_t j = 0; j < model.inputs.size(); ++j) {
    const bool disturbance = static_cast<Index>(j) < n_w;
    const Quantity is = model.inputs[j].quantity;
    const bool fits = disturbance ? is == Quantity::acceleration || is == Quantity::force
                                  : is == Quantity::stress;
    if (!fits) {
      throw std::invalid_argument("loop_plant: input '" + model.inputs[j].name + "' is neither a " +
                                  "disturbing acceleration or force nor a driving stress in its " +
                                  "place");
    }
  }
  for (size_t i = static_cast<size_t>(n_y); i < model.outputs.size(); ++i) {
    if (model.outputs[i].quantity != Quantity::stress) {
      throw std::invalid_argument("loop_plant: output '" + model.outputs[i].name +
                                  "' is no stress");
    }
  }
}

}  // namespace

LoopPlant loop_plant(const LinearModel& model, Index n_w, Index n_y) {
  check_signals(model, n_w, n_y);
  const Index n = model.M.rows(), m = model.B.cols() - n_w;
  const MatrixXd KG_r = model.stiffness_r().leftCols(n_w), D_r = model.damping_r().leftCols(n_w);
  const MatrixXd R_p = model.R_p.leftCols(n_w), R_v = model.R_v.leftCols(n_w);
  const bool integrals = !KG_r.isZero(0) || !D_r.isZero(0) || !R_p.isZero(0) || !R_v.isZero(0);
  const Index n_exogenous = integrals ? 2 * n_w : 0, total = 2 * n + n_exogenous;
  const Eigen::LLT<MatrixXd> M = mass_factors(model);

  LoopPlant plant;
  plant.n_exogenous = n_exogenous;
  plant.A = MatrixXd::Zero(total, total);
  plant.A.topLeftCorner(2 * n, 2 * n) = state_matrix(model, M);
  plant.B_w = MatrixXd::Zero(total, n_w);
  // Of a force M_r is zero, of a motion B.
  plant.B_w.middleRows(n, n) = M.solve(model.B.leftCols(n_w) - model.M_r.leftCols(n_w));
  plant.B_u = MatrixXd::Zero(total, m);
  plant.B_u.middleRows(n, n) = M.solve(model.B.rightCols(m));
  if (integrals) {  // states (dw/dt integral: velocity, position) after (q, q')
    plant.A.block(n, 2 * n, n, n_w) = -M.solve(D_r);
    plant.A.block(n, 2 * n + n_w, n, n_w) = -M.solve(KG_r);
    plant.A.block(2 * n + n_w, 2 * n, n_w, n_w).setIdentity();
    plant.B_w.middleRows(2 * n, n_w).setIdentity();
  }

  for (const MatrixXd* part : {&plant.A, &plant.B_w, &plant.B_u}) {
    require_finite_accelerations(part->middleRows(n, n), model);
  }

  // y = Y_p q + Y_v q' + Y_a q'' + ..., with q'' the second block of rows of the state equation.
  const auto state_rows = [&](Index first, Index rows) -> MatrixXd {
    MatrixXd C = model.Y_a.middleRows(first, rows) * plant.A.middleRows(n, n);
    C.leftCols(n) += model.Y_p.middleRows(first, rows);
    C.middleCols(n, n) += model.Y_v.middleRows(first, rows);
    if (integrals) {
      C.middleCols(2 * n, n_w) += R_v.middleRows(first, rows);
      C.middleCols(2 * n + n_w, n_w) += R_p.middleRows(first, rows);
    }
    return C;
  };
  plant.C_y = state_rows(0, n_y);
  plant.D_yw = model.Y_a.topRows(n_y) * plant.B_w.middleRows(n, n) +
               model.R_a.topLeftCorner(n_y, n_w) + model.D_u.topLeftCorner(n_y, n_w);
  plant.D_yu =
      model.Y_a.topRows(n_y) * plant.B_u.middleRows(n, n) + model.D_u.topRightCorner(n_y, m);
  plant.C_sigma = state_rows(n_y, model.Y_p.rows() - n_y);
  for (const MatrixXd* part : {&plant.C_y, &plant.D_yw, &plant.D_yu}) {
    require_finite_outputs(*part, model);
  }
  require_finite_outputs(plant.C_sigma, model, static_cast<size_t>(n_y));
  return plant;
}

}  // namespace stillframe

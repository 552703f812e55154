#include "core/state_space.hpp"

#include <Eigen/Cholesky>
#include <stdexcept>

namespace stillframe {

using Eigen::MatrixXd;

MatrixXd state_matrix(const LinearModel& model) {
  const Index n = model.M.rows();
  const Eigen::LLT<MatrixXd> M(model.M);
  MatrixXd A = MatrixXd::Zero(2 * n, 2 * n);
  A.topRightCorner(n, n).setIdentity();
  A.bottomLeftCorner(n, n) = -M.solve(model.stiffness());
  A.bottomRightCorner(n, n) = -M.solve(model.damping());
  return A;
}

namespace {

void check_signals(const LinearModel& model, Index n_w, Index n_y) {
  for (size_t j = 0; j < model.inputs.size(); ++j) {
    const bool disturbance = static_cast<Index>(j) < n_w;
    if (model.inputs[j].quantity != (disturbance ? Quantity::acceleration : Quantity::stress)) {
      throw std::invalid_argument("loop_plant: input '" + model.inputs[j].name + "' is neither " +
                                  "a disturbing acceleration nor a driving stress in its place");
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
  const Eigen::LLT<MatrixXd> M(model.M);

  LoopPlant plant;
  plant.n_exogenous = n_exogenous;
  plant.A = MatrixXd::Zero(total, total);
  plant.A.topLeftCorner(2 * n, 2 * n) = state_matrix(model);
  plant.B_w = MatrixXd::Zero(total, n_w);
  plant.B_w.middleRows(n, n) = -M.solve(model.M_r.leftCols(n_w));
  plant.B_u = MatrixXd::Zero(total, m);
  plant.B_u.middleRows(n, n) = M.solve(model.B.rightCols(m));
  if (integrals) {  // states (dw/dt integral: velocity, position) after (q, q')
    plant.A.block(n, 2 * n, n, n_w) = -M.solve(D_r);
    plant.A.block(n, 2 * n + n_w, n, n_w) = -M.solve(KG_r);
    plant.A.block(2 * n + n_w, 2 * n, n_w, n_w).setIdentity();
    plant.B_w.middleRows(2 * n, n_w).setIdentity();
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
  plant.D_yw =
      model.Y_a.topRows(n_y) * plant.B_w.middleRows(n, n) + model.R_a.topLeftCorner(n_y, n_w);
  plant.D_yu =
      model.Y_a.topRows(n_y) * plant.B_u.middleRows(n, n) + model.D_u.topRightCorner(n_y, m);
  plant.C_sigma = state_rows(n_y, model.Y_p.rows() - n_y);
  return plant;
}

}  // namespace stillframe

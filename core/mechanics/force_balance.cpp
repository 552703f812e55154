#include "core/mechanics/force_balance.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <cmath>

#include "core/mechanics/dynamics.hpp"
#include "core/mechanics/node_moves.hpp"
#include "core/numerics/worst.hpp"

namespace stillframe {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

VectorXd stresses_on_dofs(const Model& model, const Data& data) {
  VectorXd stresses = data.DF_e.transpose() * data.sigma.tail(model.n_redundant);
  for (Index i = 0; i < model.n_d; ++i) {
    const Model::Dof& dof = model.dofs[static_cast<size_t>(i)];
    if (dof.is_deformation) stresses(i) += data.sigma(dof.index);
  }
  return stresses;
}

}  // namespace

double largest_balanced_force(const Model& model, Data& data, const NominalMotion& motion) {
  const double at_rest =
      worst_of(worst_of(stresses_on_dofs(model, data)), worst_of(data.DF.transpose() * data.f));
  if (!motion.moving()) return at_rest;
  complete_accelerations(data, motion.q_d_ddot);
  const double inertia = worst_of(inertia_forces(model, data).head(model.n_x));
  return worst_of(at_rest, inertia * worst_of(data.DF));
}

double largest_work(const Model& model, const Data& data, const VectorXd& forces) {
  double largest = 0;
  for (Index i = 0; i < model.n_d; ++i) {
    const double move = largest_move(model, data.DF.col(i));
    if (move > 0) largest = worst_of(largest, std::abs(forces(i)) / move);
  }
  return largest;
}

double largest_balanced_work(const Model& model, Data& data, const NominalMotion& motion) {
  const double at_rest = worst_of(largest_work(model, data, stresses_on_dofs(model, data)),
                                  largest_work(model, data, data.DF.transpose() * data.f));
  if (!motion.moving()) return at_rest;
  complete_accelerations(data, motion.q_d_ddot);
  return worst_of(at_rest, largest_nodal_work(model, inertia_forces(model, data).head(model.n_x)));
}

double work_of_rounding(const Model& model, const Data& data, const MatrixXd& stiffness) {
  // Positions are known to some epsilon of the displacement, which an ill-conditioned J makes more.
  const double rounding = 1e-12 * largest_move(model, data.x);
  double largest = 0;
  for (Index i = 0; i < stiffness.rows(); ++i) {
    const double move = largest_move(model, data.DF.col(i));
    if (move > 0) largest = worst_of(largest, std::abs(stiffness(i, i)) * rounding / (move * move));
  }
  return largest;
}

VectorXd motion_against(const MatrixXd& stiffness, const VectorXd& force) {
  // On a unit diagonal metres and radians compare.
  const VectorXd scale = stiffness.diagonal().unaryExpr(
      [](double k) { return k != 0 ? 1 / std::sqrt(std::abs(k)) : 1.0; });
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> factors;
  factors.setThreshold(unresisted);
  factors.compute(scale.asDiagonal() * stiffness * scale.asDiagonal());
  return scale.cwiseProduct(factors.solve(scale.cwiseProduct(force)));
}

Index n_negative(const MatrixXd& stiffness) {
  // On a unit diagonal stiff elements do not hide a soft direction that has become negative.
  MatrixXd K = 0.5 * (stiffness + stiffness.transpose());
  const VectorXd scale =
      K.diagonal().unaryExpr([](double k) { return k > 0 ? 1 / std::sqrt(k) : 1.0; });
  K = scale.asDiagonal() * K * scale.asDiagonal();
  if (Eigen::LLT<MatrixXd>(K).info() == Eigen::Success) return 0;
  const VectorXd values =
      Eigen::SelfAdjointEigenSolver<MatrixXd>(K, Eigen::EigenvaluesOnly).eigenvalues();
  return (values.array() < -unresisted * values.cwiseAbs().maxCoeff()).count();
}

std::string unresisted_dof(const Model& model, const MatrixXd& stiffness) {
  const VectorXd scale = stiffness.diagonal().unaryExpr(
      [](double k) { return k != 0 ? 1 / std::sqrt(std::abs(k)) : 1.0; });
  const MatrixXd K = scale.asDiagonal() * stiffness * scale.asDiagonal();
  if (!K.allFinite()) return "";
  const Eigen::BDCSVD<MatrixXd> svd(K, Eigen::ComputeFullV);
  if (svd.singularValues()(model.n_d - 1) > unresisted) return "";
  Index largest = 0;
  svd.matrixV().col(model.n_d - 1).cwiseAbs().maxCoeff(&largest);
  return model.dofs[static_cast<size_t>(largest)].name;
}

bool out_of_balance(const Model& model, Data& data, const NominalMotion& motion, VectorXd& f) {
  if (!generalised_forces(model, data, motion.state, VectorXd::Zero(model.n_e))) return false;
  f = data.f_dd;
  if (!motion.q_d_ddot.isZero(0)) {
    mass_matrix(model, data);
    f -= data.M_dd * motion.q_d_ddot;
  }
  return f.allFinite();
}

}  // namespace stillframe

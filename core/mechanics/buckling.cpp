#include "core/mechanics/buckling.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "core/errors/input_error.hpp"
#include "core/mechanics/dynamics.hpp"
#include "core/mechanics/equilibrium.hpp"
#include "core/mechanics/force_balance.hpp"
#include "core/mechanics/linearisation/projection.hpp"
#include "core/mechanics/unsymmetric_load.hpp"

namespace stillframe {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Stress resultants to first order in the load: S D_e q for the elastic deformations, those of the
/// others from the equations of reaction.
void first_order_stresses(const Model& model, Data& data, const Columns& columns,
                          const VectorXd& q) {
  RowMatrix E;
  for (size_t k = 0; k < model.elements.size(); ++k) {
    const ModelElement& item = model.elements[k];
    if (item.S.size() == 0) continue;
    deformation_columns(model, data, columns, k, E);
    const VectorXd sigma = item.S * (E * q);
    for (Index i = 0; i < sigma.size(); ++i) {
      data.sigma(item.row[static_cast<size_t>(i)]) += sigma(i);
    }
  }
  reaction_stresses(model, data);
}

}  // namespace

void refuse_without_load() {
  throw Refusal("there is no load to multiply: add loads, gravity or preloads");
}

void refuse_free_to_move(const std::string& coordinate) {
  throw Refusal("the stiffness matrix of the unloaded scene is not positive definite: " +
                (coordinate.empty() ? "it can move without strain, or has dofs that nothing resists"
                                    : "nothing resists a motion of " + coordinate));
}

void scale_to_largest(MatrixXd& shapes) {
  for (auto shape : shapes.colwise()) {
    Index largest = 0;
    shape.cwiseAbs().maxCoeff(&largest);
    shape /= shape(largest);
  }
}

Buckling buckling(const Model& model) {
  if (!model.q_r_dot_0.isZero(0) || !model.q_r_ddot_0.isZero(0)) {
    throw Refusal(
        "a prescribed motion has a rate or an acceleration, whose inertia forces are no load that "
        "a "
        "multiplier multiplies; take it out for buckling, or follow the modes under growing load");
  }
  const NominalMotion rest = unloaded_position(model);
  Lineariser unloaded(model, {}, {}, {.mass = false, .damping = false});
  // The prescribed values may strain the unloaded scene: that part of G does not grow with the
  // load.
  const LinearModel& at_rest = unloaded.about(rest, 0);
  const MatrixXd K = at_rest.K + 0.5 * (at_rest.G + at_rest.G.transpose());
  Data data(model);
  rest.place(data);
  generalised_forces(model, data, rest.state, VectorXd::Zero(model.n_e));
  complete_accelerations(data, rest.q_d_ddot);
  if (data.f_dd.isZero(0) && data.f.isZero(0) && model.preload.isZero(0)) {
    refuse_without_load();
  }
  const Eigen::LLT<MatrixXd> factors(K);
  if (factors.info() != Eigen::Success) refuse_free_to_move(unresisted_dof(model, K));
  Columns columns(model, MatrixXd::Zero(model.n_r, 0), {});
  columns.compute(model, data, false);
  first_order_stresses(model, data, columns, factors.solve(data.f_dd));
  const MatrixXd G = geometric_stiffness(model, data, columns) - at_rest.G;
  // Rounding of the projections leaves 1e-13; a load that turns, parts of the
  // order of G itself.
  if ((G - G.transpose()).norm() > 1e-9 * G.norm()) {
    throw Refusal(
        "the geometric stiffness is not symmetric, as " + unsymmetric_load(model) +
        ": such a load has no buckling multiplier; follow the modes under growing load instead");
  }
  // G v = mu K v with mu = -1 / lambda: the smallest multipliers are the best determined numbers.
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> solver(0.5 * (G + G.transpose()), K);
  const VectorXd& mu = solver.eigenvalues();  // ascending
  const double threshold = -1e-13 * mu.cwiseAbs().maxCoeff();
  Index count = 0;
  while (count < mu.size() && mu(count) < threshold) ++count;
  Buckling result;
  for (const Model::Dof& dof : model.dofs) result.q_names.push_back(dof.name);
  result.load_multipliers = -mu.head(count).cwiseInverse();
  result.shapes = solver.eigenvectors().leftCols(count);
  scale_to_largest(result.shapes);
  return result;
}

}  // namespace stillframe

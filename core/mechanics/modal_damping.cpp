#include "core/mechanics/modal_damping.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/errors/formatted.hpp"
#include "core/errors/input_error.hpp"
#include "core/mechanics/modes.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/numerics/two_pi.hpp"

namespace stillframe {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// By how much dampers on deformations may be stronger than ones on the mode itself, of which
/// deformations are a part: beyond, they are made of what strains are rounded by.
constexpr double most_leverage = 1e6;

/// DF^(e) of all deformations (n_e x n_d) at the operating point.
MatrixXd deformations_of_dofs(const Model& model, const NominalMotion& nominal) {
  Data data(model);
  nominal.place(data);
  geometric_transfer_functions(model, data);
  MatrixXd E = MatrixXd::Zero(model.n_e, model.n_d);
  E.bottomRows(model.n_redundant) = data.DF_e;
  for (Index i = 0; i < model.n_d; ++i) {
    const Model::Dof& dof = model.dofs[static_cast<size_t>(i)];
    if (dof.is_deformation) E(dof.index, i) = 1;
  }
  return E;
}

/// S E of what has a constitutive law.
MatrixXd stresses_of(const Model& model, const MatrixXd& E) {
  MatrixXd stresses = MatrixXd::Zero(E.rows(), E.cols());
  for (const ModelElement& item : model.elements) {
    for (Index i = 0; i < item.S.rows(); ++i) {
      const Index row = item.row[static_cast<size_t>(i)];
      if (!model.is_elastic(row)) continue;
      for (Index j = 0; j < item.S.cols(); ++j) {
        stresses.row(row) += item.S(i, j) * E.row(item.row[static_cast<size_t>(j)]);
      }
    }
  }
  return stresses;
}

NaturalShapes shapes_at(const Model& model, const NominalMotion& nominal,
                        const std::string& place) {
  try {
    return natural_shapes(linearise(model, nominal, {}, {}));
  } catch (const Refusal& refusal) {
    throw Refusal(place + ": it is of natural modes: " + refusal.what());
  }
}

}  // namespace

void add_modal_damping(const Scene& scene, Model& model) {
  const SceneModalDamping& damping = scene.modal_damping.value();
  const NominalMotion nominal = nominal_motion(model);
  const NaturalShapes natural = shapes_at(model, nominal, damping.place);
  // A motion that nothing holds, or that is pushed away, has no ratio; what damps the others must
  // leave the second alone.
  const Index n = natural.squares.size();
  VectorXd scale = VectorXd::Zero(n), roots = VectorXd::Zero(n);
  for (Index i = 0; i < n; ++i) {
    const double omega = std::sqrt(std::abs(natural.squares(i)));
    if (omega <= natural.known_to(i)) continue;
    scale(i) = 1 / omega;
    if (natural.squares(i) < 0) continue;
    roots(i) = std::sqrt(2 * damping.ratio_at(omega / two_pi) / omega);
  }
  // On modes of unit stiffness, A is what of it is deformations', the rest being weight's and
  // loads'; what has no part in it has no inverse.
  const MatrixXd E = deformations_of_dofs(model, nominal) * (natural.V * scale.asDiagonal()),
                 S_E = stresses_of(model, E);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> elastic(E.transpose() * S_E);
  const double rounding = 1e-13 * static_cast<double>(n) * elastic.eigenvalues().maxCoeff();
  const VectorXd inverse_parts = elastic.eigenvalues().unaryExpr(
      [rounding](double part) { return part > rounding ? 1 / part : 0; });
  const MatrixXd& axes = elastic.eigenvectors();
  const MatrixXd inverse = axes * inverse_parts.asDiagonal() * axes.transpose();
  for (Index i = 0; i < n; ++i) {
    if (roots(i) == 0) continue;
    const VectorXd reached =
        axes * (inverse_parts.array() > 0).select(axes.row(i).transpose().array(), 0).matrix();
    const bool deforms = (reached - VectorXd::Unit(n, i)).norm() <= 1e-6;
    if (deforms && inverse(i, i) <= most_leverage) continue;
    throw Refusal(damping.place +
                  formatted(": mode %d, of %.4g Hz, is held by weight or loads and not by "
                            "deformations, which is what is damped; allowed are pairs [Hz, ratio], "
                            "with a ratio of 0 there",
                            static_cast<int>(i) + 1, 1 / (two_pi * scale(i))));
  }
  model.modal_dampers = S_E * inverse * roots.asDiagonal();
}

}  // namespace stillframe

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

/// What of a mode's stiffness deformations must have for a damper on them to be one of the mode: on
/// a thousandth it would be a thousand times as stiff as what it damps.
constexpr double least_elastic = 1e-3;

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

/// S E of all elements, without what is held zero.
MatrixXd stresses_of(const Model& model, const MatrixXd& E) {
  MatrixXd stresses = MatrixXd::Zero(E.rows(), E.cols());
  for (const ModelElement& item : model.elements) {
    for (Index i = 0; i < item.S.rows(); ++i) {
      const auto row = static_cast<size_t>(i);
      if (item.zero[row]) continue;
      for (Index j = 0; j < item.S.cols(); ++j) {
        const auto column = static_cast<size_t>(j);
        if (!item.zero[column])
          stresses.row(item.row[row]) += item.S(i, j) * E.row(item.row[column]);
      }
    }
  }
  return stresses;
}

Modes natural_modes(const Model& model, const NominalMotion& nominal, const std::string& place) {
  try {
    LinearModel linear = linearise(model, nominal, {}, {});
    linear.C.setZero();
    linear.D.setZero();
    Modes natural = modes(linear);
    if (natural.shapes.size() > 0) return natural;
  } catch (const Refusal& refusal) {
    throw Refusal(place + ": it is of natural modes: " + refusal.what());
  }
  throw Refusal(place +
                ": the operating point of this scene has no natural modes: its stiffness "
                "is not symmetric; give elements dampers instead");
}

}  // namespace

void add_modal_damping(const Scene& scene, Model& model) {
  const std::vector<double>& ratios = scene.modal_damping->ratios;
  const std::string place = scene.modal_damping->place + ": modal_damping";
  const NominalMotion nominal = nominal_motion(model);
  const Modes natural = natural_modes(model, nominal, place);
  // A motion that nothing holds is in no time damped, whatever its ratio.
  VectorXd omega = two_pi * natural.natural_frequencies_hz, wanted = VectorXd::Zero(omega.size());
  VectorXd scale = VectorXd::Zero(omega.size());
  for (Index i = 0; i < omega.size(); ++i) {
    if (omega(i) <= natural.known_to(2 * i)) continue;
    scale(i) = 1 / omega(i);
    wanted(i) = 2 * ratios[std::min(static_cast<size_t>(i), ratios.size() - 1)];
  }
  const MatrixXd shapes = natural.shapes * scale.asDiagonal(),
                 E = deformations_of_dofs(model, nominal) * shapes, S_E = stresses_of(model, E);
  // On modes of unit stiffness: what of it is deformation's, the rest being weight's and loads'.
  const Eigen::SelfAdjointEigenSolver<MatrixXd> elastic(E.transpose() * S_E);
  const VectorXd parts = elastic.eigenvalues().unaryExpr(
      [](double part) { return part > least_elastic ? 1 / part : 0; });
  const MatrixXd inverse =
      elastic.eigenvectors() * parts.asDiagonal() * elastic.eigenvectors().transpose();
  // V^T D V / Omega^2 is to be 2 zeta / Omega.
  const VectorXd roots = wanted.cwiseProduct(scale).cwiseSqrt();
  model.modal_dampers = S_E * inverse * roots.asDiagonal();
  const MatrixXd found = E.transpose() * model.modal_dampers;
  for (Index i = 0; i < omega.size(); ++i) {
    const double ratio = found.row(i).squaredNorm() * omega(i) / 2;
    // Far above the rounding of shapes, and far below what a mode without deformations misses by.
    if (std::abs(ratio - wanted(i) / 2) <= 1e-6 * wanted.maxCoeff()) continue;
    throw Refusal(place + ": " +
                  formatted("mode %d, of %.4g Hz, is held by weight or loads and not by "
                            "deformations, which is what is damped; allowed is a sequence, a ratio "
                            "for each mode upwards from the lowest, with 0 for this one",
                            static_cast<int>(i) + 1, natural.natural_frequencies_hz(i)));
  }
}

}  // namespace stillframe

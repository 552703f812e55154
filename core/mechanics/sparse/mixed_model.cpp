#include "core/mechanics/sparse/mixed_model.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/mechanics/model/local_terms.hpp"

namespace stillframe {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

using Triplets = std::vector<Eigen::Triplet<double>>;

/// Adds local entries whose coordinates are both free.
template <class Local>
void scatter(const std::vector<PartMap>& parts, Index n, const Local& local, Triplets& entries) {
  for_each_column(parts, n, [&](Index i, Index row) {
    for_each_column(parts, n, [&](Index j, Index column) {
      if (local(i, j) != 0.0) entries.emplace_back(row, column, local(i, j));
    });
  });
}

SparseMatrix square(Index n, const Triplets& entries) {
  SparseMatrix matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

/// The time that S_d is of S; below 0 if it is not a multiple.
double damping_time_of(const MatrixXd& S, const MatrixXd& S_d) {
  const double time = S.isZero(0) ? 0 : S.cwiseProduct(S_d).sum() / S.squaredNorm();
  return (S_d - time * S).norm() <= 1e-14 * S_d.norm() ? time : -1;
}

}  // namespace

MixedModel::MixedModel(const Model& model) : model_(model), rows_(model.elements.size()) {
  if (model.n_d > 0 || !model.turning_loads.empty()) {
    throw std::invalid_argument("a mixed model has neither dofs nor loads that turn");
  }
  std::vector<double> compliance, damping_time;
  for (size_t k = 0; k < model.elements.size(); ++k) {
    const ModelElement& item = model.elements[k];
    Rows& rows = rows_[k];
    const Index n_e = item.element->n_deformations();
    rows.first = static_cast<Index>(compliance.size());
    rows.prescribed = VectorXd::Zero(n_e);
    VectorXd preload = VectorXd::Zero(n_e);
    MatrixXd S = item.S.size() > 0 ? item.S : MatrixXd::Zero(n_e, n_e);
    std::vector<Index> conditions;
    for (Index i = 0; i < n_e; ++i) {
      const Index row = item.row[static_cast<size_t>(i)];
      preload(i) = model.preload(row);
      if (row >= model.n_e - model.n_redundant) continue;
      conditions.push_back(i);
      const Index prescribed = model.conditions[static_cast<size_t>(row)].prescribed;
      if (prescribed >= 0) rows.prescribed(i) = model.q_r_0(model.n_rx + prescribed);
    }
    rows.given = S * rows.prescribed;
    if (item.damped) rows.S_d = item.S_d;
    for (const Index i : conditions) {
      rows.given(i) = 0;
      for (MatrixXd* law : {&S, &rows.S_d}) {
        if (law->size() == 0) continue;
        law->row(i).setZero();
        law->col(i).setZero();
      }
    }
    rows.given += preload;
    const double time = item.damped ? damping_time_of(S, rows.S_d) : 0;
    rows.in_D = time < 0;
    damped_ = damped_ || item.damped;
    // Principal stiffnesses of deformations that are scaled by how stiff each is by itself, or what
    // is soft is known to the rounding of what is stiff. A deformation that nothing resists has no
    // row.
    const LocalDeformation scale = S.diagonal().unaryExpr(
        [](double entry) { return entry != 0 ? std::sqrt(std::abs(entry)) : 1.0; });
    const LocalDeformation inverse = scale.cwiseInverse();
    // Of any size: that one is compiled already.
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> principal(
        Eigen::MatrixXd(inverse.asDiagonal() * S * inverse.asDiagonal()));
    const double least = 1e-14 * principal.eigenvalues().cwiseAbs().maxCoeff();
    rows.Q.resize(n_e, 0);
    const auto add = [&](const LocalDeformation& direction, double c) {
      rows.Q.conservativeResize(n_e, rows.Q.cols() + 1);
      rows.Q.rightCols(1) = direction.normalized();
      compliance.push_back(c / direction.squaredNorm());
      damping_time.push_back(c != 0 ? std::max(time, 0.0) : 0);
    };
    for (Index i = 0; i < n_e; ++i) {
      const double stiffness = principal.eigenvalues()(i);
      if (std::abs(stiffness) <= least) continue;
      add(scale.cwiseProduct(principal.eigenvectors().col(i)), 1 / stiffness);
    }
    for (const Index i : conditions) add(LocalDeformation::Unit(n_e, i), 0);
    rigid_ = rigid_ || (!conditions.empty() && item.parts.size() > 1);
  }
  n_rows_ = static_cast<Index>(compliance.size());
  compliance_ = Eigen::Map<const VectorXd>(compliance.data(), n_rows_);
  damping_time_ = Eigen::Map<const VectorXd>(damping_time.data(), n_rows_);
  stiffness_ = compliance_.unaryExpr([](double c) { return c != 0 ? 1 / c : 0.0; });
}

Index MixedModel::size(Of of) const {
  return of == Of::free ? model_.n_c : model_.n_x + model_.n_0;
}

VectorXd MixedModel::written(double factor) const {
  VectorXd x = VectorXd::Zero(model_.n_x);
  x.tail(model_.n_rx) = factor * model_.q_r_0.head(model_.n_rx);
  return x;
}

LocalJacobian MixedModel::local_jacobian(size_t k, const VectorXd& x) const {
  const ModelElement& item = model_.elements[k];
  LocalVector u;
  gather(item.parts, x, u);
  LocalJacobian D(item.element->n_deformations(), u.size());
  item.element->jacobian(u, D);
  columns_to_node_axes(item.parts, D);
  return D;
}

VectorXd MixedModel::strains(const VectorXd& x, double load_factor) const {
  VectorXd strains(n_rows_);
  for (size_t k = 0; k < rows_.size(); ++k) {
    strains.segment(rows_[k].first, rows_[k].Q.cols()) =
        rows_[k].Q.transpose() * (deformations(k, x) - load_factor * rows_[k].prescribed);
  }
  return strains;
}

SparseMatrix MixedModel::strain_rows(const VectorXd& x, Of of) const {
  const Index n = size(of);
  Triplets entries;
  for (size_t k = 0; k < rows_.size(); ++k) {
    const LocalJacobian D = rows_[k].Q.transpose() * local_jacobian(k, x);
    for_each_column(model_.elements[k].parts, n, [&](Index j, Index column) {
      for (Index i = 0; i < D.rows(); ++i) {
        if (D(i, j) != 0.0) entries.emplace_back(rows_[k].first + i, column, D(i, j));
      }
    });
  }
  SparseMatrix E(n_rows_, n);
  E.setFromTriplets(entries.begin(), entries.end());
  return E;
}

SparseMatrix MixedModel::mass(const VectorXd& x, Of of) const {
  const Index n = size(of);
  Triplets entries;
  for (const ModelInertia& item : model_.inertias) {
    scatter(item.parts, n, local_mass(item, x), entries);
  }
  return square(n, entries);
}

SparseMatrix MixedModel::damping(const VectorXd& x, Of of) const {
  const Index n = size(of);
  Triplets entries;
  for (size_t k = 0; k < rows_.size(); ++k) {
    const ModelElement& item = model_.elements[k];
    if (!rows_[k].in_D) continue;
    const LocalJacobian D = local_jacobian(k, x);
    const LocalHessian damping = D.transpose() * rows_[k].S_d * D;
    scatter(item.parts, n, damping, entries);
  }
  return square(n, entries);
}

SparseMatrix MixedModel::geometric_stiffness(const MixedState& state, Of of) const {
  const VectorXd& x = state.x;
  const Index n = size(of);
  Triplets entries;
  for (size_t k = 0; k < rows_.size(); ++k) {
    const ModelElement& item = model_.elements[k];
    const LocalDeformation sigma = stresses(k, state);
    if (sigma.isZero(0)) continue;
    scatter(item.parts, n, stress_stiffness(item, x, sigma), entries);
  }
  if (!model_.gravity.isZero(0)) {
    for (const ModelInertia& item : model_.inertias) {
      scatter(item.parts, n, weight_stiffness(item, x, state.load_factor * model_.gravity),
              entries);
    }
  }
  return square(n, entries);
}

VectorXd MixedModel::forces(const VectorXd& x, double load_factor, Of of) const {
  const Index n = size(of);
  VectorXd f(model_.n_x + model_.n_0);
  f << load_factor * model_.load, load_factor * model_.fixed_load;
  f.conservativeResize(n);
  if (!model_.gravity.isZero(0)) {
    const VectorXd rest = VectorXd::Zero(model_.n_x);
    subtract_inertia_forces(model_, x, rest, rest, load_factor * model_.gravity, f);
  }
  for (size_t k = 0; k < rows_.size(); ++k) {
    const LocalDeformation sigma = load_factor * rows_[k].given;
    if (sigma.isZero(0)) continue;
    const LocalJacobian D = local_jacobian(k, x);
    LocalVector F = D.transpose() * sigma;
    for_each_column(model_.elements[k].parts, n, [&](Index i, Index column) { f(column) -= F(i); });
  }
  return f;
}

LocalDeformation MixedModel::deformations(size_t k, const VectorXd& x) const {
  const ModelElement& item = model_.elements[k];
  LocalVector u;
  gather(item.parts, x, u);
  LocalDeformation e(item.element->n_deformations());
  item.element->deformations(u, e);
  return e;
}

LocalDeformation MixedModel::stresses(size_t k, const MixedState& state) const {
  const Rows& rows = rows_[k];
  return state.load_factor * rows.given + rows.Q * state.s.segment(rows.first, rows.Q.cols());
}

VectorXd MixedModel::deformation_row(size_t k, Index i, const VectorXd& x) const {
  VectorXd row = VectorXd::Zero(size(Of::all));
  const LocalJacobian D = local_jacobian(k, x);
  for_each_column(model_.elements[k].parts, row.size(),
                  [&](Index j, Index column) { row(column) += D(i, j); });
  return row;
}

VectorXd MixedModel::viscous_row(size_t k, Index i, const VectorXd& x) const {
  VectorXd row = VectorXd::Zero(size(Of::all));
  if (!rows_[k].in_D) return row;
  const LocalVector S_d_D = (rows_[k].S_d.row(i) * local_jacobian(k, x)).transpose();
  for_each_column(model_.elements[k].parts, row.size(),
                  [&](Index j, Index column) { row(column) += S_d_D(j); });
  return row;
}

VectorXd MixedModel::stress_row(size_t k, Index i) const {
  VectorXd row = VectorXd::Zero(n_rows_);
  row.segment(rows_[k].first, rows_[k].Q.cols()) = rows_[k].Q.row(i);
  return row;
}

auto MixedModel::prescribed(const VectorXd& pattern, const VectorXd& x) const -> Prescribed {
  Prescribed driven{VectorXd::Zero(n_rows_), VectorXd::Zero(size(Of::all)),
                    VectorXd::Zero(size(Of::all))};
  for (size_t j = 0; j < model_.prescribed_rows.size(); ++j) {
    const double amount = pattern(model_.n_rx + static_cast<Index>(j));
    if (amount == 0) continue;
    const auto [k, i] = model_.owner_of_row(model_.prescribed_rows[j]);
    const ModelElement& item = model_.elements[k];
    const Rows& rows = rows_[k];
    driven.e.segment(rows.first, rows.Q.cols()) += amount * rows.Q.row(i).transpose();
    const auto add = [&](const MatrixXd& S, VectorXd& forces) {
      LocalDeformation sigma = amount * S.col(i);
      for (Index row = 0; row < sigma.size(); ++row) {
        if (!model_.is_elastic(item.row[static_cast<size_t>(row)])) sigma(row) = 0;
      }
      const LocalVector F = local_jacobian(k, x).transpose() * sigma;
      for_each_column(item.parts, forces.size(),
                      [&](Index column_of, Index column) { forces(column) += F(column_of); });
    };
    if (item.S.size() > 0) add(item.S, driven.K);
    if (item.damped) add(item.S_d, driven.D);
  }
  return driven;
}

}  // namespace stillframe

#include "core/mechanics/sparse/mixed_model.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace stillframe {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

using Triplets = std::vector<Eigen::Triplet<double>>;

/// Adds local entries whose coordinates are both free.
template <class Local>
void scatter(const std::vector<PartMap>& parts, Index n, const Local& local, double factor,
             Triplets& entries) {
  for_each_column(parts, n, [&](Index i, Index row) {
    for_each_column(parts, n, [&](Index j, Index column) {
      if (local(i, j) != 0.0) entries.emplace_back(row, column, factor * local(i, j));
    });
  });
}

SparseMatrix square(Index n, const Triplets& entries) {
  SparseMatrix matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

/// The time that S_d is of S, of deformations that are no conditions; below 0 if it is not a
/// multiple.
double damping_time_of(const LocalStiffness& S, LocalStiffness S_d,
                       const std::vector<Index>& conditions) {
  for (const Index i : conditions) {
    S_d.row(i).setZero();
    S_d.col(i).setZero();
  }
  const double time = S.isZero(0) ? 0 : S.cwiseProduct(S_d).sum() / S.squaredNorm();
  return (S_d - time * S).norm() <= 1e-14 * S_d.norm() ? time : -1;
}

template <class Local>
void to_node_axes(const std::vector<PartMap>& parts, Local& local) {
  columns_to_node_axes(parts, local);
  rows_to_node_axes(parts, local);
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
    rows.preload = rows.given = rows.prescribed = LocalDeformation::Zero(n_e);
    LocalStiffness S = item.S.size() > 0 ? item.S : LocalStiffness(LocalStiffness::Zero(n_e, n_e));
    std::vector<Index> conditions;
    for (Index i = 0; i < n_e; ++i) {
      const Index row = item.row[static_cast<size_t>(i)];
      rows.preload(i) = model.preload(row);
      if (row >= model.n_e - model.n_redundant) continue;
      conditions.push_back(i);
      const Index prescribed = model.conditions[static_cast<size_t>(row)].prescribed;
      if (prescribed >= 0) rows.prescribed(i) = model.q_r_0(model.n_rx + prescribed);
    }
    rows.given = S * rows.prescribed;
    for (const Index i : conditions) {
      S.row(i).setZero();
      S.col(i).setZero();
      rows.given(i) = 0;
    }
    const double time = item.damped ? damping_time_of(S, item.S_d, conditions) : 0;
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
  LocalVector u;
  for (size_t k = 0; k < rows_.size(); ++k) {
    const ModelElement& item = model_.elements[k];
    gather(item.parts, x, u);
    LocalDeformation e(item.element->n_deformations());
    item.element->deformations(u, e);
    strains.segment(rows_[k].first, rows_[k].Q.cols()) =
        rows_[k].Q.transpose() * (e - load_factor * rows_[k].prescribed);
  }
  return strains;
}

SparseMatrix MixedModel::strain_rows(const VectorXd& x) const {
  Triplets entries;
  for (size_t k = 0; k < rows_.size(); ++k) {
    const LocalJacobian D = rows_[k].Q.transpose() * local_jacobian(k, x);
    for_each_column(model_.elements[k].parts, model_.n_c, [&](Index j, Index column) {
      for (Index i = 0; i < D.rows(); ++i) {
        if (D(i, j) != 0.0) entries.emplace_back(rows_[k].first + i, column, D(i, j));
      }
    });
  }
  SparseMatrix E(n_rows_, model_.n_c);
  E.setFromTriplets(entries.begin(), entries.end());
  return E;
}

SparseMatrix MixedModel::mass(const VectorXd& x) const {
  Triplets entries;
  LocalVector u;
  for (const ModelInertia& item : model_.inertias) {
    gather(item.parts, x, u);
    LocalHessian M(u.size(), u.size());
    item.inertia->mass(u, M);
    to_node_axes(item.parts, M);
    scatter(item.parts, model_.n_c, M, 1, entries);
  }
  return square(model_.n_c, entries);
}

SparseMatrix MixedModel::damping(const VectorXd& x) const {
  Triplets entries;
  for (size_t k = 0; k < rows_.size(); ++k) {
    const ModelElement& item = model_.elements[k];
    if (!rows_[k].in_D) continue;
    const LocalJacobian D = local_jacobian(k, x);
    const LocalHessian damping = D.transpose() * item.S_d * D;
    scatter(item.parts, model_.n_c, damping, 1, entries);
  }
  return square(model_.n_c, entries);
}

SparseMatrix MixedModel::geometric_stiffness(const VectorXd& x, const VectorXd& s,
                                             double load_factor) const {
  Triplets entries;
  LocalVector u;
  for (size_t k = 0; k < rows_.size(); ++k) {
    const ModelElement& item = model_.elements[k];
    const Rows& rows = rows_[k];
    const LocalDeformation sigma =
        load_factor * (rows.preload + rows.given) + rows.Q * s.segment(rows.first, rows.Q.cols());
    if (sigma.isZero(0)) continue;
    gather(item.parts, x, u);
    LocalHessian H(u.size(), u.size());
    item.element->hessian(u, sigma, H);
    to_node_axes(item.parts, H);
    scatter(item.parts, model_.n_c, H, 1, entries);
  }
  if (!model_.gravity.isZero(0)) {
    for (const ModelInertia& item : model_.inertias) {
      gather(item.parts, x, u);
      const LocalVector rest = LocalVector::Zero(u.size());
      LocalHessian in_v(u.size(), u.size()), in_u(u.size(), u.size());
      item.inertia->tangents(u, rest, rest, load_factor * model_.gravity, in_v, in_u);
      if (in_u.isZero(0)) continue;
      to_node_axes(item.parts, in_u);
      scatter(item.parts, model_.n_c, in_u, 1, entries);
    }
  }
  return square(model_.n_c, entries);
}

VectorXd MixedModel::forces(const VectorXd& x, double load_factor) const {
  VectorXd f = load_factor * model_.load.head(model_.n_c);
  LocalVector u;
  if (!model_.gravity.isZero(0)) {
    for (const ModelInertia& item : model_.inertias) {
      gather(item.parts, x, u);
      const LocalVector rest = LocalVector::Zero(u.size());
      LocalVector F(u.size());
      item.inertia->force(u, rest, rest, load_factor * model_.gravity, F);
      rows_to_node_axes(item.parts, F);
      for_each_column(item.parts, model_.n_c, [&](Index i, Index column) { f(column) -= F(i); });
    }
  }
  for (size_t k = 0; k < rows_.size(); ++k) {
    const LocalDeformation sigma = load_factor * (rows_[k].preload + rows_[k].given);
    if (sigma.isZero(0)) continue;
    const LocalJacobian D = local_jacobian(k, x);
    LocalVector F = D.transpose() * sigma;
    for_each_column(model_.elements[k].parts, model_.n_c,
                    [&](Index i, Index column) { f(column) -= F(i); });
  }
  return f;
}

}  // namespace stillframe

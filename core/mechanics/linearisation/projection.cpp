#include "core/mechanics/linearisation/projection.hpp"

#include "core/mechanics/model/local_terms.hpp"
#include "core/mechanics/turning_load.hpp"

namespace stillframe {

namespace {

/// Columns of X that are not zero in the given rows.
void nonzero_columns(const std::vector<const RowMatrix*>& matrices, const std::vector<Index>& rows,
                     std::vector<Index>& columns) {
  columns.clear();
  const Index n = matrices.front()->cols();
  for (Index j = 0; j < n; ++j) {
    bool zero = true;
    for (const RowMatrix* X : matrices) {
      for (size_t i = 0; i < rows.size() && zero; ++i) {
        zero = rows[i] < 0 || (*X)(rows[i], j) == 0.0;
      }
    }
    if (!zero) columns.push_back(j);
  }
}

void take(const RowMatrix& X, const std::vector<Index>& rows, const std::vector<Index>& columns,
          Eigen::MatrixXd& values) {
  values.setZero(static_cast<Index>(rows.size()), static_cast<Index>(columns.size()));
  for (size_t i = 0; i < rows.size(); ++i) {
    if (rows[i] < 0) continue;
    for (size_t j = 0; j < columns.size(); ++j) {
      values(static_cast<Index>(i), static_cast<Index>(j)) = X(rows[i], columns[j]);
    }
  }
}

/// Row of X for each local coordinate, -1 where it has none.
std::vector<Index> rows_below(const std::vector<PartMap>& parts, Index n) {
  std::vector<Index> rows(static_cast<size_t>(local_size(parts)), -1);
  for_each_column(parts, n, [&](Index i, Index column) { rows[static_cast<size_t>(i)] = column; });
  return rows;
}

}  // namespace

void LocalColumns::gather(const std::vector<PartMap>& parts, const RowMatrix& T, const RowMatrix* X,
                          const RowMatrix* X_1, const RowMatrix* X_2) {
  const std::vector<Index> test_rows = rows_below(parts, T.rows()),
                           rows = rows_below(parts, X->rows());
  nonzero_columns({&T}, test_rows, test_columns_);
  take(T, test_rows, test_columns_, test_);
  std::vector<const RowMatrix*> matrices{X};
  for (const RowMatrix* rate : {X_1, X_2}) {
    if (rate && rate->size() > 0) matrices.push_back(rate);
  }
  nonzero_columns(matrices, rows, columns_);
  for (size_t i = 0; i < matrices.size(); ++i) take(*matrices[i], rows, columns_, values_[i]);
}

void LocalColumns::gather_rows(const RowMatrix& E_T, const RowMatrix& E, const RowMatrix* E_1) {
  std::vector<Index> rows(static_cast<size_t>(E.rows()));
  for (size_t i = 0; i < rows.size(); ++i) rows[i] = static_cast<Index>(i);
  nonzero_columns({&E_T}, rows, test_columns_);
  take(E_T, rows, test_columns_, test_);
  std::vector<const RowMatrix*> matrices{&E};
  if (E_1) matrices.push_back(E_1);
  nonzero_columns(matrices, rows, columns_);
  for (size_t i = 0; i < matrices.size(); ++i) take(*matrices[i], rows, columns_, values_[i]);
}

void LocalColumns::scatter(Eigen::MatrixXd& out) const {
  for (size_t j = 0; j < columns_.size(); ++j) {
    for (size_t i = 0; i < test_columns_.size(); ++i) {
      out(test_columns_[i], columns_[j]) += result_(static_cast<Index>(i), static_cast<Index>(j));
    }
  }
}

void add_stress_term(const Model& model, const Data& data, const Columns& columns, size_t k,
                     LocalColumns& local, Eigen::MatrixXd& G) {
  const ModelElement& item = model.elements[k];
  LocalDeformation sigma(item.element->n_deformations());
  for (Index i = 0; i < sigma.size(); ++i)
    sigma(i) = data.sigma_balanced(item.row[static_cast<size_t>(i)]);
  if (sigma.isZero(0)) return;
  local.gather(item.parts, columns.T, &columns.X, nullptr, nullptr);
  local.add(stress_stiffness(item, data.x, sigma), 0, 1.0, G);
}

void add_weight_term(const Model& model, const Data& data, const Columns& columns,
                     const ModelInertia& item, LocalColumns& local, Eigen::MatrixXd& G) {
  if (model.gravity.isZero(0)) return;
  const LocalHessian in_u = weight_stiffness(item, data.x, data.load_factor * model.gravity);
  if (in_u.isZero(0)) return;
  local.gather(item.parts, columns.T, &columns.X, nullptr, nullptr);
  local.add(in_u, 0, 1.0, G);
}

void add_load_term(const Model& model, const Data& data, const Columns& columns,
                   const ModelLoad& load, LocalColumns& local, Eigen::MatrixXd& G) {
  const std::vector<PartMap> parts = parts_of(model, load);
  LocalVector u;
  gather(parts, data.x, u);
  const Index rotation = u.size() - 3;
  const TurnedLoad turned(load, u.tail(rotation), model.planar);
  LocalHessian L = LocalHessian::Zero(u.size(), u.size());
  L.topRightCorner(3, rotation) = turned.d_force.leftCols(rotation);
  L.bottomRightCorner(rotation, rotation) = turned.d_moment.topLeftCorner(rotation, rotation);
  rows_to_node_axes(parts, L);
  local.gather(parts, columns.T, &columns.X, nullptr, nullptr);
  local.add(L, 0, -data.load_factor, G);
}

Eigen::MatrixXd geometric_stiffness(const Model& model, const Data& data, const Columns& columns) {
  LocalColumns local;
  Eigen::MatrixXd G = Eigen::MatrixXd::Zero(columns.T.cols(), columns.X.cols());
  for (size_t k = 0; k < model.elements.size(); ++k) {
    add_stress_term(model, data, columns, k, local, G);
  }
  for (const ModelInertia& item : model.inertias) {
    add_weight_term(model, data, columns, item, local, G);
  }
  for (const ModelLoad& load : model.turning_loads) {
    add_load_term(model, data, columns, load, local, G);
  }
  return G;
}

}  // namespace stillframe

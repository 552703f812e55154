#include "core/mechanics/linearisation/columns.hpp"

namespace stillframe {

Columns::Columns(const Model& model, Eigen::MatrixXd prescribed_patterns,
                 const std::vector<ResolvedSignal>& reactions)
    : patterns(std::move(prescribed_patterns)), reactions_(reactions) {
  const Index n_Q = model.n_d + patterns.cols();
  X.setZero(model.n_x, n_Q);
  T.setZero(model.n_x + model.n_0, model.n_d + static_cast<Index>(reactions.size()));
}

void Columns::compute(const Model& model, Data& data, bool moving) {
  X.leftCols(model.n_d) = data.DF;
  if (patterns.cols() > 0) {
    X.rightCols(patterns.cols()) = prescribed_transfer_functions(model, data, patterns);
  }
  compute_tests(model, data);
  if (moving) {
    compute_rates(model, data);
  } else {
    X_1.resize(0, 0);
    X_2.resize(0, 0);
    D_1.clear();
    D_2.clear();
  }
}

void Columns::subtract(const Model& model, const std::vector<Eigen::MatrixXd>& local,
                       const RowMatrix& X, double factor, RowMatrix& right) {
  for (size_t k = 0; k < model.elements.size(); ++k) {
    const ModelElement& item = model.elements[k];
    for_each_column(item.parts, model.n_x, [&](Index j, Index column) {
      for (Index i = 0; i < local[k].rows(); ++i) {
        const Index row = item.row[static_cast<size_t>(i)];
        if (row < model.n_c && local[k](i, j) != 0.0) {
          right.row(row) -= factor * local[k](i, j) * X.row(column);
        }
      }
    });
  }
}

/// The conditions D X = const differentiated in time: J X_1 = -D_1 X and
/// J X_2 = -2 D_1 X_1 - D_2 X on the dependent coordinates; the independent ones have none.
void Columns::compute_rates(const Model& model, Data& data) {
  LocalVector u, v, a;
  D_1.resize(model.elements.size());
  D_2.resize(model.elements.size());
  for (size_t k = 0; k < model.elements.size(); ++k) {
    const ModelElement& item = model.elements[k];
    gather(item.parts, data.x, u);
    gather(item.parts, data.x_dot, v);
    gather(item.parts, data.x_ddot, a);
    D_1[k].resize(data.D[k].rows(), data.D[k].cols());
    D_2[k].resize(data.D[k].rows(), data.D[k].cols());
    item.element->jacobian_rates(u, v, a, D_1[k], D_2[k]);
    columns_to_node_axes(item.parts, D_1[k]);
    columns_to_node_axes(item.parts, D_2[k]);
  }
  RowMatrix right = RowMatrix::Zero(model.n_c, X.cols());
  subtract(model, D_1, X, 1.0, right);
  data.J.solve(right);
  X_1.setZero(model.n_x, X.cols());
  X_1.topRows(model.n_c) = right;
  right.setZero();
  subtract(model, D_1, X_1, 2.0, right);
  subtract(model, D_2, X, 1.0, right);
  data.J.solve(right);
  X_2.setZero(model.n_x, X.cols());
  X_2.topRows(model.n_c) = right;
}

/// A reaction does work on one motion that the model does not allow: of a held coordinate, or of
/// one zero or prescribed deformation, while all other conditions and all dofs stay.
void Columns::compute_tests(const Model& model, Data& data) {
  T.topLeftCorner(model.n_x, model.n_d) = data.DF;
  for (size_t r = 0; r < reactions_.size(); ++r) {
    const Index j = model.n_d + static_cast<Index>(r);
    const ResolvedSignal& reaction = reactions_[r];
    data.condition.setZero();
    T.col(j).setZero();
    if (reaction.row >= 0) {
      data.condition(reaction.row) = 1.0;
    } else {
      const Eigen::VectorXd motion = virtual_motion(model, data.x, reaction);
      T.col(j) = motion;
      LocalVector local;
      for (size_t k = 0; k < model.elements.size(); ++k) {
        const ModelElement& item = model.elements[k];
        gather_in_node_axes(item.parts, motion, local);
        if (local.isZero(0)) continue;
        for (Index i = 0; i < data.D[k].rows(); ++i) {
          const Index row = item.row[static_cast<size_t>(i)];
          if (row < model.n_c) data.condition(row) -= data.D[k].row(i).dot(local);
        }
      }
    }
    data.J.solve(data.condition);
    T.col(j).head(model.n_c) = data.condition;
  }
}

namespace {

/// E.row(i) += D.row(i) X for the redundant deformations of element k.
void add_redundant(const Model& model, const ModelElement& item, const Eigen::MatrixXd& D,
                   const RowMatrix& X, double factor, RowMatrix& E) {
  for_each_column(item.parts, X.rows(), [&](Index j, Index column) {
    for (Index i = 0; i < D.rows(); ++i) {
      if (item.row[static_cast<size_t>(i)] >= model.n_c) {
        E.row(i) += factor * D(i, j) * X.row(column);
      }
    }
  });
}

}  // namespace

void deformation_columns(const Model& model, const Data& data, const Columns& columns, size_t k,
                         RowMatrix& E) {
  const ModelElement& item = model.elements[k];
  E.setZero(data.D[k].rows(), columns.X.cols());
  add_redundant(model, item, data.D[k], columns.X, 1.0, E);
  for (Index i = 0; i < E.rows(); ++i) {
    const Index row = item.row[static_cast<size_t>(i)];
    if (row >= model.n_c || item.zero[static_cast<size_t>(i)]) continue;
    const Model::Condition& condition = model.conditions[static_cast<size_t>(row)];
    if (condition.dof >= 0) E(i, condition.dof) = 1.0;
    if (condition.prescribed >= 0) {
      E.row(i).tail(columns.patterns.cols()) =
          columns.patterns.row(model.n_rx + condition.prescribed);
    }
  }
}

void deformation_tests(const Model& model, const Data& data, const Columns& columns, size_t k,
                       RowMatrix& E) {
  const ModelElement& item = model.elements[k];
  E.setZero(data.D[k].rows(), columns.T.cols());
  add_redundant(model, item, data.D[k], columns.T, 1.0, E);
  for (Index i = 0; i < E.rows(); ++i) {
    const Index row = item.row[static_cast<size_t>(i)];
    if (row >= model.n_c) continue;
    const Index dof = model.conditions[static_cast<size_t>(row)].dof;
    if (dof >= 0) E(i, dof) = 1.0;
  }
}

void deformation_column_rates(const Model& model, const Data& data, const Columns& columns,
                              size_t k, RowMatrix& E_1, RowMatrix& E_2) {
  const ModelElement& item = model.elements[k];
  E_1.setZero(data.D[k].rows(), columns.X.cols());
  E_2.setZero(data.D[k].rows(), columns.X.cols());
  if (columns.D_1.empty()) return;
  add_redundant(model, item, data.D[k], columns.X_1, 1.0, E_1);
  add_redundant(model, item, columns.D_1[k], columns.X, 1.0, E_1);
  add_redundant(model, item, data.D[k], columns.X_2, 1.0, E_2);
  add_redundant(model, item, columns.D_1[k], columns.X_1, 2.0, E_2);
  add_redundant(model, item, columns.D_2[k], columns.X, 1.0, E_2);
}

}  // namespace stillframe

#pragma once

#include "core/mechanics/linearisation/columns.hpp"

namespace stillframe {

/// The test vectors and columns of one element or inertia, without the columns in which all its
/// coordinates are zero: what makes the work grow with the structure and not with the square of its
/// dofs.
class LocalColumns {
 public:
  /// Gathers T and up to three matrices of columns for the given parts.
  void gather(const std::vector<PartMap>& parts, const RowMatrix& T, const RowMatrix* X,
              const RowMatrix* X_1, const RowMatrix* X_2);

  /// out += T^T L X_order, L n_local x n_local (order 0, 1, 2).
  template <class Local>
  void add(const Local& L, int order, double factor, Eigen::MatrixXd& out) {
    product_.noalias() = L * values_[order];
    result_.noalias() = factor * test_.transpose() * product_;
    scatter(out);
  }
  /// out += E_T^T S E for rows of deformations that were gathered with gather_rows.
  void gather_rows(const RowMatrix& E_T, const RowMatrix& E, const RowMatrix* E_1);

 private:
  void scatter(Eigen::MatrixXd& out) const;

  std::vector<Index> test_columns_, columns_;
  Eigen::MatrixXd test_, values_[3], product_, result_;
};

/// Terms of the geometric stiffness G (n_T x n_Q) at the positions, stresses and load factor in
/// data: of the stresses of element k, of the weight of an inertia, of a load that turns.
void add_stress_term(const Model& model, const Data& data, const Columns& columns, size_t k,
                     LocalColumns& local, Eigen::MatrixXd& G);
void add_weight_term(const Model& model, const Data& data, const Columns& columns,
                     const ModelInertia& item, LocalColumns& local, Eigen::MatrixXd& G);
void add_load_term(const Model& model, const Data& data, const Columns& columns,
                   const ModelLoad& load, LocalColumns& local, Eigen::MatrixXd& G);

/// The sum of all three.
Eigen::MatrixXd geometric_stiffness(const Model& model, const Data& data, const Columns& columns);

}  // namespace stillframe

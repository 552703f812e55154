#pragma once

#include "core/mechanics/kinematics.hpp"
#include "core/mechanics/linearisation/signal_rows.hpp"

namespace stillframe {

/// The columns that the linearised equations multiply, one for each dof and then one for each
/// prescribed motion among the inputs, and the test vectors that the equations are projected on,
/// one for each dof and then one for each reaction among the outputs. n_Q and n_T columns.
struct Columns {
  RowMatrix X;         ///< n_x x n_Q, DF
  RowMatrix X_1;       ///< n_x x n_Q, D2F q' = d(DF)/dt; empty at rest
  RowMatrix X_2;       ///< n_x x n_Q, D2F q'' + D3F q' q' = d2(DF)/dt2; empty at rest
  RowMatrix T;         ///< (n_x + n_0) x n_T
  RowMatrix patterns;  ///< n_r x (n_Q - n_d), the prescribed motions
  std::vector<Eigen::MatrixXd> D_1, D_2;  ///< first and second time derivative of D; empty at rest

  Columns(const Model& model, Eigen::MatrixXd prescribed_patterns,
          const std::vector<ResolvedSignal>& reactions);

  /// Writes all for the motion in data (after complete_accelerations).
  void compute(const Model& model, Data& data, bool moving);

 private:
  void compute_rates(const Model& model, Data& data);
  void compute_tests(const Model& model, Data& data);
  /// right -= local_k X for the rows of the conditions.
  static void subtract(const Model& model, const std::vector<Eigen::MatrixXd>& local,
                       const RowMatrix& X, double factor, RowMatrix& right);

  std::vector<ResolvedSignal> reactions_;
};

/// D X of one element (n_e x n_Q), exact where a deformation is a dof or prescribed, zero where it
/// is held zero; of the test vectors alike, with no column of a dof or reaction working on
/// prescribed deformations.
void deformation_columns(const Model& model, const Data& data, const Columns& columns, size_t k,
                         RowMatrix& E);
void deformation_tests(const Model& model, const Data& data, const Columns& columns, size_t k,
                       RowMatrix& E);
/// First and second time derivatives of D X; zero at rest.
void deformation_column_rates(const Model& model, const Data& data, const Columns& columns,
                              size_t k, RowMatrix& E_1, RowMatrix& E_2);

}  // namespace stillframe

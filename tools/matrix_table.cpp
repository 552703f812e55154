#include "tools/matrix_table.hpp"

#include <cmath>

#include "core/errors/formatted.hpp"
#include "report/table.hpp"

namespace stillframe::tools {

namespace {

/// The matrix with every row and column brought to a largest entry of 1 by scales: what is the
/// rounding of its neighbours shows there whatever the units are, metres beside radians or
/// newtons beside piconewtons.
Eigen::MatrixXd equilibrated(Eigen::MatrixXd A) {
  A = A.cwiseAbs();
  // Each time the distance from 1, in powers of ten, is halved or better: 30 take any double.
  for (int round = 0; round < 30; ++round) {
    const Eigen::VectorXd rows = A.rowwise().maxCoeff(), columns = A.colwise().maxCoeff();
    const auto scale = [](double x) { return x > 0 ? 1 / std::sqrt(x) : 1.0; };
    A = rows.unaryExpr(scale).asDiagonal() * A * columns.unaryExpr(scale).asDiagonal();
  }
  return A;
}

}  // namespace

std::string matrix_table(const std::string& title, const Eigen::MatrixXd& matrix, Units units) {
  const double largest = matrix.size() > 0 ? matrix.cwiseAbs().maxCoeff() : 0.0;
  Eigen::MatrixXd sizes = matrix.cwiseAbs() / (largest > 0 ? largest : 1.0);
  if (units == Units::of_dofs) sizes = equilibrated(matrix);
  report::Table table(std::vector<std::string>(static_cast<size_t>(matrix.cols())), 0);
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    std::vector<std::string> row;
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) {
      row.push_back(formatted("%.6g", sizes(i, j) < 1e-12 ? 0.0 : matrix(i, j)));
    }
    table.add(row);
  }
  return title + "\n" + table.print().substr(1);
}

}  // namespace stillframe::tools

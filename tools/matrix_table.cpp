#include "tools/matrix_table.hpp"

#include "report/table.hpp"

namespace stillframe::tools {

std::string matrix_table(const std::string& title, const Eigen::MatrixXd& matrix) {
  const double rounding = matrix.size() ? 1e-12 * matrix.cwiseAbs().maxCoeff() : 0.0;
  report::Table table(std::vector<std::string>(static_cast<size_t>(matrix.cols())), 0);
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    std::vector<std::string> row;
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) {
      row.push_back(report::cell("%.6g", std::abs(matrix(i, j)) < rounding ? 0.0 : matrix(i, j)));
    }
    table.add(row);
  }
  return title + "\n" + table.print().substr(1);
}

}  // namespace stillframe::tools

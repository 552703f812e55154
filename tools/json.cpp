#include "tools/json.hpp"

#include <iostream>
#include <vector>

namespace stillframe::tools {

Json to_json(const Eigen::VectorXd& vector) {
  return std::vector<double>(vector.begin(), vector.end());
}

Json to_json(const Eigen::MatrixXd& matrix) {
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    rows.push_back(to_json(Eigen::VectorXd(matrix.row(i).transpose())));
  }
  return rows;
}

Json to_json(const Eigen::VectorXcd& vector) {
  Json pairs = Json::array();
  for (const auto& value : vector) pairs.push_back({value.real(), value.imag()});
  return pairs;
}

void print(const Json& document) { std::cout << document.dump(1) << "\n"; }

}  // namespace stillframe::tools

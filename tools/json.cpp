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

std::string text_of(const Json& document) {
  // Names come from foreign logs and from the command line, so bytes that are no UTF-8 are replaced
  // rather than thrown over.
  return document.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

void print(const Json& document) { std::cout << text_of(document); }

}  // namespace stillframe::tools

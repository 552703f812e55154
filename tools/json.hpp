#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <string>

namespace stillframe::tools {

/// Numbers read back to the same bits; a matrix is a list of its rows, a complex number a pair [re,
/// im].
using Json = nlohmann::ordered_json;

Json to_json(const Eigen::VectorXd& vector);
Json to_json(const Eigen::MatrixXd& matrix);
Json to_json(const Eigen::VectorXcd& vector);

/// A document as UTF-8, whatever the bytes of its texts.
std::string text_of(const Json& document);

/// Prints it to standard output.
void print(const Json& document);

}  // namespace stillframe::tools

#pragma once

#include <Eigen/SparseCore>
#include <string>
#include <string_view>

namespace stillframe {

/// A real matrix in Matrix Market's exchange format, `coordinate` or `array`, `general` or
/// `symmetric` (of which the format has the lower triangle), from the bytes of the file `name`.
/// Errors: InputError "name:line: ...".
Eigen::SparseMatrix<double> parse_matrix_market(std::string_view bytes, const std::string& name);

/// A symmetric matrix in that format (`array real symmetric`), with all digits; each line of
/// comment after a "%".
std::string matrix_market(const Eigen::MatrixXd& symmetric, const std::string& comment);

/// A number that a text begins with, behind blanks, and what is behind it; false if there is none,
/// or none that is finite.
bool take_number(std::string_view& text, double& value);

}  // namespace stillframe

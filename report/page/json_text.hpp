#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

// Numbers and texts as JSON that may stand in a page. Set-up.
namespace stillframe::page {

using Json = nlohmann::json;

/// A number to six significant digits; null if it is not finite.
Json rounded(double value);
Json rounded(const std::vector<double>& values);
Json rounded(const Eigen::VectorXd& values);
/// A list a column.
Json columns_of(const Eigen::MatrixXd& matrix);

/// Little-endian bytes of the numbers in base64.
std::string base64(const std::vector<std::int16_t>& values);

/// JSON that cannot end the script element it stands in: <, > and & are written as \u escapes,
/// as is everything outside ASCII; bytes that are not UTF-8 become the replacement character.
std::string script_safe(const Json& json);

}  // namespace stillframe::page

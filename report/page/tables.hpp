#pragma once

#include <string>

#include "report/page/page_tables.hpp"

// Tables as HTML. Set-up.
namespace stillframe::page {

/// The customer's table: floor, passive and active of every direction.
std::string result_table(const std::vector<AxisResult>& axes);

/// A table of texts, those that look like numbers to the right. Errors: InputError for a row of
/// another length than the header.
std::string plain_table(const Table& table);

/// A matrix, each entry shaded by its size over the largest. Errors: InputError for names that are
/// not as many as rows or columns.
std::string matrix_table(const MatrixTable& matrix);

}  // namespace stillframe::page

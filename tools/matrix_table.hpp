#pragma once

#include <Eigen/Core>
#include <string>

namespace stillframe::tools {

/// In what an entry is judged to be the rounding of others: as they stand, or, where rows and
/// columns are those of dofs or states, in units in which the largest of each is 1. Of inputs and
/// outputs that would say nothing: one column has all of its entries 1 then.
enum class Units { as_they_stand, of_dofs };

/// A matrix for people, six digits: a line with its title, then its rows. Entries below 1e-12 of
/// the largest are printed as zero.
std::string matrix_table(const std::string& title, const Eigen::MatrixXd& matrix,
                         Units units = Units::as_they_stand);

}  // namespace stillframe::tools

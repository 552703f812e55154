#pragma once

#include <Eigen/Core>
#include <string>

namespace stillframe::tools {

/// A matrix for people, six digits: a line with its title, then its rows. Entries that are the
/// rounding of others are printed as zero.
std::string matrix_table(const std::string& title, const Eigen::MatrixXd& matrix);

}  // namespace stillframe::tools

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace stillframe::tools {

/// The largest entries of a shape, at most `count`, by their names: "tip.y 1, middle.y 0.5". The
/// largest is 1; what is below a thousandth of it is left out. Nothing of a shape of zeros.
std::string largest_parts(const std::vector<std::string>& names, const Eigen::VectorXd& shape,
                          std::size_t count = 4);

}  // namespace stillframe::tools

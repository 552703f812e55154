#pragma once

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "tools/spacar/model.hpp"

namespace stillframe::tools::spacar {

using Keys = std::vector<std::pair<std::string, std::string>>;

/// Numbers as a scene has them: [a, b, c], and rows of a matrix.
std::string list_of(const std::vector<double>& numbers);
std::string matrix_of(const Eigen::MatrixXd& matrix);

/// The keys of an element of a scene. What it weighs besides those is added to `masses`; what it
/// cannot have to the remarks of the model.
Keys element_keys(Model& model, const Element& element, std::vector<Mass>& masses);

}  // namespace stillframe::tools::spacar

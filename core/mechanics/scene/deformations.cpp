#include "core/mechanics/scene/deformations.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "core/mechanics/scene/references.hpp"

namespace stillframe {

namespace {

/// The one deformation that is not rigid, from 0; fails if there are none or several.
Eigen::Index only_elastic(const YamlReader& value, const SceneElement& element) {
  if (element.rigid()) value.fail("a rigid element has none");
  const auto n_elastic = std::count(element.zero.begin(), element.zero.end(), false);
  if (n_elastic > 1) {
    value.fail("found one number, but " + std::to_string(n_elastic) +
               " deformations are not rigid; allowed are " +
               std::to_string(element.n_deformations) + " numbers");
  }
  return std::find(element.zero.begin(), element.zero.end(), false) - element.zero.begin();
}

void refuse_rigid_entries(const YamlReader& value, const SceneElement& element,
                          const Eigen::MatrixXd& entries) {
  for (Eigen::Index i = 0; i < element.n_deformations; ++i) {
    if (element.zero[static_cast<size_t>(i)] && entries.row(i).cwiseAbs().maxCoeff() > 0) {
      value.fail("deformation " + std::to_string(i + 1) + " is rigid, its numbers must be 0");
    }
  }
}

void require_semidefinite(const YamlReader& value, const Eigen::MatrixXd& matrix,
                          const std::string& what) {
  if ((matrix - matrix.transpose()).cwiseAbs().maxCoeff() > 0) {
    value.fail("the " + what + " matrix is not symmetric");
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(matrix, Eigen::EigenvaluesOnly);
  const double smallest = solver.eigenvalues()(0);
  // 1e-12 of the largest entry is far above the rounding of a semidefinite one.
  if (smallest < -1e-12 * matrix.cwiseAbs().maxCoeff()) {
    value.fail("the " + what + " matrix is indefinite: its smallest eigenvalue is " +
               shown(smallest));
  }
}

}  // namespace

void set_deformations(SceneElement& element, Eigen::Index n) {
  element.n_deformations = n;
  element.zero.assign(static_cast<size_t>(n), false);
  element.stiffness.setZero(n, n);
  element.damping.setZero(n, n);
  element.preload.setZero(n);
}

std::vector<bool> read_rigid(const YamlReader& value, const SceneElement& element) {
  const auto n = static_cast<size_t>(element.n_deformations);
  if (value.is_scalar()) return std::vector<bool>(n, value.boolean());
  std::vector<bool> zero(n, false);
  for (const YamlReader& item : value.items()) {
    const auto number = static_cast<size_t>(item.integer(1));
    if (number > n) item.fail("found " + item.text() + ", allowed is 1 to " + std::to_string(n));
    if (zero[number - 1]) item.fail("deformation " + item.text() + " is named twice");
    zero[number - 1] = true;
  }
  return zero;
}

Eigen::MatrixXd read_symmetric(const YamlReader& value, const SceneElement& element,
                               const std::string& what) {
  const Eigen::Index n = element.n_deformations;
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(n, n);
  if (value.is_scalar()) {
    const Eigen::Index i = only_elastic(value, element);
    matrix(i, i) = value.non_negative();
    return matrix;
  }
  const auto items = value.items();
  if (!items.empty() && items.front().is_sequence()) {
    matrix = value.matrix(n, n);
  } else {
    matrix = value.vector(n).asDiagonal();
  }
  require_semidefinite(value, matrix, what);
  refuse_rigid_entries(value, element, matrix);
  return matrix;
}

Eigen::VectorXd read_preload(const YamlReader& value, const SceneElement& element) {
  Eigen::VectorXd preload = Eigen::VectorXd::Zero(element.n_deformations);
  if (value.is_scalar()) {
    preload(only_elastic(value, element)) = value.number();
    return preload;
  }
  preload = value.vector(element.n_deformations);
  refuse_rigid_entries(value, element, preload);
  return preload;
}

}  // namespace stillframe

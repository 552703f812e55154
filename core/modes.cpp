#include "core/modes.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <iterator>
#include <numbers>
#include <vector>

#include "core/state_space.hpp"
#include "core/yaml/input_error.hpp"

namespace stillframe {

namespace {

/// Real matrices have exact conjugates; each stands behind its own, also where moduli are equal.
Eigen::VectorXcd sorted_eigenvalues(const Eigen::MatrixXd& A) {
  const Eigen::VectorXcd values = A.eigenvalues();
  std::vector<std::complex<double>> upper;
  std::copy_if(values.begin(), values.end(), std::back_inserter(upper),
               [](const auto& value) { return value.imag() >= 0; });
  std::stable_sort(upper.begin(), upper.end(),
                   [](const auto& a, const auto& b) { return std::abs(a) < std::abs(b); });
  Eigen::VectorXcd sorted = Eigen::VectorXcd::Zero(values.size());
  Index next = 0;
  for (const std::complex<double>& value : upper) {
    sorted(next++) = value;
    if (value.imag() > 0) sorted(next++) = std::conj(value);
  }
  return sorted;
}

}  // namespace

Modes modes(const LinearModel& model) {
  const Index n = model.M.rows();
  const Eigen::MatrixXd K = model.stiffness();
  if (Eigen::LLT<Eigen::MatrixXd>(model.M).info() != Eigen::Success) {
    throw Refusal("the mass matrix is not positive definite: a dof moves no mass");
  }
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(0.5 * (K + K.transpose()),
                                                                         model.M);
  Modes result;
  result.shapes = solver.eigenvectors();
  result.natural_frequencies_hz.resize(n);
  const double largest = solver.eigenvalues().cwiseAbs().maxCoeff();
  for (Index i = 0; i < n; ++i) {
    const double square = solver.eigenvalues()(i);
    // A rigid-body mode has omega^2 = 0 up to rounding of the largest one.
    if (square < -1e-10 * largest) {
      throw Refusal("the configuration is not stable: omega^2 = " + std::to_string(square) +
                    " (rad/s)^2 in mode " + std::to_string(i + 1));
    }
    result.natural_frequencies_hz(i) = std::sqrt(std::max(square, 0.0)) / (2 * std::numbers::pi);
  }
  result.eigenvalues = sorted_eigenvalues(state_matrix(model));
  result.damping_ratios.resize(n);
  for (Index i = 0; i < n; ++i) {
    const std::complex<double> value = result.eigenvalues(2 * i);
    result.damping_ratios(i) = std::abs(value) > 0 ? -value.real() / std::abs(value) : 0.0;
  }
  return result;
}

}  // namespace stillframe

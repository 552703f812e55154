#include "core/modes.hpp"

#include <algorithm>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "core/state_space.hpp"
#include "core/yaml/input_error.hpp"

namespace stillframe {

namespace {

Eigen::VectorXcd sorted_eigenvalues(const Eigen::MatrixXd& A) {
  Eigen::VectorXcd values = A.eigenvalues();
  std::sort(values.begin(), values.end(), [](const auto& a, const auto& b) {
    // Conjugates have equal moduli only up to rounding; a bound of 1e-12 keeps a pair together.
    const double difference = std::abs(a) - std::abs(b);
    if (std::abs(difference) > 1e-12 * std::abs(a)) return difference < 0;
    return a.imag() > b.imag();
  });
  return values;
}

}  // namespace

Modes modes(const LinearModel& model) {
  const Index n = model.M.rows();
  const Eigen::MatrixXd K = model.K + model.G;
  if (Eigen::LLT<Eigen::MatrixXd>(model.M).info() != Eigen::Success) {
    throw Refusal("the mass matrix is not positive definite: a dof moves no mass");
  }
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(0.5 * (K + K.transpose()), model.M);
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

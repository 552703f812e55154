#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>
#include <random>

#include "core/numerics/worst.hpp"
#include "core/systems/noise_power.hpp"

namespace stillframe {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd random_matrix(Index rows, Index cols, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  MatrixXd matrix(rows, cols);
  for (double& value : matrix.reshaped()) value = normal(random);
  return matrix;
}

/// Four states, the largest eigenvalue of this modulus; two inputs, three outputs.
LinearSystem random_system(unsigned seed, double radius) {
  MatrixXd A = random_matrix(4, 4, seed);
  const double largest = A.eigenvalues().cwiseAbs().maxCoeff();
  A *= radius / largest;
  return {.A = A,
          .B = random_matrix(4, 2, seed + 100),
          .C = random_matrix(3, 4, seed + 200),
          .D = random_matrix(3, 2, seed + 300)};
}

/// The covariance of (x, v), sample by sample.
VectorXd summed(const LinearSystem& system, const NoiseProcess& process, Index n) {
  const Index states = system.A.rows(), p = system.B.cols();
  MatrixXd A = MatrixXd::Zero(states + p, states + p), P = A, C(system.C.rows(), states + p);
  A.topLeftCorner(states, states) = system.A;
  A.topRightCorner(states, p) = system.B;
  A.bottomRightCorner(p, p).diagonal().setConstant(process.kept);
  C << system.C, system.D;
  P.bottomRightCorner(p, p).diagonal().setConstant(process.first * process.first);
  VectorXd sum = VectorXd::Zero(C.rows());
  for (Index k = 0; k < n; ++k) {
    sum += (C * P * C.transpose()).diagonal();
    P = (A * P * A.transpose()).eval();
    P.bottomRightCorner(p, p).diagonal().array() += process.fresh * process.fresh;
  }
  return sum / static_cast<double>(n);
}

// Doubling loses no more digits than adding up, some n eps.
TEST(NoisePower, TheMeanSquareIsThatOfTheCovarianceOfEverySample) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const LinearSystem system = random_system(seed, 1 - std::pow(10, -1.0 - seed % 4));
    const NoiseProcess walk{.kept = 1, .fresh = 0.1, .first = 0};
    for (const NoiseProcess& process :
         {NoiseProcess::white(0.3), NoiseProcess::stationary(0.97, 4), walk}) {
      for (const Index n : {1, 2, 3, 100, 1237}) {
        const VectorXd expected = summed(system, process, n);
        const VectorXd error = mean_square_over(system, process, n) - expected;
        EXPECT_LE(worst_of(error), 1e-10 * expected.maxCoeff()) << seed << " " << n;
      }
    }
  }
}

// Two ways to one number: all cells together are what is left of a long run's mean square. Poles of
// a modulus of 0.9999 have resonances of 1e-4 of the band. Each part is integrated to 1e-6.
TEST(NoisePower, CellsAddUpToWhatALongRunHas) {
  constexpr double sample_time = 1e-3;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    const LinearSystem system = random_system(seed, 1 - std::pow(10, -1.0 - seed % 4));
    const NoiseProcess process = NoiseProcess::stationary(seed % 2 == 0 ? 0.0 : 0.9, 2);
    const VectorXd edges = (VectorXd(6) << 0, 0.3, 7, 60, 200, 500).finished();
    const NoisePower cells = noise_power(system, {{process}}, sample_time, edges)[0];
    // The mean over 2n and over n samples: the second half, in which nothing is left of the start.
    const std::int64_t n = 400'000;
    const VectorXd stationary =
        2 * mean_square_over(system, process, 2 * n) - mean_square_over(system, process, n);
    const VectorXd error = cells.power.rowwise().sum() - stationary;
    EXPECT_LT(worst_of(error), 1e-5 * stationary.maxCoeff()) << seed;
    for (Index i = 1; i < cells.power.cols(); ++i) {
      for (Index j = 0; j < cells.power.rows(); ++j) {
        const double two_pi = 2 * std::numbers::pi, power = cells.power(j, i);
        const double low = std::pow(two_pi * edges(i), 2),
                     high = std::pow(two_pi * edges(i + 1), 2);
        EXPECT_GT(cells.integrated(j, i), power / high * (1 - 1e-5));
        EXPECT_LT(cells.integrated(j, i), power / low * (1 + 1e-5));
      }
    }
  }
}

TEST(NoisePower, ADensityIsTheVarianceOverItsBand) {
  // sum over [0, 1 / 2T] of 2 T fresh^2 / |z - kept|^2 is fresh^2 / (1 - kept^2).
  const NoiseProcess process = NoiseProcess::stationary(0.8, 3);
  constexpr double sample_time = 0.01;
  double sum = 0;
  constexpr int n = 20'000;
  for (int i = 0; i < n; ++i) sum += process.density((i + 0.5) * 50 / n, sample_time) * 50 / n;
  // The rule of the middle on a smooth function of a whole period: exact to rounding.
  EXPECT_NEAR(sum, 3, 1e-10);
  EXPECT_DOUBLE_EQ(process.fresh * process.fresh / (1 - process.kept * process.kept), 3);
}

}  // namespace
}  // namespace stillframe

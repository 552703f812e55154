#include <gtest/gtest.h>

#include <cmath>

#include "core/numerics/phi_functions.hpp"
#include "core/numerics/worst.hpp"
#include "tests/core/element_cases.hpp"

namespace stillframe::test {
namespace {

/// phi_k of a number by its series in long double: 40 terms for |x| up to 5.
double phi_of(int k, double x) {
  long double term = 1, sum = 0;
  for (int i = 1; i <= k; ++i) term /= i;
  for (int j = 1; j <= 60; ++j) {
    sum += term;
    term *= static_cast<long double>(x) / (j + k);
  }
  return static_cast<double>(sum);
}

TEST(PhiFunctions, OfANumberAreTheirSeries) {
  for (const double x : {-5.0, -1.3, -1e-8, 0.0, 1e-3, 0.7, 4.9}) {
    const auto phi = phi_functions(Eigen::MatrixXd::Constant(1, 1, x), 3);
    for (int k = 0; k <= 3; ++k) {
      // Four doublings, each a few roundings, that double the phase; for negative x the sums cancel
      // by up to e^5, for positive ones the value itself is up to e^5.
      EXPECT_NEAR(phi[static_cast<size_t>(k)](0, 0), phi_of(k, x),
                  1e-15 * std::exp(std::abs(x)) + 1e-14)
          << k << " " << x;
    }
  }
}

TEST(PhiFunctions, KeepTheirRecurrence) {
  // phi_(k-1)(X) = X phi_k(X) + I / (k-1)!: what defines them, for a matrix of no special kind.
  Random random(11);
  const Eigen::MatrixXd X = 3 * random.vector(36).reshaped(6, 6);
  const auto phi = phi_functions(X, 3);
  const Eigen::MatrixXd I = Eigen::MatrixXd::Identity(6, 6);
  // Rounding of the largest entries, over some ten doublings.
  const double size = 1e-13 * worst_of(phi[0]);
  EXPECT_LT(worst_of(phi[0] - X * phi[1] - I), size);
  EXPECT_LT(worst_of(phi[1] - X * phi[2] - I), size);
  EXPECT_LT(worst_of(phi[2] - X * phi[3] - 0.5 * I), size);
}

TEST(PhiFunctions, OfAnOscillatorOfAnyStiffness) {
  // x'' = -omega^2 x + t^k / k!: the answer from rest is tau^(k+1) phi_(k+1) applied to (0, 1), in
  // closed form 1/omega^2 - cos / omega^2 for k = 0 and (tau - sin / omega) / omega^2 for k = 1.
  const double tau = 1e-3;
  for (const double omega : {1.0, 1e3, 1e6, 1e9}) {
    Eigen::Matrix2d A;
    A << 0, 1, -omega * omega, 0;
    const auto phi = phi_functions(tau * A, 2);
    const double s = std::sin(omega * tau), o2 = omega * omega;
    // Doubling m times squares the rounding of cos(omega tau / 2^m): the phase is good to
    // omega tau epsilon times a few.
    const double phase = std::max(1e-14, 20 * omega * tau * 1e-16);
    // 1 - cos without its cancellation; tau - sin by its series where that cancels.
    const double half = std::sin(omega * tau / 2), step = 2 * half * half / o2;
    EXPECT_NEAR(tau * phi[1](0, 1), step, phase * std::max(tau * tau, 1 / o2)) << omega;
    const double ramp = omega * tau < 1e-2 ? tau * tau * tau / 6 : (tau - s / omega) / o2;
    EXPECT_NEAR(tau * tau * phi[2](0, 1), ramp, phase * std::max(tau * tau * tau, tau / o2))
        << omega;
  }
}

TEST(DecayResponse, IsTheAnswerOfALowPassToALag) {
  // x' = -a x + b exp(-r t) from rest: b (exp(-r t) - exp(-a t)) / (a - r).
  const double a = 300, b = 7, tau = 2e-3;
  for (const double r : {10.0, 299.0, 2000.0, 1e6}) {
    const auto response = decay_response(Eigen::MatrixXd::Constant(1, 1, -a),
                                         Eigen::MatrixXd::Constant(1, 1, b), r, tau);
    const long double exact = static_cast<long double>(b) *
                              (std::exp(static_cast<long double>(-r * tau)) -
                               std::exp(static_cast<long double>(-a * tau))) /
                              (static_cast<long double>(a) - r);
    EXPECT_NEAR(response(0, 0), static_cast<double>(exact), 1e-13 * b / a) << r;
  }
}

TEST(PhiFunctions, RefuseWhatIsNoSquareOfNumbers) {
  EXPECT_THROW(phi_functions(Eigen::MatrixXd::Zero(2, 3), 1), std::invalid_argument);
  EXPECT_THROW(phi_functions(Eigen::MatrixXd::Constant(2, 2, NAN), 1), std::invalid_argument);
}

}  // namespace
}  // namespace stillframe::test

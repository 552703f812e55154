#include <gtest/gtest.h>

#include <cmath>

#include "plant_sim/integrator.hpp"

namespace stillframe {
namespace {

using Ref = Eigen::Ref<Eigen::VectorXd>;
using ConstRef = Eigen::Ref<const Eigen::VectorXd>;

/// x'' = -omega^2 x + a(k), a held over each sample and jumping at every one; closed form by the
/// rotation of (x - a / omega^2, v / omega).
struct Oscillator {
  double omega = 2 * M_PI * 49, a = 0;
  bool operator()(double, const ConstRef& y, Ref dy) const {
    dy(0) = y(1);
    dy(1) = -omega * omega * y(0) + a;
    return true;
  }
  Eigen::Vector2d exact(const Eigen::Vector2d& y, double t) const {
    const double c = std::cos(omega * t), s = std::sin(omega * t), x = y(0) - a / (omega * omega);
    return {a / (omega * omega) + c * x + s * y(1) / omega, -s * omega * x + c * y(1)};
  }
};

double error_after(double tolerance, double amplitude) {
  Oscillator oscillator;
  Integrator integrator(
      1, [&](double t, const ConstRef& y, Ref dy) { return oscillator(t, y, dy); }, tolerance);
  Eigen::VectorXd y = Eigen::VectorXd::Zero(2);
  Eigen::Vector2d exact = y;
  for (int k = 0; k < 1000; ++k) {
    oscillator.a = amplitude * (k % 7 - 3.0);
    EXPECT_EQ(integrator.advance(y, 1e-3, std::abs(oscillator.a), 1e-3), Integrator::Status::ok);
    exact = oscillator.exact(exact, 1e-3);
  }
  return (y - exact).norm() / exact.norm();
}

TEST(Integrator, ErrorShrinksWithTheTolerance) {
  // One second holds 1000 samples and each may err by the tolerance of its step; a factor of ten is
  // left for the growth of errors along 49 periods.
  for (const double tolerance : {1e-6, 1e-8, 1e-10, 1e-12}) {
    const double error = error_after(tolerance, 1.0);
    RecordProperty("error_at_" + std::to_string(tolerance), std::to_string(error));
    EXPECT_LT(error, 1e4 * tolerance) << tolerance;
  }
  EXPECT_LT(error_after(1e-12, 1.0), 1e-3 * error_after(1e-6, 1.0));
}

TEST(Integrator, DoesNotKnowTheSizeOfTheMotion) {
  // The tolerance is relative and the problem linear, so a picometre is integrated like a metre:
  // the same steps, up to rounding of the error norm.
  EXPECT_NEAR(error_after(1e-8, 1e-12) / error_after(1e-8, 1.0), 1.0, 1e-3);
}

TEST(Integrator, StaysAtRest) {
  Integrator integrator(
      1,
      [](double, const ConstRef& y, Ref dy) {
        dy << y(1), -y(0);
        return true;
      },
      1e-8);
  Eigen::VectorXd y = Eigen::VectorXd::Zero(2);
  ASSERT_EQ(integrator.advance(y, 1e-3, 0.0, 1e-3), Integrator::Status::ok);
  EXPECT_EQ(y.norm(), 0.0);
}

TEST(Integrator, ReportsAnEquationThatCannotBeEvaluated) {
  Integrator integrator(
      1,
      [](double t, const ConstRef&, Ref dy) {
        dy << 1, 1;
        return t < 5e-4;
      },
      1e-8);
  Eigen::VectorXd y = Eigen::VectorXd::Zero(2);
  EXPECT_NE(integrator.advance(y, 1e-3, 1.0, 1e-3), Integrator::Status::ok);
}

}  // namespace
}  // namespace stillframe

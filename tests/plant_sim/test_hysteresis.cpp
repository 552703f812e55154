#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/systems/bouc_wen.hpp"

// The closed form of the hysteresis against its differential equation and against what the data
// sheet asked for.
namespace stillframe {
namespace {

class BoucWenTest : public testing::TestWithParam<HysteresisLoop> {};

/// dh/dp along a path in the direction s.
double slope(const BoucWen& model, double h, double s) {
  return model.alpha * s - model.beta * h - model.gamma * s * std::abs(h);
}

/// h after f moved by so much, by the classical Runge-Kutta method.
double integrated(const BoucWen& model, double h, double by) {
  constexpr int n = 20'000;
  const double s = by < 0 ? -1 : 1, dp = std::abs(by) / n;
  for (int i = 0; i < n; ++i) {
    const double a = slope(model, h, s), b = slope(model, h + dp / 2 * a, s),
                 c = slope(model, h + dp / 2 * b, s), d = slope(model, h + dp * c, s);
    h += dp / 6 * (a + 2 * b + 2 * c + d);
  }
  return h;
}

/// Turning points of a path, N, the same on every machine.
std::vector<double> path(double size, int n) {
  std::mt19937 engine(11);
  std::vector<double> points;
  for (int i = 0; i < n; ++i) points.push_back(size * (engine() / 2147483648.0 - 1));
  return points;
}

TEST_P(BoucWenTest, SolvesItsDifferentialEquation) {
  const BoucWen model = bouc_wen(GetParam());
  const double tolerance = model.gamma == 0 ? 1e-12 : 1e-9;
  double f = 0, h = 0;
  for (const double to : path(1.5 * GetParam().swing_n, 40)) {
    const double closed = model.moved(h, to - f);
    // A step is 3e-4 of a saturation at most, which leaves 1e-14; where h crosses zero its second
    // derivative jumps by 2 gamma alpha, and the step there errs by the square of its length, 1e-7
    // times a part of that.
    EXPECT_NEAR(closed, integrated(model, h, to - f), tolerance * GetParam().saturation_n);
    h = closed;
    f = to;
  }
}

TEST_P(BoucWenTest, AsksNotHowFast) {
  const BoucWen model = bouc_wen(GetParam());
  double f = 0, whole = 0, parts = 0;
  for (const double to : path(1.5 * GetParam().swing_n, 40)) {
    whole = model.moved(whole, to - f);
    for (int i = 0; i < 7; ++i) parts = model.moved(parts, (to - f) / 7);
    f = to;
    // Rounding of seven parts, forgotten over one saturation.
    EXPECT_NEAR(parts, whole, 1e-14 * GetParam().saturation_n);
  }
}

TEST_P(BoucWenTest, OpensAsTheDataSheetSays) {
  const HysteresisLoop& loop = GetParam();
  const BoucWen model = bouc_wen(loop);
  constexpr int n = 1000;  // even
  const double F = loop.swing_n, df = 2 * F / n;
  double h = 0;
  std::vector<double> up(n + 1), down(n + 1);
  // Until it has closed: a loop forgets at least exp(-2 F / saturation) of where it began.
  const int turns = 3 + static_cast<int>(20 * loop.saturation_n / F);
  h = model.moved(h, -F);
  for (int turn = 0; turn < turns; ++turn) {
    for (int i = 0; i <= n; ++i) {
      up[static_cast<size_t>(i)] = model.kappa * (-F + i * df) - h;
      if (i < n) h = model.moved(h, df);
    }
    for (int i = n; i >= 0; --i) {
      down[static_cast<size_t>(i)] = model.kappa * (-F + i * df) - h;
      if (i > 0) h = model.moved(h, -df);
    }
  }
  // Rounding of 1000 parts. Its ends are on the line of a linear actuator ...
  EXPECT_NEAR(up[n], F, 1e-12 * F);
  EXPECT_NEAR(up[0], -F, 1e-12 * F);
  // ... and it opens by the width of its range, in the middle; the way down lies above.
  size_t widest = 0;
  double work = 0;
  for (size_t i = 0; i <= n; ++i) {
    if (down[i] - up[i] > down[widest] - up[widest]) widest = i;
    work += (down[i] - up[i]) * df;
    if (i > 0) {
      EXPECT_GT(up[i], up[i - 1]);
      EXPECT_GT(down[i], down[i - 1]);
    }
  }
  EXPECT_EQ(widest, static_cast<size_t>(n / 2));
  EXPECT_NEAR(down[n / 2] - up[n / 2], loop.width * 2 * F, 1e-12 * F);
  EXPECT_GT(work, 0);
  // Where it has just turned: one part of a thousand bends by less than two of them.
  const double least = model.least_slope(F);
  EXPECT_NEAR((down[n] - down[n - 1]) / df, least, 2 * df / loop.saturation_n);
  EXPECT_LT(least, (down[n] - down[n - 1]) / df);
}

TEST_P(BoucWenTest, LosesNothingOfSmallMotion) {
  const BoucWen model = bouc_wen(GetParam());
  const double tiny = 1e-12 * GetParam().saturation_n;
  // 1e-12 is by how much a branch bends over such a path.
  EXPECT_NEAR(model.moved(0, tiny) / (model.alpha * tiny), 1, 1e-11);
  EXPECT_NEAR(model.moved(0, -tiny) / (-model.alpha * tiny), 1, 1e-11);
}

INSTANTIATE_TEST_SUITE_P(
    Loops, BoucWenTest,
    testing::Values(
        HysteresisLoop{.width = 0.1, .swing_n = 100, .saturation_n = 100},
        HysteresisLoop{.width = 0.15, .swing_n = 100, .saturation_n = 1000},
        HysteresisLoop{.width = 0.02, .swing_n = 100, .saturation_n = 10},
        HysteresisLoop{.width = 0.1, .swing_n = 7, .saturation_n = 9, .gamma_over_beta = 1},
        HysteresisLoop{.width = 0.1, .swing_n = 7, .saturation_n = 9, .gamma_over_beta = 0.4},
        HysteresisLoop{.width = 0.1, .swing_n = 7, .saturation_n = 9, .gamma_over_beta = -0.6}));

}  // namespace
}  // namespace stillframe

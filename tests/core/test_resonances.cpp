#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <vector>

#include "core/mechanics/frequency_response.hpp"
#include "core/systems/resonances.hpp"

namespace stillframe::test {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Complex = std::complex<double>;

constexpr double omega = 2 * M_PI * 17.3;

/// omega^2 / (s^2 + 2 zeta omega s + omega^2): at its peak 1 / (2 zeta sqrt(1 - zeta^2)). With
/// `seen` 0 its motion reaches no output.
LinearSystem oscillator(double zeta, double seen = 1) {
  MatrixXd A(2, 2), B(2, 1), C(1, 2), D(1, 1);
  A << 0, omega, -omega, -2 * zeta * omega;
  B << 0, omega;
  C << seen, 0;
  D << 1 - seen;
  return {A, B, C, D};
}

double peak_of(double zeta) { return 1 / (2 * zeta * std::sqrt(1 - zeta * zeta)); }

double decibels(double ratio) { return 20 * std::log10(ratio); }

double highest_on(const VectorXd& grid_hz, LargestGain& gain) {
  double highest = 0;
  for (const double hz : grid_hz) highest = std::max(highest, gain(hz));
  return highest;
}

/// Some of them side by side; each has its own state, input and output of its own.
struct Oscillator {
  double omega, zeta;
};

LinearSystem side_by_side(const std::vector<Oscillator>& all) {
  const auto n = std::ssize(all);
  LinearSystem out{MatrixXd::Zero(2 * n, 2 * n), MatrixXd::Zero(2 * n, n), MatrixXd::Zero(n, 2 * n),
                   MatrixXd::Zero(n, n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto [w, zeta] = all[static_cast<size_t>(i)];
    out.A.block(2 * i, 2 * i, 2, 2) << 0, w, -w, -2 * zeta * w;
    out.B(2 * i + 1, i) = w;
    out.C(i, 2 * i) = 1;
  }
  return out;
}

TEST(Resonances, ACurveShowsThePeakThatItsGridMisses) {
  const VectorXd grid = logarithmic_frequencies(1, 100, 21);
  for (const double zeta : {1e-2, 1e-3, 1e-6}) {
    LargestGain gain(oscillator(zeta), 1);
    ASSERT_EQ(gain.resonances().size(), 1u);
    // A pole next to the imaginary axis is known to epsilon of its modulus.
    const double width = zeta * omega / (2 * M_PI);
    EXPECT_NEAR(gain.resonances()[0].half_width_hz, width, 1e-13);
    const double missed = decibels(peak_of(zeta) / highest_on(grid, gain));
    EXPECT_GT(missed, 10) << zeta;
    const VectorXd fine = with_resonances(grid, gain.resonances());
    // An eighth of the half-width beside the peak: 10 log10(1 + 1 / 64) = 0.067 dB.
    EXPECT_NEAR(decibels(highest_on(fine, gain) / peak_of(zeta)), 0, 0.07) << zeta;
    EXPECT_LT(fine.size(), 120) << zeta;
    for (Eigen::Index i = 1; i < fine.size(); ++i) ASSERT_GT(fine(i), fine(i - 1));
  }
}

// One point at the peak would be a spike in the picture: the line that is drawn through the points
// is the curve.
TEST(Resonances, ACurveIsDrawnBesideThePeakToo) {
  for (const double zeta : {1e-2, 1e-3, 1e-6}) {
    LargestGain gain(oscillator(zeta), 1);
    const double hz = omega / (2 * M_PI);
    const VectorXd fine = with_resonances(logarithmic_frequencies(1, 100, 21), gain.resonances());
    int n_beside = 0;
    for (Eigen::Index i = 0; i + 1 < fine.size(); ++i) {
      const double a = fine(i), b = fine(i + 1);
      if (a < hz * (1 - 10 * zeta) || b > hz * (1 + 10 * zeta)) continue;
      ++n_beside;
      // 1.6 times as far from the pole the response is 4.1 dB lower, and half-way 0.24 dB lower
      // than the line.
      EXPECT_LT(std::abs(decibels(gain(b) / gain(a))), 4.1) << zeta << " " << a;
      EXPECT_LT(std::abs(decibels(gain(std::sqrt(a * b)) / std::sqrt(gain(a) * gain(b)))), 0.25)
          << zeta << " " << a;
    }
    EXPECT_GT(n_beside, 10) << zeta;
  }
}

// The sum of two whose poles are half a half-width apart is highest between them. At either pole it
// is 0.18 dB lower.
TEST(Resonances, APeakBetweenTwoPolesIsShown) {
  constexpr double zeta = 1e-3;
  LinearSystem both =
      side_by_side({{omega * (1 - zeta / 4), zeta}, {omega * (1 + zeta / 4), zeta}});
  both.B = both.B.rowwise().sum().eval();
  both.C = both.C.colwise().sum().eval();
  both.D = MatrixXd::Zero(1, 1);
  LargestGain gain(both, 1);
  const VectorXd grid = logarithmic_frequencies(1, 100, 21);
  // Of 1 / (1 + j x) + 1 / (1 - j x), x = 1/4, to zeta.
  const double peak = 1 / zeta / (1 + 1.0 / 16);
  EXPECT_NEAR(decibels(highest_on(with_resonances(grid, gain.resonances()), gain) / peak), 0, 0.07);
}

// A resonance as wide as a tenth or a quarter of its frequency falls between the rows of a grid
// that is coarser than any picture's.
TEST(Resonances, WideOnesAreShownOnACoarseGrid) {
  const VectorXd grid{{1, 10, 100}};
  for (const double zeta : {0.1, 0.25}) {
    LargestGain gain(oscillator(zeta), 1);
    EXPECT_GT(decibels(peak_of(zeta) / highest_on(grid, gain)), 2) << zeta;
    const VectorXd fine = with_resonances(grid, gain.resonances());
    EXPECT_NEAR(decibels(highest_on(fine, gain) / peak_of(zeta)), 0, 0.07) << zeta;
  }
}

// Two that do not know of each other: 1 / (2 zeta) of the one and 1.45 of the other; and an input
// that was not asked for, a hundred times as strong.
TEST(Resonances, TheGainIsTheLargestOfTheInputsAskedFor) {
  LinearSystem both = side_by_side({{omega, 1e-3}, {2 * M_PI * 31, 1e-3}});
  both.B.conservativeResize(4, 3);
  both.B.col(2) = 100 * both.B.col(0);
  both.D = MatrixXd::Zero(2, 3);
  LargestGain gain(both, 2);
  // A thousandfold loss beside the pole leaves twelve digits.
  EXPECT_NEAR(gain(omega / (2 * M_PI)), 500, 500e-12);
}

TEST(Resonances, ASampledLoopHasThemAtTheAnglesOfItsPoles) {
  // The oscillator at instants T apart, and its response in closed form.
  constexpr double zeta = 1e-3, T = 1e-3;
  const Complex z = std::exp(omega * T * Complex(-zeta, std::sqrt(1 - zeta * zeta)));
  SampledLoop loop;
  loop.A = MatrixXd(2, 2);
  loop.A << z.real(), z.imag(), -z.imag(), z.real();
  loop.B = MatrixXd::Identity(2, 1);
  loop.C = MatrixXd::Identity(1, 2);
  loop.D = MatrixXd::Zero(1, 1);
  loop.sample_time = T;
  LargestGain gain(loop);
  ASSERT_EQ(gain.resonances().size(), 1u);
  EXPECT_NEAR(gain.resonances()[0].hz, std::arg(z) / (2 * M_PI * T), 1e-9);
  const VectorXd grid = logarithmic_frequencies(1, 400, 20);
  const Complex e = std::polar(1.0, std::arg(z));
  const double there = std::abs((e - z.real()) / ((e - z) * (e - std::conj(z))));
  EXPECT_NEAR(decibels(highest_on(with_resonances(grid, gain.resonances()), gain) / there), 0,
              0.07);
}

TEST(Resonances, ATableHasARowWhereItsOwnMissAPeak) {
  const VectorXd rows{{1, 2, 5, 10, 20, 50}};
  for (const double zeta : {0.1, 1e-3, 1e-7}) {
    LargestGain gain(oscillator(zeta), 1);
    const auto peaks = peaks_between(rows, gain);
    ASSERT_EQ(peaks.size(), 1u) << zeta;
    // 24 golden sections, and the rounding of s + j omega beside a pole of 1e-7 omega.
    EXPECT_NEAR(peaks[0].value / peak_of(zeta), 1, 1e-6) << zeta;
    const double at = omega * std::sqrt(1 - 2 * zeta * zeta) / (2 * M_PI);
    EXPECT_NEAR(peaks[0].hz, at, 1e-3 * zeta * at + 1e-9 * at) << zeta;
  }
  // sqrt(2) / 2 has no peak, and what reaches no output none either.
  LargestGain flat(oscillator(std::sqrt(0.5)), 1), hidden(oscillator(1e-3, 0), 1);
  EXPECT_TRUE(peaks_between(rows, flat).empty());
  EXPECT_TRUE(peaks_between(rows, hidden).empty());
}

TEST(Resonances, WhatNothingDampsHasNoBoundWhereItIsSeen) {
  const VectorXd rows{{1, 2, 5, 10, 20, 50}};
  LargestGain undamped(oscillator(0), 1), hidden(oscillator(0, 0), 1);
  const auto peaks = peaks_between(rows, undamped);
  ASSERT_EQ(peaks.size(), 1u);
  EXPECT_NEAR(peaks[0].hz, omega / (2 * M_PI), 1e-9);
  EXPECT_TRUE(std::isinf(peaks[0].value));
  EXPECT_TRUE(peaks_between(rows, hidden).empty());
  // A picture keeps off the pole itself, where rounding alone would say how high it is.
  for (const double hz : with_resonances(rows, undamped.resonances())) {
    EXPECT_GT(std::abs(hz / peaks[0].hz - 1), 1e-4) << hz;
    EXPECT_LT(undamped(hz), 1e4) << hz;
  }
}

}  // namespace
}  // namespace stillframe::test

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/numerics/smooth_step.hpp"
#include "report/spectra/running_power.hpp"

// How much a signal holds beside its ends, which bounds what they leave in a band, and how long the
// windows are that short records are cut with.
namespace stillframe::report {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double rate = 500, tone_hz = 20;
constexpr Index second = 500;

/// A tone whose mean square is 1, 0.3 rad on, that fades over `in` s at its beginning and `out` s
/// at its end.
VectorXd tone(Index n, double in, double out) {
  return VectorXd::NullaryExpr(n, [=](Index k) {
    const double t = static_cast<double>(k) / rate, left = static_cast<double>(n - k) / rate;
    const double up = in > 0 ? smooth_step(std::min(1.0, t / in)) : 1;
    const double down = out > 0 ? smooth_step(std::min(1.0, left / out)) : 1;
    return std::numbers::sqrt2 * up * down * std::sin(2 * std::numbers::pi * tone_hz * t + 0.3);
  });
}

// The mean squares beside an end are over two seconds, 40 periods of the tone, and what is
// forgotten by and by keeps 1 / (4 pi 40) of the ripple, 0.2 %. Fades over 80 s leave less.
constexpr double ripple = 0.005;

TEST(RunningPower, OneEndCountsAsOne) {
  EXPECT_NEAR(power_of(tone(200 * second, 80, 0), rate).ends, 1, ripple);
  EXPECT_NEAR(power_of(tone(200 * second, 0, 80), rate).ends, 1, ripple);
  EXPECT_NEAR(power_of(tone(200 * second, 0, 0), rate).ends, 2, ripple);
  EXPECT_NEAR(power_of(tone(200 * second, 80, 80), rate).ends, 0, ripple);
}

TEST(RunningPower, AnEndIsTwoPeriodsOfTheLowestFrequency) {
  // Loud for the first of the two seconds.
  VectorXd x = VectorXd::Zero(200 * second);
  x.head(second) = tone(second, 0, 0);
  EXPECT_NEAR(power_of(x, rate).ends, 0.5, ripple);
  // Twice the frequency, half the time.
  EXPECT_NEAR(power_of(x, rate, 2).ends, 1, ripple);
}

TEST(RunningPower, EveryStretchHasEndsOfItsOwn) {
  RunningPower power(rate);
  power.add(tone(200 * second, 0, 0));
  power.skip(3 * second);
  // Of a stretch that is shorter than what is beside an end, all of it.
  power.add(tone(second, 0, 0));
  EXPECT_NEAR(power.finish().ends, 4, 2 * ripple);
  power.skip(3 * second);
  // Nothing at its ends, and nothing of those before.
  power.add(tone(200 * second, 80, 80));
  EXPECT_NEAR(power.finish().ends, 4, 3 * ripple);
}

// A bin is no wider than a 24th of the lowest frequency, so that an edge there is known to three
// bins, an eighth, however short the record and whether or not its length is known before.
TEST(RunningPower, EdgesOfShortRecordsAreKnownToAnEighth) {
  for (const double lowest_hz : {1.0, 4.0}) {
    for (const Index periods : {1, 10, 23}) {
      const auto n = static_cast<Index>(static_cast<double>(periods) * rate / lowest_hz);
      for (const Index expected : {Index{0}, n}) {
        RunningPower power(rate, lowest_hz, expected);
        power.add(tone(n, 0, 0));
        const Psd psd = power.finish();
        EXPECT_LE(psd.resolution_hz, lowest_hz / 24) << periods << " " << expected;
        // No longer than a length that transforms are fast for makes it: memory.
        EXPECT_GE(psd.resolution_hz, lowest_hz / 24 / 1.25) << periods << " " << expected;
      }
    }
  }
}

}  // namespace
}  // namespace stillframe::report

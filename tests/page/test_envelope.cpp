#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "report/page/envelope.hpp"
#include "report/page/thin_spectrum.hpp"
#include "tests/page/envelope_of.hpp"

namespace stillframe::page {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

const double nan = std::nan("");

VectorXd noise(Index n, unsigned seed = 3) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal(0.3, 2);
  VectorXd x(n);
  for (double& value : x) value = normal(generator);
  return x;
}

/// Every part holds the exact extremes of its samples, as floats that enclose them by one rounding
/// (2^-23 of the value).
void expect_encloses(const Envelope& envelope, const VectorXd& x) {
  ASSERT_EQ(envelope.n_samples, x.size());
  const auto n_parts = static_cast<std::int64_t>(envelope.lower.size());
  ASSERT_EQ(n_parts, (x.size() + envelope.part_samples - 1) / envelope.part_samples);
  for (std::int64_t i = 0; i < n_parts; ++i) {
    const Index first = i * envelope.part_samples;
    const VectorXd part =
        x.segment(first, std::min<Index>(envelope.part_samples, x.size() - first));
    const auto k = static_cast<std::size_t>(i);
    EXPECT_LE(envelope.lower[k], part.minCoeff());
    EXPECT_GE(envelope.upper[k], part.maxCoeff());
    EXPECT_NEAR(envelope.lower[k], part.minCoeff(), std::abs(part.minCoeff()) * 0x1p-23);
    EXPECT_NEAR(envelope.upper[k], part.maxCoeff(), std::abs(part.maxCoeff()) * 0x1p-23);
  }
  EXPECT_EQ(envelope.smallest, x.minCoeff());
  EXPECT_EQ(envelope.largest, x.maxCoeff());
}

TEST(Envelope, EnclosesSignalsOfAnyLength) {
  for (const Index n : {1, 7, 8, 9, 15, 16, 17, 31, 33, 1000, 1025}) {
    SCOPED_TRACE(n);
    const VectorXd x = noise(n);
    const Envelope envelope = envelope_of(x, 1000, 0, 8);
    expect_encloses(envelope, x);
    EXPECT_LE(envelope.lower.size(), 8u);
    EXPECT_GE(envelope.lower.size(), n >= 8 ? 5u : 1u);
  }
}

TEST(Envelope, KeepsSamplesThatFit) {
  const VectorXd x = noise(8);
  const Envelope envelope = envelope_of(x, 500, 2, 8);
  EXPECT_EQ(envelope.part_samples, 1);
  EXPECT_EQ(envelope.first_time_s, 2);
  EXPECT_EQ(envelope.sample_time_s, 1.0 / 500);
  expect_encloses(envelope, x);
}

TEST(Envelope, FinishCanBeAskedBetween) {
  const VectorXd x = noise(200);
  EnvelopeBuilder builder(1e-3, 0, 16);
  for (Index n = 1; n <= x.size(); ++n) {
    builder.add(x(n - 1));
    expect_encloses(builder.finish(), x.head(n));
  }
}

TEST(Envelope, OnePeakInAnHourIsThere) {
  EnvelopeBuilder builder(1e-3);
  const std::int64_t n = 3'600'000, place = 2'222'222;
  for (std::int64_t i = 0; i < n; ++i) builder.add(i == place ? 7.5 : 0.0);
  const Envelope envelope = builder.finish();
  EXPECT_LE(envelope.lower.size(), EnvelopeBuilder::default_parts);
  const auto part = static_cast<std::size_t>(place / envelope.part_samples);
  for (std::size_t i = 0; i < envelope.upper.size(); ++i) {
    EXPECT_EQ(envelope.upper[i], i == part ? 7.5f : 0.0f);
  }
}

TEST(Envelope, MissingSamplesAreGapsAndHideNothing) {
  VectorXd x = noise(64);
  EnvelopeBuilder with_skip(1, 0, 16), with_nan(1, 0, 16);
  with_skip.add(x.head(10));
  with_skip.skip(30);
  with_skip.add(x.tail(24));
  x.segment(10, 30).setConstant(nan);
  with_nan.add(x);
  const Envelope a = with_skip.finish(), b = with_nan.finish();
  ASSERT_EQ(a.lower.size(), 16u);
  for (std::size_t i = 0; i < 16; ++i) {
    const bool gap = i >= 3 && i < 10;  // parts of 4 samples: 12 to 39 are missing altogether
    EXPECT_EQ(std::isnan(a.lower[i]), gap) << i;
    EXPECT_EQ(std::isnan(b.upper[i]), gap) << i;
    if (!gap) {
      EXPECT_EQ(a.lower[i], b.lower[i]);
    }
  }
  EXPECT_LE(a.upper[2], 100);
  EXPECT_GE(a.upper[2], x.segment(8, 2).maxCoeff());
}

TEST(Envelope, OfNothingFiniteIsAllGaps) {
  const Envelope envelope = envelope_of(VectorXd::Constant(5, nan), 10);
  EXPECT_TRUE(std::isnan(envelope.smallest));
  const QuantisedEnvelope codes = quantise(envelope);
  for (const auto code : codes.lower) EXPECT_EQ(code, QuantisedEnvelope::absent_code);
}

TEST(Envelope, HalvedIsWhatCoarserPartsGive) {
  const VectorXd x = noise(999);
  const Envelope fine = envelope_of(x, 1000, 0, 512), coarse = halved(fine);
  EXPECT_EQ(coarse.part_samples, 2 * fine.part_samples);
  expect_encloses(coarse, x);
}

TEST(Envelope, RefusesWhatCannotBe) {
  EXPECT_THROW(EnvelopeBuilder{0}, std::invalid_argument);
  EXPECT_THROW(EnvelopeBuilder{nan}, std::invalid_argument);
  EXPECT_THROW((void)EnvelopeBuilder(1, 0, 7), std::invalid_argument);
  EXPECT_THROW((void)EnvelopeBuilder(1, 0, 0), std::invalid_argument);
}

/// The documented bound: below one step, outwards; half a step for samples.
TEST(Quantise, ErrorIsBelowOneStepAndOutwards) {
  for (const double scale : {1e-9, 1.0, 3e5}) {
    const VectorXd x = scale * noise(5000);
    for (const std::size_t parts : {1000u, 8192u}) {
      const Envelope envelope = envelope_of(x, 1000, 0, parts);
      const QuantisedEnvelope codes = quantise(envelope);
      const double range = x.maxCoeff() - x.minCoeff(), step = range / 65532;
      EXPECT_NEAR(codes.step, step, 1e-12 * step);
      // Values come as floats, off by 2^-24 of themselves.
      const double rounding = x.cwiseAbs().maxCoeff() * 0x1p-23;
      for (std::size_t i = 0; i < envelope.lower.size(); ++i) {
        const double low = codes.origin + codes.step * codes.lower[i];
        if (envelope.part_samples == 1) {
          EXPECT_LE(std::abs(low - x(static_cast<Index>(i))), step / 2 + rounding);
          continue;
        }
        const double high = codes.origin + codes.step * codes.upper[i];
        // 1e-9 of a step: rounding of origin + step * code itself.
        EXPECT_LE(low, envelope.lower[i] + 1e-9 * step);
        EXPECT_GT(low, envelope.lower[i] - step * (1 + 1e-9));
        EXPECT_GE(high, envelope.upper[i] - 1e-9 * step);
        EXPECT_LT(high, envelope.upper[i] + step * (1 + 1e-9));
      }
      EXPECT_EQ(codes.upper.empty(), envelope.part_samples == 1);
    }
  }
}

TEST(Quantise, ConstantSignalIsExact) {
  const QuantisedEnvelope codes = quantise(envelope_of(VectorXd::Constant(50, 0.25), 10, 0, 8));
  EXPECT_EQ(codes.origin, 0.25);
  EXPECT_EQ(codes.step, 0);
  for (const auto code : codes.lower) EXPECT_EQ(code, 0);
}

TEST(Quantise, LargestNumbersDoNotOverflow) {
  VectorXd x(2);
  x << -1e308, 1e308;
  const QuantisedEnvelope codes = quantise(envelope_of(x, 10));
  EXPECT_TRUE(std::isfinite(codes.step));
}

Curve spectrum(std::size_t n) {
  std::mt19937 generator(5);
  std::exponential_distribution<double> power(1);
  Curve curve{.name = "s", .frequencies_hz = {}, .values = {}};
  for (std::size_t k = 0; k < n; ++k) {
    curve.frequencies_hz.push_back(0.0625 * static_cast<double>(k));
    curve.values.push_back(power(generator));
  }
  return curve;
}

TEST(ThinSpectrum, KeepsEveryPeakOfItsStep) {
  const Curve all = spectrum(8001);
  const Curve thin = thin_spectrum(all, 500);
  EXPECT_LE(thin.frequencies_hz.size(), 1000u);
  EXPECT_TRUE(std::is_sorted(thin.frequencies_hz.begin(), thin.frequencies_hz.end()));
  EXPECT_EQ(*std::max_element(thin.values.begin(), thin.values.end()),
            *std::max_element(all.values.begin() + 1, all.values.end()));
  // Of any stretch of three steps, the largest value is kept.
  const double step = std::log(all.frequencies_hz.back() / all.frequencies_hz[1]) / 500;
  for (double f = 1; f < 400; f *= 1.37) {
    const auto largest = [&](const Curve& curve, double from, double to) {
      double value = 0;
      for (std::size_t i = 0; i < curve.values.size(); ++i) {
        const double at = curve.frequencies_hz[i];
        if (at >= from && at < to) value = std::max(value, curve.values[i]);
      }
      return value;
    };
    EXPECT_GE(largest(thin, f * std::exp(-step), f * std::exp(4 * step)),
              largest(all, f, f * std::exp(3 * step)));
  }
}

TEST(ThinSpectrum, LeavesShortOnesAloneButForZero) {
  const Curve thin = thin_spectrum(spectrum(100), 500);
  EXPECT_EQ(thin.frequencies_hz.size(), 99u);
  EXPECT_EQ(thin.frequencies_hz.front(), 0.0625);
  EXPECT_TRUE(thin_spectrum({}, 500).empty());
}

TEST(ThinSpectrum, CumulativeEndsWithTheWhole) {
  Curve all = spectrum(8001);
  for (std::size_t i = 1; i < all.values.size(); ++i) all.values[i] += all.values[i - 1];
  const Curve thin = thin_cumulative(all, 300);
  EXPECT_LE(thin.values.size(), 300u);
  EXPECT_EQ(thin.values.back(), all.values.back());
  EXPECT_TRUE(std::is_sorted(thin.values.begin(), thin.values.end()));
}

}  // namespace
}  // namespace stillframe::page

#include <gtest/gtest.h>

#include <random>

#include "core/control/robustness/tally.hpp"

namespace stillframe::robustness {
namespace {

using Eigen::VectorXd;
using Verdict = Outcome::Verdict;

Outcome stable(double radius, double damping, double peak) {
  Outcome outcome;
  outcome.verdict = Verdict::stable;
  outcome.radius = radius;
  outcome.decay = -std::log(radius) * 1000;
  outcome.damping = damping;
  outcome.peak = peak;
  outcome.gain = VectorXd::Constant(2, peak / 2);
  outcome.highest = VectorXd::Constant(2, peak);
  return outcome;
}

Outcome unstable(double radius, double damping) {
  Outcome outcome;
  outcome.verdict = Verdict::unstable;
  outcome.radius = radius;
  outcome.damping = damping;
  return outcome;
}

Outcome failed(const std::string& why) {
  Outcome outcome;
  outcome.failure = why;
  return outcome;
}

TEST(Histogram, BinsAndQuantiles) {
  Histogram histogram{.width = 0.5, .first = -4, .last = 3, .counts = {}};
  for (const double value : {-0.01, 0.0, 0.49, 0.5, -100.0, 100.0, -HUGE_VAL, HUGE_VAL}) {
    histogram.add(value);
  }
  const std::map<int, std::uint64_t> expected{{-4, 2}, {-1, 1}, {0, 2}, {1, 1}, {3, 2}};
  EXPECT_EQ(histogram.counts, expected);
  EXPECT_EQ(histogram.total(), 8u);
  EXPECT_EQ(histogram.quantile(0.5), 0.25);  // the fourth of eight
  EXPECT_EQ(histogram.quantile(0.25), -1.75);
  EXPECT_EQ(histogram.quantile(0.26), -0.25);
  EXPECT_EQ(histogram.quantile(1), 1.75);
  EXPECT_TRUE(std::isnan(Histogram{}.quantile(0.5)));
}

TEST(RatioHistogram, KnowsSmallNumbersAsWellAsLargeOnes) {
  const Histogram bins{.width = 0.001, .first = -9000, .last = 0, .counts = {}};
  RatioHistogram histogram{.below = bins, .above = bins};
  for (const double value : {0.00112, 0.00134, 0.35, -0.2, -0.003, 0.0}) histogram.add(value);
  EXPECT_EQ(histogram.total(), 6u);
  // Half of a bin of 10^0.001.
  const auto expect = [&](double share, double value) {
    EXPECT_NEAR(histogram.quantile(share) / value, 1, 0.0012) << share;
  };
  expect(1.0 / 6, -0.2);
  expect(2.0 / 6, -0.003);
  expect(3.0 / 6, -std::pow(10, -8.9995));  // 0 is in the smallest bin
  expect(4.0 / 6, 0.00112);
  expect(5.0 / 6, 0.00134);
  expect(1, 0.35);
  RatioHistogram twice = histogram;
  twice.merge(histogram);
  EXPECT_EQ(twice.total(), 12u);
  EXPECT_EQ(twice.quantile(0.5), histogram.quantile(0.5));
  EXPECT_TRUE(std::isnan(RatioHistogram{}.quantile(0.5)));
}

TEST(Tally, CountsAndExtremes) {
  Tally tally(2);
  tally.add(0, VectorXd::Zero(1), stable(0.99, 0.5, 2));
  tally.add(1, VectorXd::Zero(1), unstable(1.2, -0.1));
  tally.add(2, VectorXd::Zero(1), failed("no equilibrium found"));
  tally.add(3, VectorXd::Zero(1), stable(0.9, 0.6, 1));
  tally.add(4, VectorXd::Zero(1), failed("no equilibrium found"));
  EXPECT_EQ(tally.n_stable, 2u);
  EXPECT_EQ(tally.n_unstable, 1u);
  EXPECT_EQ(tally.failures.at("no equilibrium found"), 2u);
  EXPECT_EQ(tally.n_samples(), 5u);
  EXPECT_EQ(tally.radius.most, 1.2);
  EXPECT_EQ(tally.radius.least, 0.9);
  EXPECT_EQ(tally.damping.least, -0.1);
  EXPECT_EQ(tally.peak.most, 2);
  EXPECT_EQ(tally.gain[1].least, 0.5);
  EXPECT_EQ(tally.gain_db[1].total(), 2u);
  EXPECT_EQ(tally.highest[1].most, 2);
  EXPECT_EQ(tally.highest_db[1].total(), 2u);
  EXPECT_EQ(tally.least_damping.total(), 3u);
  EXPECT_EQ(tally.decay.total(), 2u);
  // 20 log10(2) = 6.0206 is in the bin from 6.00 to 6.05.
  EXPECT_EQ(tally.peak_db.counts.count(120), 1u);
}

TEST(Tally, KeepsTheWorstByEachMeasure) {
  Tally tally(2);
  for (std::uint64_t i = 0; i < 100; ++i) {
    const double part = static_cast<double>((i * 37) % 100) / 100;
    tally.add(i, VectorXd::Constant(1, part), stable(0.9 + 0.05 * part, part, 2 - part));
  }
  tally.add(200, VectorXd::Zero(1), unstable(1.5, -0.5));
  tally.add(201, VectorXd::Zero(1), unstable(1.5, -0.6));
  const auto& [by_radius, by_damping, by_peak] = tally.worst;
  ASSERT_EQ(by_radius.size(), 10u);
  EXPECT_EQ(by_radius[0].index, 200u);  // of equally bad ones the first
  EXPECT_EQ(by_radius[1].index, 201u);
  EXPECT_TRUE(std::isnan(by_radius[0].peak));
  for (size_t i = 0; i < 8; ++i) EXPECT_NEAR(by_radius[i + 2].radius, 0.9495 - 0.0005 * i, 1e-12);
  for (size_t i = 0; i < 10; ++i) {
    EXPECT_NEAR(by_damping[i].damping, 0.01 * static_cast<double>(i), 1e-15);
    EXPECT_EQ(by_peak[i].index, by_damping[i].index);
    EXPECT_NEAR(by_peak[i].values(0), 0.01 * static_cast<double>(i), 1e-15);
  }
}

void expect_equal(const Tally& a, const Tally& b) {
  EXPECT_EQ(a.n_stable, b.n_stable);
  EXPECT_EQ(a.n_unstable, b.n_unstable);
  EXPECT_EQ(a.failures, b.failures);
  EXPECT_EQ(a.radius.most, b.radius.most);
  EXPECT_EQ(a.damping.least, b.damping.least);
  EXPECT_EQ(a.peak.most, b.peak.most);
  EXPECT_EQ(a.peak.least, b.peak.least);
  EXPECT_EQ(a.gain[0].most, b.gain[0].most);
  EXPECT_EQ(a.decay.counts, b.decay.counts);
  EXPECT_EQ(a.least_damping.below.counts, b.least_damping.below.counts);
  EXPECT_EQ(a.least_damping.above.counts, b.least_damping.above.counts);
  EXPECT_EQ(a.highest[0].most, b.highest[0].most);
  EXPECT_EQ(a.highest_db[1].counts, b.highest_db[1].counts);
  EXPECT_EQ(a.peak_db.counts, b.peak_db.counts);
  EXPECT_EQ(a.gain_db[1].counts, b.gain_db[1].counts);
  for (const Measure measure : measures) {
    const auto& list = a.worst[static_cast<size_t>(measure)];
    const auto& other = b.worst[static_cast<size_t>(measure)];
    ASSERT_EQ(list.size(), other.size());
    for (size_t i = 0; i < list.size(); ++i) EXPECT_EQ(list[i].index, other[i].index);
  }
}

TEST(Tally, MergesToTheTallyOfAllInAnyOrder) {
  std::mt19937 engine(5);
  std::uniform_real_distribution<double> number(0.0, 1.0);
  std::vector<Tally> parts(4, Tally(2));
  Tally all(2);
  for (std::uint64_t i = 0; i < 400; ++i) {
    // Few different values, so that ties at the end of the lists come about.
    const double a = std::round(8 * number(engine)) / 8, b = number(engine);
    const Outcome outcome = b < 0.1   ? failed(b < 0.05 ? "one" : "two")
                            : b < 0.3 ? unstable(1 + a, -a)
                                      : stable(0.9 + 0.09 * a, a, 1 + a);
    parts[i % 4].add(i, VectorXd::Constant(1, a), outcome);
    all.add(i, VectorXd::Constant(1, a), outcome);
  }
  for (const std::vector<size_t>& order : {std::vector<size_t>{0, 1, 2, 3}, {3, 1, 0, 2}}) {
    Tally merged(2);
    for (const size_t part : order) merged.merge(parts[part]);
    expect_equal(merged, all);
  }
  EXPECT_THROW(all.merge(Tally(3)), std::invalid_argument);
}

}  // namespace
}  // namespace stillframe::robustness

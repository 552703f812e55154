#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tests/faults/corruption.hpp"
#include "tests/faults/fault_model.hpp"

namespace stillframe::faults {
namespace {

constexpr std::int64_t period_ns = 1'000'000;

Bytes numbered(int number) {
  return {static_cast<std::uint8_t>(number & 0xff), static_cast<std::uint8_t>(number >> 8)};
}

int number_of(const Bytes& bytes) { return bytes.at(0) + 256 * bytes.at(1); }

struct Wire {
  std::vector<Departure> departures;
  WireCounts counts;
};

/// n messages, one a period, through a wire.
Wire send(const Disturbance& disturbance, std::uint64_t seed, int n) {
  FaultModel model(disturbance, seed, period_ns);
  Wire wire;
  for (int i = 0; i < n; ++i) model.pass(numbered(i), i * period_ns, wire.departures);
  model.release(n * period_ns, wire.departures);
  wire.counts = model.counts();
  return wire;
}

std::vector<int> order(const Wire& wire) {
  std::vector<int> numbers;
  for (const auto& departure : wire.departures) numbers.push_back(number_of(departure.bytes));
  return numbers;
}

TEST(FaultModel, AGoodWireDoesNothing) {
  const Wire wire = send({}, 1, 100);
  ASSERT_EQ(wire.departures.size(), 100u);
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(number_of(wire.departures[static_cast<size_t>(i)].bytes), i);
    EXPECT_EQ(wire.departures[static_cast<size_t>(i)].leave_ns, i * period_ns);
  }
}

TEST(FaultModel, LosesByItsProbability) {
  constexpr int n = 20000;
  for (const double loss : {0.01, 0.1, 0.5}) {
    const Wire wire = send({.loss = loss}, 7, n);
    EXPECT_EQ(wire.counts.n_lost + static_cast<std::int64_t>(wire.departures.size()), n);
    // A binomial count is within four standard deviations of its mean but once in 16000 seeds, and
    // this seed is fixed.
    EXPECT_NEAR(static_cast<double>(wire.counts.n_lost), n * loss,
                4 * std::sqrt(n * loss * (1 - loss)));
    const auto numbers = order(wire);
    EXPECT_TRUE(std::is_sorted(numbers.begin(), numbers.end()));
  }
}

TEST(FaultModel, LosesWholeBursts) {
  const Wire wire = send({.burst = 0.01, .burst_length = 20}, 3, 20000);
  int expected = 0, gaps = 0;
  for (const int number : order(wire)) {
    const int gap = number - expected;
    // Bursts may follow each other at once, so a gap is a whole number of them.
    EXPECT_EQ(gap % 20, 0) << "before message " << number;
    gaps += gap / 20;
    expected = number + 1;
  }
  EXPECT_GT(gaps, 100);
}

TEST(FaultModel, DelaysByTheDelayAndTheJitter) {
  const Wire wire = send({.delay_periods = 2, .jitter_periods = 3}, 5, 20000);
  double least = 1e9, most = 0, sum = 0;
  for (const auto& departure : wire.departures) {
    const double periods =
        static_cast<double>(departure.leave_ns) / period_ns - number_of(departure.bytes);
    least = std::min(least, periods);
    most = std::max(most, periods);
    sum += periods;
  }
  EXPECT_GE(least, 2.0);
  EXPECT_LE(most, 5.0);
  EXPECT_GT(most - least, 2.99);  // 20000 even draws leave no gap of 1 in 300 at the ends
  // The mean of n even draws over 3 periods is within four times 3 / sqrt(12 n) of its middle.
  EXPECT_NEAR(sum / 20000, 3.5, 4 * 3 / std::sqrt(12 * 20000.0));
}

TEST(FaultModel, DuplicatesAtOnce) {
  const Wire wire = send({.duplication = 0.3}, 2, 1000);
  EXPECT_EQ(wire.departures.size(), 1000u + static_cast<size_t>(wire.counts.n_duplicated));
  EXPECT_NEAR(static_cast<double>(wire.counts.n_duplicated), 300, 4 * std::sqrt(1000 * 0.3 * 0.7));
  std::map<int, int> times;
  for (const int number : order(wire)) ++times[number];
  EXPECT_EQ(times.size(), 1000u);
  for (const auto& [number, n] : times) EXPECT_LE(n, 2) << number;
}

TEST(FaultModel, ReordersByOne) {
  const Wire wire = send({.reordering = 0.3}, 2, 1000);
  ASSERT_EQ(wire.departures.size(), 1000u);
  const auto numbers = order(wire);
  std::int64_t swapped = 0;
  for (size_t i = 0; i < numbers.size(); ++i) {
    EXPECT_LE(std::abs(numbers[i] - static_cast<int>(i)), 1);
    if (numbers[i] < static_cast<int>(i)) ++swapped;
    if (i == 0) continue;
    EXPECT_GE(wire.departures[i].leave_ns, wire.departures[i - 1].leave_ns);
  }
  EXPECT_GT(swapped, 100);
  EXPECT_EQ(swapped, wire.counts.n_reordered);
}

TEST(FaultModel, TheSeedIsAllThatIsRandom) {
  const Disturbance all{.loss = 0.1,
                        .burst = 0.01,
                        .burst_length = 3,
                        .delay_periods = 1,
                        .jitter_periods = 2,
                        .duplication = 0.1,
                        .reordering = 0.1};
  const Wire one = send(all, 11, 2000), same = send(all, 11, 2000), other = send(all, 12, 2000);
  ASSERT_EQ(order(one), order(same));
  for (size_t i = 0; i < one.departures.size(); ++i) {
    EXPECT_EQ(one.departures[i].leave_ns, same.departures[i].leave_ns);
  }
  EXPECT_NE(order(one), order(other));
}

stillframe_msgs::measurement_t measurement(std::int64_t seq) {
  stillframe_msgs::measurement_t message{};
  message.run_id = 5;
  message.seq = seq;
  message.time_ns = seq * period_ns;
  message.n_legs = 2;
  message.sigma = {static_cast<double>(seq), -static_cast<double>(seq)};
  message.applied_force = {1, 2};
  return message;
}

std::vector<stillframe_msgs::measurement_t> corrupted(Corruptor& corruptor, std::int64_t seq) {
  std::vector<stillframe_msgs::measurement_t> decoded;
  for (const Bytes& bytes : corruptor.apply(encoded(measurement(seq)), measurement(seq))) {
    stillframe_msgs::measurement_t message;
    if (message.decode(bytes.data(), 0, static_cast<int>(bytes.size())) >= 0) {
      decoded.push_back(message);
    }
  }
  return decoded;
}

TEST(Corruptor, DoesNothingUntilItBeginsAndAfterItsEnd) {
  Corruptor corruptor;
  ASSERT_EQ(corrupted(corruptor, 1).at(0).sigma, measurement(1).sigma);
  corruptor.begin(Corruption::not_finite, 0);
  corrupted(corruptor, 2);
  corruptor.end();
  EXPECT_EQ(corrupted(corruptor, 3).at(0).sigma, measurement(3).sigma);
  EXPECT_EQ(corruptor.n_corrupted(), 1);
}

TEST(Corruptor, DamagesWhatItSays) {
  Corruptor corruptor;
  corruptor.begin(Corruption::not_finite, 1);
  EXPECT_TRUE(std::isnan(corrupted(corruptor, 1).at(0).sigma[1]));
  corruptor.begin(Corruption::out_of_range, 0);
  EXPECT_EQ(corrupted(corruptor, 2).at(0).sigma, (std::vector<double>{1e9, -2}));
  corruptor.begin(Corruption::wrong_size, 0);
  EXPECT_EQ(corrupted(corruptor, 3).at(0).sigma.size(), 3u);
  corruptor.begin(Corruption::truncated, 0);
  EXPECT_TRUE(corrupted(corruptor, 4).empty());
  corruptor.begin(Corruption::frozen, 1);
  EXPECT_EQ(corrupted(corruptor, 5).at(0).sigma, (std::vector<double>{5, -5}));
  EXPECT_EQ(corrupted(corruptor, 6).at(0).sigma, (std::vector<double>{6, -5}));
  corruptor.begin(Corruption::other_run, 0);
  const auto both = corrupted(corruptor, 7);
  ASSERT_EQ(both.size(), 2u);
  EXPECT_EQ(both[0].run_id, 6);
  EXPECT_EQ(both[1].run_id, 5);
  corruptor.begin(Corruption::later, 0);
  const auto later = corrupted(corruptor, 8);
  ASSERT_EQ(later.size(), 2u);
  EXPECT_EQ(later[0].seq, 5008);
  EXPECT_EQ(later[0].time_ns, 5008 * period_ns);
  EXPECT_EQ(later[1].seq, 8);
}

TEST(Corruptor, ReplaysWhatWasThere) {
  Corruptor corruptor;
  for (std::int64_t seq = 0; seq < 1500; ++seq) corrupted(corruptor, seq);
  corruptor.begin(Corruption::replayed, 0);
  const auto both = corrupted(corruptor, 1500);
  ASSERT_EQ(both.size(), 2u);
  EXPECT_EQ(both[0].seq, 500);
  EXPECT_EQ(both[1].seq, 1500);
}

}  // namespace
}  // namespace stillframe::faults

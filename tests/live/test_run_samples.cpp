#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "report/live/run_samples.hpp"
#include "tests/live/sample_messages.hpp"

namespace stillframe::live {
namespace {

using sample::measurement;
using Taken = RunSamples::Taken;

RunSamples samples_at(std::optional<double> rate_hz) { return RunSamples(1, 2, 2, rate_hz); }

/// A measurement whose three accelerations are c, 2 c and 3 c.
stillframe_msgs::measurement_t flat(std::int64_t seq, double c) {
  auto message = measurement(1, seq);
  message.floor_acceleration = {c};
  message.frame_acceleration = {2 * c, 3 * c};
  return message;
}

/// time_ns is rounded to 1 ns, so that of a small k it tells little: the roundest rate that
/// explains it is taken.
TEST(RunSamples, FindsTheRateInTheMeasurements) {
  for (const double rate : {200., 1000., 3000., 4096., 10000., 1234.5, 30.1}) {
    for (const std::int64_t seq : {1, 7, 12345, 3'000'000}) {
      RunSamples samples = samples_at(std::nullopt);
      auto message = measurement(1, seq);
      message.time_ns = std::llround(static_cast<double>(seq) / rate * 1e9);
      samples.take(message);
      // Half a nanosecond of the time of seq samples, relative; nothing where a round rate fits.
      EXPECT_NEAR(samples.sample_rate_hz(), rate, rate * rate / static_cast<double>(seq) * 1e-9)
          << seq;
      EXPECT_EQ(samples.motion().capacity(), std::lround(16 * samples.sample_rate_hz()));
    }
  }
  RunSamples first = samples_at(std::nullopt);
  first.take(measurement(1, 0));
  EXPECT_EQ(first.sample_rate_hz(), 0);  // k = 0 tells nothing
  first.take(measurement(1, 1));
  EXPECT_EQ(first.sample_rate_hz(), 1000);
}

TEST(RunSamples, ImpossibleRatesAreNotBelieved) {
  for (const double rate : {0., -5., 1e12, std::nan("")}) {
    EXPECT_EQ(samples_at(rate).sample_rate_hz(), 0) << rate;
  }
  RunSamples samples = samples_at(std::nullopt);
  auto message = measurement(1, 5);
  message.time_ns = -1;
  EXPECT_EQ(samples.take(message), Taken::fresh);
  EXPECT_EQ(samples.sample_rate_hz(), 0);
}

TEST(RunSamples, AShortGapIsBridgedByStraightLines) {
  RunSamples samples = samples_at(1000);
  samples.take(flat(0, 1));
  samples.take(flat(4, 9));  // 1, 2 and 3 are lost
  EXPECT_EQ(samples.n_missed(), 3);
  ASSERT_EQ(samples.motion().size(), 5);
  for (int channel = 0; channel < 3; ++channel) {
    const Eigen::VectorXd x = samples.motion().newest(channel, 5);
    for (int k = 0; k < 5; ++k) EXPECT_DOUBLE_EQ(x(k), (channel + 1) * (1 + 2 * k));
  }
}

/// 0.2 s are 200 samples at 1 kHz.
TEST(RunSamples, ALongGapEmptiesTheWindow) {
  RunSamples bridged = samples_at(1000), emptied = samples_at(1000);
  bridged.take(flat(0, 1));
  bridged.take(flat(201, 1));
  EXPECT_EQ(bridged.motion().size(), 202);
  EXPECT_FALSE(bridged.began_anew());
  emptied.take(flat(0, 1));
  emptied.take(flat(202, 1));
  EXPECT_EQ(emptied.motion().size(), 1);
  EXPECT_EQ(emptied.n_missed(), 201);
  EXPECT_TRUE(emptied.began_anew());
  for (std::int64_t seq = 203; seq < 203 + 16000; ++seq) emptied.take(flat(seq, 1));
  EXPECT_FALSE(emptied.began_anew());  // and is full again
}

TEST(RunSamples, RepeatedAndOvertakenMeasurementsAreOld) {
  RunSamples samples = samples_at(1000);
  samples.take(flat(5, 1));
  for (int i = 0; i < 100; ++i) EXPECT_EQ(samples.take(flat(5, 1)), Taken::old);  // repeated
  EXPECT_EQ(samples.take(flat(4, 1)), Taken::old);
  EXPECT_EQ(samples.take(flat(6, 1)), Taken::fresh);
  EXPECT_EQ(samples.motion().size(), 2);
  // Always the same one from behind is no run that has begun again.
  for (int i = 0; i < 100; ++i) EXPECT_EQ(samples.take(flat(2, 1)), Taken::old);
}

TEST(RunSamples, NumbersThatRiseFromBehindAreARunBegunAgain) {
  RunSamples samples = samples_at(1000);
  for (std::int64_t seq = 0; seq < 500; ++seq) samples.take(flat(seq, 1));
  std::int64_t seq = 0;
  Taken taken = Taken::old;
  while (seq < 100 && (taken = samples.take(flat(seq, 1))) == Taken::old) ++seq;
  EXPECT_EQ(taken, Taken::restarted);
  EXPECT_EQ(seq, 19);  // the twentieth
}

TEST(RunSamples, WhatIsNotFiniteIsReplacedByWhatWasBefore) {
  RunSamples samples = samples_at(1000);
  samples.take(flat(0, 1));
  auto broken = flat(1, 7);
  broken.frame_acceleration[0] = std::numeric_limits<double>::quiet_NaN();
  broken.frame_acceleration[1] = std::numeric_limits<double>::infinity();
  samples.take(broken);
  EXPECT_EQ(samples.n_not_finite(), 2);
  EXPECT_EQ(samples.motion().last(0), 7);
  EXPECT_EQ(samples.motion().last(1), 2);
  EXPECT_EQ(samples.motion().last(2), 3);
}

TEST(RunSamples, OtherSizesAreRefused) {
  RunSamples samples = samples_at(1000);
  auto message = measurement(1, 0);
  message.n_floor = 0;
  message.floor_acceleration = {};
  EXPECT_EQ(samples.take(message), Taken::wrong_size);
  auto command = sample::command(1, 0);
  command.n_legs = 1;
  command.force = {1};
  EXPECT_FALSE(samples.take(command));
  EXPECT_EQ(samples.seq(), -1);
  EXPECT_EQ(samples.force().size(), 0);
}

/// Half a second at 1 kHz is 500 measurements of the same value.
TEST(RunSamples, BucketsHoldTheSquaresAndTheLargestForce) {
  RunSamples samples = samples_at(1000);
  for (std::int64_t seq = 0; seq < 1500; ++seq) {
    samples.take(flat(seq, seq < 500 ? 1 : 2));
    auto command = sample::command(1, seq);
    command.force = {seq == 700 ? -80. : 1., 2};
    samples.take(command);
  }
  const auto& history = samples.history();
  ASSERT_EQ(history.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    const double c = i == 0 ? 1 : 2;
    EXPECT_EQ(history[i].number, static_cast<std::int64_t>(i));
    EXPECT_EQ(history[i].n, 500);
    EXPECT_DOUBLE_EQ(history[i].sum_squares[0], 500 * c * c);
    EXPECT_DOUBLE_EQ(history[i].sum_squares[2], 500 * 9 * c * c);
    EXPECT_DOUBLE_EQ(history[i].largest_force[0], i == 1 ? 80 : 1);
    EXPECT_DOUBLE_EQ(history[i].largest_force[1], 2);
  }
  EXPECT_EQ(samples.n_saturated(), 150);
}

TEST(RunSamples, AMinuteOfBucketsIsKept) {
  RunSamples samples = samples_at(100);
  for (std::int64_t seq = 0; seq < 100 * 200; ++seq) samples.take(flat(seq, 1));
  EXPECT_EQ(samples.history().size(), RunSamples::n_buckets);
  EXPECT_EQ(samples.history().back().number, 399);
  EXPECT_EQ(samples.history().front().number, 280);
}

/// The largest numbers there are: nothing overflows, and the run that goes on is found again.
TEST(RunSamples, TheLargestNumbersDoNoHarm) {
  RunSamples samples = samples_at(1000);
  samples.take(flat(10, 1));
  auto message = flat(11, 1);
  message.seq = message.time_ns = std::numeric_limits<std::int64_t>::max();
  EXPECT_EQ(samples.take(message), Taken::fresh);
  auto command = sample::command(1, 10);
  command.seq = std::numeric_limits<std::int64_t>::min();
  EXPECT_TRUE(samples.take(command));
  std::int64_t seq = 11;
  while (seq < 100 && samples.take(flat(seq, 1)) == Taken::old) ++seq;
  EXPECT_EQ(seq, 30);
}

/// A number out of all bounds must not keep what comes after it from being seen.
TEST(RunSamples, ACommandFromTheFutureIsPassedOver) {
  RunSamples samples = samples_at(1000);
  samples.take(flat(10, 1));
  auto command = sample::command(1, 10);
  command.seq = std::numeric_limits<std::int64_t>::max();
  EXPECT_TRUE(samples.take(command));
  EXPECT_EQ(samples.force().size(), 0);
  EXPECT_TRUE(samples.take(sample::command(1, 10)));
  EXPECT_EQ(samples.force().size(), 1);
}

}  // namespace
}  // namespace stillframe::live

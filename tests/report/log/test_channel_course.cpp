#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <vector>

#include "report/log/channel_course.hpp"

namespace stillframe::report {
namespace {

using Course = std::function<double(std::int64_t)>;

/// What a channel did beside one that moves it.
struct Followed {
  ChannelCourse course;
  Variation mover;

  bool is_dead() const {
    if (course.rest.n == 0 || course.rest.during[0].n < Rest::fewest) return false;
    const double inside = course.rest.during[0].sum;
    return is_odd(course, inside, mover.sum - inside);
  }
};

Followed follow(
    std::int64_t n, const Course& mover, const Course& channel,
    const std::function<bool(std::int64_t)>& lost = [](std::int64_t) { return false; }) {
  CourseRecorder recorder({{}, {0, 1}});
  for (std::int64_t k = 0; k < n; ++k) {
    const double values[] = {mover(k), channel(k)};
    if (!lost(k)) recorder.take(k, values, 0, 2);
  }
  const auto courses = recorder.courses();
  return {courses[1], courses[0].moved};
}

/// Noise of a standard deviation of 1 that is the same in every run.
Course noise() {
  std::vector<double> values(80'000);
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (double& value : values) value = normal(random);
  return [values](std::int64_t k) { return values.at(static_cast<std::size_t>(k)); };
}

Course rounded(const Course& course, double step) {
  return [=](std::int64_t k) { return step * std::round(course(k) / step); };
}

TEST(ChannelCourse, AChannelThatDiesIsSeenWithItsTime) {
  const Course floor = noise();
  // Of a full converter, one of 12 bits over 8 standard deviations, and one that shows +-1 alone.
  for (const double step : {1e-9, 8.0 / 4096, 1.0}) {
    const auto dead = [&](std::int64_t from, std::int64_t to, double value) {
      const Course alive = rounded(floor, step);
      return Course([=](std::int64_t k) { return k >= from && k < to ? value : alive(k); });
    };
    for (const std::int64_t from : {0, 100, 3000, 15'000}) {
      for (const std::int64_t to : {18'000, 20'000}) {
        if (to - from == 20'000) continue;  // what never changes needs a model
        const Followed channel = follow(20'000, floor, dead(from, to, 77));
        EXPECT_TRUE(channel.is_dead()) << step << ", " << from << " to " << to;
        EXPECT_EQ(channel.course.rest.first_seq, from);
        EXPECT_EQ(channel.course.rest.last_seq, to - 1);
      }
    }
    EXPECT_FALSE(follow(20'000, floor, dead(0, 0, 0)).is_dead()) << step;
    // Gaps take nothing away from that, and are no rest themselves.
    const auto lost = [](std::int64_t k) { return k % 7 == 3 || (k > 4000 && k < 9000); };
    const Followed gaps = follow(20'000, floor, dead(3000, 18'000, 77), lost);
    EXPECT_TRUE(gaps.is_dead());
    EXPECT_EQ(gaps.course.rest.first_seq, 3000);
    EXPECT_FALSE(follow(20'000, floor, dead(0, 0, 0), lost).is_dead());
  }
}

// Between its motions a floor rests for longer than a channel has to be dead.
TEST(ChannelCourse, TheRestInWhichMostIsDoneIsKept) {
  const Course some = noise();
  const Course floor = [&](std::int64_t k) { return k >= 300 && k < 10'000 ? 0 : some(k); };
  const Followed channel = follow(
      20'000, floor, [&](std::int64_t k) { return k >= 12'000 && k < 13'000 ? 77 : floor(k); });
  EXPECT_EQ(channel.course.rest.first_seq, 12'000);
  EXPECT_TRUE(channel.is_dead());
  EXPECT_FALSE(follow(20'000, floor, floor).is_dead());
  // What a channel does up to 20 samples after it is told to.
  EXPECT_FALSE(
      follow(20'000, floor, [&](std::int64_t k) { return floor(k < 20 ? 0 : k - 20); }).is_dead());
}

TEST(ChannelCourse, WhatAConverterCannotShowIsNoDeath) {
  const Course some = noise();
  // On a quiet floor it changes now and then: at 3 standard deviations 1 sample in 370.
  EXPECT_FALSE(follow(20'000, some, rounded(some, 6)).is_dead());
  // While the floor is a thousandth of what it is later, the channel rests.
  const Course floor = [&](std::int64_t k) { return (k < 10'000 ? 1e-3 : 1) * some(k); };
  for (const double step : {0.01, 0.1, 0.5}) {
    const Followed channel = follow(20'000, floor, rounded(floor, step));
    EXPECT_EQ(channel.course.rest.first_seq, 0) << step;
    EXPECT_FALSE(channel.is_dead()) << step;
  }
  // One that is fine enough to show it is dead.
  EXPECT_TRUE(follow(20'000, floor, [&](std::int64_t k) {
                return k < 10'000 ? 0 : rounded(floor, 1e-5)(k);
              }).is_dead());
  // A slow sine rests at its turning points: 16 bits, 20 s at 2 kHz.
  const Course slow = [](std::int64_t k) {
    return 32'767 * std::cos(2 * std::numbers::pi * static_cast<double>(k) / 40'000);
  };
  const Followed turning = follow(80'000, some, rounded(slow, 1));
  EXPECT_GE(turning.course.rest.n, Rest::fewest);
  EXPECT_FALSE(turning.is_dead());
}

}  // namespace
}  // namespace stillframe::report

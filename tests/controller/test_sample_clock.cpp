#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "controller/deadlines.hpp"
#include "controller/sample_clock.hpp"
#include "controller/screen.hpp"
#include "msgs/identity.hpp"
#include "msgs/peer_clocks.hpp"
#include "tests/controller/rig.hpp"

namespace stillframe::controller {
namespace {

/// A card with a crystal of its own, seen through what is between: sample k is taken at start + k T
/// / (1 + ppm), and arrives after at least `way_ns`.
struct Card {
  double rate_hz = 1000, ppm = 0, jitter = 0.3;  ///< jitter: of a period, at most
  std::int64_t start_ns = 5'000'000'000'000, way_ns = 30'000;
  std::mt19937_64 random{1};
  std::int64_t k = 0, number = 0;  ///< samples taken, and what the card calls the next one

  double taken_ns(std::int64_t sample) const {
    return static_cast<double>(sample) * 1e9 / rate_hz / (1 + 1e-6 * ppm);
  }
  Measurement next() {
    Measurement m;
    m.seq = number++;
    const double late =
        jitter * std::uniform_real_distribution<double>(0, 1)(random) * 1e9 / rate_hz;
    m.received_ns = start_ns + way_ns + std::llround(taken_ns(k++) + late);
    return m;
  }
  /// How far the clock's instant of a sample is from the earliest that it can have come, in
  /// periods.
  double error(const SampleClock& clock, const Measurement& m) const {
    return static_cast<double>(clock.local_ns(m.time_ns) - start_ns - way_ns -
                               std::llround(taken_ns(k - 1))) *
           1e-9 * rate_hz;
  }
};

TEST(SampleClock, OfAPlantOnTheSameClockIsWhatItSays) {
  SampleClock clock(7'000, 3000, Pacing::same_clock);
  Measurement m{.seq = 9, .time_ns = 3'000'000};
  m.received_ns = 1'000'000'000'000;
  clock.see(m);
  EXPECT_EQ(m.seq, 9);
  EXPECT_EQ(clock.local_ns(m.time_ns), 3'007'000);
  EXPECT_THROW(SampleClock(0, 0, Pacing::card), std::invalid_argument);
}

TEST(SampleClock, FollowsAnyCrystal) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> drift(-200, 200), decade(1.7, 4.3), jitter(0, 0.9);
  for (int trial = 0; trial < 30; ++trial) {
    Card card{
        .rate_hz = std::pow(10, decade(random)), .ppm = drift(random), .jitter = jitter(random)};
    SCOPED_TRACE(testing::Message()
                 << card.rate_hz << " Hz, " << card.ppm << " ppm, " << card.jitter);
    SampleClock clock(0, card.rate_hz, Pacing::card);
    const auto n = static_cast<std::int64_t>(60 * card.rate_hz);
    double worst = 0, mean = 0;
    for (std::int64_t k = 0; k < n; ++k) {
      Measurement m = card.next();
      clock.see(m);
      ASSERT_EQ(m.seq, k);
      const double error = card.error(clock, m);
      // The first arrival may be as late as any.
      if (k > 100) worst = std::max(worst, std::abs(error));
      if (k > n / 2) mean += error / static_cast<double>(n - n / 2);
    }
    // At 500 ppm upwards and one arrival in 20 within a twentieth of the jitter: 0.01 + 0.05 * 0.9;
    // and four times that for the luck of 60 s.
    EXPECT_LT(worst, 0.22);
    EXPECT_LT(std::abs(mean), 0.04);
    // Over the 10 s of a slope, the reference is off by half the mean at each end.
    EXPECT_NEAR(1e6 * clock.drift(), -card.ppm, 1 + 1e6 * 0.06 / (10 * card.rate_hz) + 0.05);
    EXPECT_EQ(clock.n_locks(), 0);
  }
}

TEST(SampleClock, StepsPausesAndRestartsAreNumberedOn) {
  std::mt19937_64 random(5);
  for (int trial = 0; trial < 30; ++trial) {
    Card card{.rate_hz = 1000, .ppm = 150, .jitter = 0.03 * trial};
    SampleClock clock(0, card.rate_hz, Pacing::card);
    std::int64_t last = -1;
    const auto run = [&](int n) {
      for (int i = 0; i < n; ++i) {
        Measurement m = card.next();
        clock.see(m);
        const bool rises = m.seq > last;
        last = std::max(last, m.seq);
        if (i >= SampleClock::settle) {
          ASSERT_TRUE(rises) << i;
          // The earliest of twenty, and what it takes to find an earlier one.
          ASSERT_LT(std::abs(card.error(clock, m)), 0.1 + card.jitter / 2) << i;
        }
      }
    };
    run(500);
    ASSERT_EQ(clock.n_locks(), 0);
    // A pause of the card that it does not count, a step, and a restart; the time that passed is
    // found again in the numbers.
    const std::int64_t paused = 3 + static_cast<std::int64_t>(random() % 500);
    const std::int64_t before = last;
    card.k += paused;
    run(500);
    EXPECT_EQ(clock.n_locks(), 1);
    EXPECT_EQ(last, before + 500 + paused);
    card.number = static_cast<std::int64_t>(random() % 100);
    run(500);
    EXPECT_EQ(clock.n_locks(), 2);
    EXPECT_EQ(last, before + 1000 + paused);
    // What is counted and only did not arrive needs no new lock.
    card.k += 700;
    card.number += 700;
    run(100);
    EXPECT_EQ(clock.n_locks(), 2);
  }
}

TEST(SampleClock, AStallOnTheWayIsNoStep) {
  Card card{.rate_hz = 2000, .ppm = -120, .jitter = 0.1};
  SampleClock clock(0, card.rate_hz, Pacing::card);
  std::int64_t last = -1;
  for (int i = 0; i < 20'000; ++i) {
    Measurement m = card.next();
    // Every second all of 60 ms come at once.
    const std::int64_t in_block = card.k % 2000;
    if (card.k > 2000 && in_block < 120) m.received_ns += (120 - in_block) * 500'000;
    clock.see(m);
    ASSERT_EQ(m.seq, last + 1);
    last = m.seq;
    if (i > 200) ASSERT_LT(std::abs(card.error(clock, m)), 0.1) << i;
  }
  EXPECT_EQ(clock.n_locks(), 0);
}

TEST(SampleClock, ADamagedNumberIsNotFollowed) {
  Card card{.rate_hz = 1000};
  SampleClock clock(0, card.rate_hz, Pacing::card);
  for (int i = 0; i < 1000; ++i) {
    Measurement m = card.next();
    if (i % 50 == 7) {
      Measurement wrong = m;
      wrong.seq = i % 100 == 7 ? std::int64_t{1} << 60 : -(std::int64_t{1} << 60);
      clock.see(wrong);
    }
    clock.see(m);
    ASSERT_EQ(m.seq, i);
  }
  EXPECT_EQ(clock.n_locks(), 0);
}

/// A day by the clock, without the law: deadlines and ages as the loop has them. Every ten minutes
/// the card begins anew after a pause; every 1000 periods the loop is late by 2.3 periods.
TEST(SampleClock, ADayAtAnyDrift) {
  for (const double ppm : {-200.0, 200.0}) {
    Card card{.rate_hz = 100, .ppm = ppm, .jitter = 0.3};
    const double period_ns = 1e7;
    SampleClock clock(0, card.rate_hz, Pacing::card);
    Screen screen({}, card.rate_hz);
    Deadlines deadlines(card.start_ns, card.rate_hz, 0.5);
    std::int64_t n_late = 0, n_asked_late = 0, n_stale = 0, n_missing = 0, n_pauses = 0;
    Measurement next = card.next();
    std::int64_t settled = 100;
    for (std::int64_t i = 0; i < 8'640'000; ++i) {
      std::int64_t now = deadlines.next_ns() + 20'000;
      if (i % 1000 == 999) {
        now += std::llround(2.3 * period_ns);
        n_asked_late += 2;
      }
      n_late += deadlines.wake_up(now).n_skipped;
      bool any = false;
      Measurement newest;
      const bool began = clock.locked();
      while (next.received_ns <= now) {
        clock.see(next);
        if (screen.is_new(next, clock.age(next, now))) {
          any = true;
          newest = next;
        }
        if (card.k % 60'000 == 0) {  // of ten minutes; off for 1.5 s
          card.k += 150;
          card.number = 0;
          ++n_pauses;
          settled = i + 150 + 2 * SampleClock::settle;
        }
        next = card.next();
      }
      if (clock.locked()) {
        if (!began) deadlines.begin(clock.reference_ns(), clock.reference(), now);
        deadlines.follow(clock.reference_ns(), clock.reference(), clock.period_ns());
      }
      if (i < settled) continue;
      if (!any) {
        ++n_missing;
      } else if (i % 1000 != 999 && screen.judge(newest, clock.age(newest, now)) != Defect::none) {
        ++n_stale;
      }
    }
    EXPECT_EQ(n_late, n_asked_late);
    EXPECT_EQ(n_missing, 0);
    EXPECT_EQ(n_stale, 0);
    EXPECT_EQ(clock.n_locks(), n_pauses);
    EXPECT_GT(n_pauses, 140);
  }
}

/// A plant on another host keeps its numbers, from wherever they are first heard, through stalls,
/// and through a step of either clock, after which the line is found again.
TEST(SampleClock, APlantElsewhereKeepsItsNumbers) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> drift(-200, 200), decade(1.7, 4.3), jitter(0, 0.9);
  for (int trial = 0; trial < 60; ++trial) {
    Card card{
        .rate_hz = std::pow(10, decade(random)), .ppm = drift(random), .jitter = jitter(random)};
    card.k = card.number = static_cast<std::int64_t>(random() % 1'000'000);
    SCOPED_TRACE(testing::Message()
                 << card.rate_hz << " Hz, " << card.ppm << " ppm, " << card.jitter);
    // What the exchange of clocks makes of its start is right for now, and may be off by any part
    // of a period, and more.
    const double off = 3 * drift(random) / 200;
    const double start = card.taken_ns(card.k) - static_cast<double>(card.k) * 1e9 / card.rate_hz;
    SampleClock clock(card.start_ns + std::llround(start + off * 1e9 / card.rate_hz), card.rate_hz,
                      Pacing::other_host);
    const auto follows = [&](int n) {
      double worst = 0;
      for (int i = 0; i < n; ++i) {
        Measurement m = card.next();
        const std::int64_t number = m.seq;
        m.time_ns = std::llround(static_cast<double>(number) * 1e9 / card.rate_hz);
        const std::int64_t time_ns = m.time_ns;
        clock.see(m);
        ASSERT_EQ(m.seq, number);
        ASSERT_EQ(m.time_ns, time_ns);
        if (i > 100) worst = std::max(worst, std::abs(card.error(clock, m)));
      }
      // As of a card.
      EXPECT_LT(worst, 0.22);
    };
    follows(3000);
    EXPECT_EQ(clock.n_locks(), 0);
    card.start_ns +=
        std::llround((trial % 2 == 0 ? -1e9 : 1e9) * (10 + jitter(random)) / card.rate_hz);
    follows(3000);
    EXPECT_EQ(clock.n_locks(), 1);
    // Twenty of before once more are no step.
    Card again = card;
    again.k -= 50;
    again.number -= 50;
    for (int i = 0; i < 40; ++i) {
      Measurement m = again.next();
      m.received_ns += 60'000'000'000 / static_cast<std::int64_t>(card.rate_hz);
      clock.see(m);
    }
    EXPECT_EQ(clock.n_locks(), 1);
    follows(200);
  }
}

/// The whole loop on a card, or a plant elsewhere, that drifts: active, no fault, no period late,
/// whatever the rate; and on the same one without a disciplined clock there is one.
TEST(SampleClock, TheLoopGoesAlongWithACard) {
  for (const double ppm : {-200.0, 200.0}) {
    for (const Pacing pacing : {Pacing::card, Pacing::other_host, Pacing::same_clock}) {
      const Gains gains = toy::damped_gains();
      InProcessIo io(gains.n_legs(), 64);
      const Supervisor supervisor(gains, {}, true);
      Card card{.rate_hz = gains.sample_rate_hz, .ppm = ppm, .jitter = 0.2};
      Loop loop(
          io, supervisor, {},
          {.sample_rate_hz = gains.sample_rate_hz, .start_ns = card.start_ns, .pacing = pacing});
      std::normal_distribution<double> normal;
      Measurement next = card.next();
      Eigen::VectorXd force = Eigen::VectorXd::Zero(gains.n_legs());
      Command command = command_of(gains.n_legs());
      for (int i = 0; i < 40'000; ++i) {
        const std::int64_t now = loop.next_ns() + 15'000;
        for (; next.received_ns <= now; next = card.next()) {
          next.time_ns = std::llround(static_cast<double>(next.seq) * 1e9 / gains.sample_rate_hz);
          next.applied = force;
          next.sigma = force;
          for (double& value : next.sigma) value += 0.01 * normal(card.random);
          next.floor.resize(0);
          next.frame.resize(0);
          io.put(next);
        }
        loop.period(now);
        while (io.take(command)) force = command.force;
      }
      const LoopCounters& counters = loop.counters();
      if (pacing != Pacing::same_clock) {
        EXPECT_EQ(counters.state, State::active) << ppm;
        EXPECT_EQ(counters.n_faults, 0);
        EXPECT_EQ(counters.n_late, 0);
        EXPECT_LE(counters.n_missing, 5);
        EXPECT_NEAR(1e6 * counters.drift, -ppm, 3);
      } else {
        EXPECT_GT(counters.n_missing, 1000) << ppm;
      }
    }
  }
}

/// A plant whose clock stands still, or that is stopped and catches up: the loop never sleeps
/// through more than what it waits for, and goes on by the plant's samples.
TEST(SampleClock, TheLoopStaysAwakeBesideAPlantElsewhere) {
  const Gains gains = toy::damped_gains();
  constexpr std::int64_t period = 1'000'000;
  struct Pause {
    int samples;
    double spacing;  ///< of the samples behind it, periods; 0: the clock itself stood still
  };
  for (const Pause pause : {Pause{15, 0.8},
                            {30, 0.55},
                            {100, 0.3},
                            {300, 0.9},
                            {1000, 0.05},
                            {3000, 0.3},
                            {10, 0},
                            {300, 0},
                            {3000, 0}}) {
    SCOPED_TRACE(testing::Message() << pause.samples << " periods, spacing " << pause.spacing);
    InProcessIo io(gains.n_legs(), 4096);
    const Supervisor supervisor(gains, {}, true);
    Loop loop(io, supervisor, {},
              {.sample_rate_hz = 1000, .start_ns = 0, .pacing = Pacing::other_host});
    constexpr std::int64_t n_before = 3000, n_after = 20'000;
    std::int64_t k = 0, arrival = 40'000, last_now = 0, longest = 0;
    Eigen::VectorXd force = Eigen::VectorXd::Zero(gains.n_legs());
    Command command = command_of(gains.n_legs());
    const auto next_arrival = [&] {
      const std::int64_t due = k * period + 40'000;
      if (k < n_before) return due;
      const std::int64_t stall = pause.samples * period;
      if (pause.spacing == 0) return due + stall;
      const std::int64_t first = n_before * period + stall;
      const auto caught_up =
          std::llround(pause.spacing * static_cast<double>(period)) * (k - n_before);
      return std::max<std::int64_t>(due, first + caught_up);
    };
    while (k < n_before + n_after) {
      const std::int64_t now = loop.next_ns() + 15'000;
      longest = std::max(longest, now - last_now);
      last_now = now;
      for (; arrival <= now; ++k, arrival = next_arrival()) {
        Measurement m = measurement_of(gains.n_legs(), 0);
        m.seq = k;
        m.time_ns = k * period;
        m.received_ns = arrival;
        m.applied = m.sigma = force;
        for (Index i = 0; i < m.sigma.size(); ++i)
          m.sigma(i) += 0.01 * std::sin(static_cast<double>(7 * k + i));
        io.put(m);
      }
      loop.period(now);
      while (io.take(command)) force = command.force;
    }
    EXPECT_LE(longest, 2 * period);
    EXPECT_EQ(loop.counters().n_locks, pause.spacing == 0 ? 1 : 0);
    EXPECT_EQ(loop.counters().state, State::active);
  }
}

/// A plant on another host, its clock as it is found by asking, and a network. From a moment on the
/// way takes longer, for its samples alone, for all that it says, or both ways; or its clock stands
/// still for a while.
struct Elsewhere {
  enum What { samples_longer, back_longer, both_longer, clock_stood_still };
  static constexpr std::int64_t here = (std::int64_t{1} << bits_below_clock) + 1;
  static constexpr std::int64_t there = (std::int64_t{2} << bits_below_clock) + 1;
  static constexpr double ahead_ns = 3e12, start_ns = 50e9;

  double rate_hz, ppm, way_ns;
  What what;
  double from_ns, by_ns;
  std::mt19937_64 random;
  PeerClocks clocks{here};
  SampleClock line{std::llround(start_ns), rate_hz, Pacing::other_host};
  std::int64_t k = 0, held = 0;

  double reads(double now_ns) const {
    const double stood = what == clock_stood_still ? std::clamp(now_ns - from_ns, 0.0, by_ns) : 0;
    return ahead_ns + start_ns + (now_ns - start_ns - stood) * (1 + 1e-6 * ppm);
  }
  double taken_ns(std::int64_t sample) const {
    const double taken = start_ns + static_cast<double>(sample) * 1e9 / rate_hz / (1 + 1e-6 * ppm);
    return what == clock_stood_still && taken > from_ns ? taken + by_ns : taken;
  }
  double way() { return way_ns * (1 + 0.2 * std::uniform_real_distribution<double>(0, 1)(random)); }

  /// The next sample comes, and with it whatever is said of clocks; its age (s).
  double next() {
    const double taken = taken_ns(k);
    const bool longer = what != clock_stood_still && taken > from_ns;
    Measurement m{.seq = k, .time_ns = std::llround(static_cast<double>(k) * 1e9 / rate_hz)};
    const double arrival = taken + way() + (longer ? by_ns : 0);
    m.received_ns = std::llround(arrival);
    ++k;
    if (const auto start =
            clocks.instant(there, std::llround(ahead_ns + start_ns), m.received_ns)) {
      line.bound(start->earliest_ns, start->latest_ns);
    }
    line.see(m);
    if (line.n_held() != held) clocks.doubt(there);
    held = line.n_held();
    if (const auto question = clocks.question(m.received_ns)) {
      const double heard = arrival + way() + (longer && what == both_longer ? by_ns : 0);
      const double back = heard + way() + (longer && what != samples_longer ? by_ns : 0);
      auto answer = *question;
      answer.heard_ns = answer.answered_ns = std::llround(reads(heard));
      clocks.take(answer, std::llround(back));
    }
    return line.age(m, m.received_ns);
  }
};

/// A longer way is lateness, for as long as it is longer; what stood still is followed once it was
/// asked.
TEST(SampleClock, ALongerWayIsLateAndAClockThatStoodStillIsFollowed) {
  std::mt19937_64 random(9);
  const auto uniform = [&](double from, double to) {
    return std::uniform_real_distribution<double>(from, to)(random);
  };
  for (int trial = 0; trial < 40; ++trial) {
    const double rate = std::pow(10, uniform(2, 3.5)), period_ns = 1e9 / rate;
    const auto what = static_cast<Elsewhere::What>(trial % 4);
    const double by = period_ns * (trial % 8 < 4 ? uniform(0.7, 2) : uniform(2, 300));
    Elsewhere plant{.rate_hz = rate,
                    .ppm = uniform(-200, 200),
                    .way_ns = period_ns * uniform(0.02, 0.2),
                    .what = what,
                    .from_ns = Elsewhere::start_ns + uniform(25e9, 30e9),
                    .by_ns = by,
                    .random = std::mt19937_64(random())};
    SCOPED_TRACE(testing::Message()
                 << what << ", " << rate << " Hz, " << plant.ppm << " ppm, by " << by / period_ns
                 << " periods, way " << plant.way_ns / period_ns);
    while (plant.taken_ns(plant.k) <= plant.from_ns) {
      ASSERT_LT(plant.next() * rate, 0.1 + (plant.k < 100 ? 0.4 : 0.0));
    }
    ASSERT_EQ(plant.line.n_locks(), 0);
    const std::int64_t since = plant.k;
    const auto asked = static_cast<std::int64_t>(1.2 * rate) + 3 * SampleClock::settle;
    while (plant.k < since + static_cast<std::int64_t>(60 * rate)) {
      const double late = plant.next() * rate;
      const double longer = what == Elsewhere::clock_stood_still ? 0 : by / period_ns;
      if (longer > 0 || plant.k > since + asked) ASSERT_NEAR(late, longer, 0.2) << plant.k - since;
    }
    EXPECT_EQ(plant.line.n_locks(), what == Elsewhere::clock_stood_still ? 1 : 0);
    EXPECT_GT(plant.line.n_held(), 0);
    // And once it is as short as before, so is what is seen of it.
    plant.by_ns = what == Elsewhere::clock_stood_still ? by : 0;
    for (int i = 0; i < 100; ++i) EXPECT_LT(plant.next() * rate, 0.2);
  }
}

/// A clock that stood still while the way of the samples got longer as well: of both together the
/// clock's part moves the line.
TEST(SampleClock, TheLineGoesNoFurtherThanTheClocksSay) {
  SampleClock clock(0, 1000, Pacing::other_host);
  std::int64_t stood = 0, late = 30'000;
  const auto run = [&](std::int64_t from, std::int64_t to) {
    double age = 0;
    for (std::int64_t k = from; k < to; ++k) {
      Measurement m{.seq = k, .time_ns = k * 1'000'000};
      m.received_ns = m.time_ns + stood + late;
      clock.see(m);
      age = clock.age(m, m.received_ns);
    }
    return age;
  };
  clock.bound(-20'000, 20'000);
  run(0, 1000);
  stood = 800'000'000;
  late = 40'030'000;
  EXPECT_NEAR(run(1000, 1100), 0.84, 1e-6);
  EXPECT_EQ(clock.n_locks(), 0);
  clock.bound(stood - 20'000, stood + 20'000);
  EXPECT_NEAR(run(1100, 1200), 0.0395, 0.0001);
  EXPECT_EQ(clock.n_locks(), 1);
  // What was taken before it can have been is not followed either.
  stood = late = 0;
  run(2100, 2200);
  EXPECT_EQ(clock.n_locks(), 1);
  clock.unbound();
  EXPECT_NEAR(run(2200, 2300), 0, 1e-6);
}

/// The first samples behind a gap are late; the slope that ends with them is not that of the
/// crystal.
TEST(SampleClock, AGapDoesNotBendTheLine) {
  for (const std::int64_t gap : {300, 2500, 5500}) {
    SampleClock clock(0, 1000, Pacing::other_host);
    double worst = 0;
    for (std::int64_t k = 0; k < 60'000; ++k) {
      if (k % 10'001 > 10'000 - gap) continue;
      Measurement m{.seq = k, .time_ns = k * 1'000'000};
      m.received_ns = m.time_ns + (k % 10'001 < 5 ? 450'000 : 30'000);
      clock.see(m);
      worst = std::max(worst, std::abs(clock.drift()));
    }
    // Five samples of half a ms are 0.02 ms of the ten seconds where the reference had not gone
    // along.
    EXPECT_LT(worst, 3e-6) << gap;
  }
}

/// Datagrams come twice, by two ways, while the clock of the plant has stood still.
TEST(SampleClock, WhatComesTwiceDoesNotHoldTheLine) {
  SampleClock clock(0, 1000, Pacing::other_host);
  for (std::int64_t k = 0; k < 2000; ++k) {
    for (int copy = 0; copy < 2; ++copy) {
      Measurement m{.seq = k, .time_ns = k * 1'000'000};
      m.received_ns = m.time_ns + 30'000 + copy * 100'000 + (k > 1000 ? 1'000'000'000 : 0);
      clock.see(m);
    }
  }
  EXPECT_EQ(clock.n_locks(), 1);
}

/// A number from the future, as the first, would make all others old.
TEST(SampleClock, ANumberFromTheFutureDoesNotBeginTheLine) {
  SampleClock clock(0, 1000, Pacing::other_host);
  Measurement forged{.seq = 1'000'000'000, .time_ns = 1'000'000'000'000'000};
  clock.see(forged);
  EXPECT_FALSE(clock.locked());
}

/// What is heard first is a recording of this very run: it is as late as it was recorded ago.
TEST(SampleClock, ARecordingDoesNotBeginTheLine) {
  for (const bool recording : {true, false}) {
    SampleClock clock(1'000'000'000, 1000, Pacing::other_host, 2'000'000);
    for (std::int64_t k = 5000; k < 5100; ++k) {
      Measurement m{.seq = k, .time_ns = k * 1'000'000};
      m.received_ns = 1'000'000'000 + m.time_ns + 100'000 + (recording ? 4'000'000'000 : 0);
      clock.see(m);
      EXPECT_NEAR(clock.age(m, m.received_ns), recording ? 4.0001 : 0, 0.0002);
    }
    EXPECT_EQ(clock.locked(), !recording);
  }
}

TEST(SampleClock, WhatWaitedBeforeTheLoopBeganIsNotLost) {
  const Gains gains = toy::damped_gains();
  InProcessIo io(gains.n_legs(), 64);
  const Supervisor supervisor(gains, {}, true);
  Card card{.jitter = 0};
  Loop loop(io, supervisor, {},
            {.sample_rate_hz = 1000, .start_ns = card.start_ns, .pacing = Pacing::card});
  std::int64_t now = 0;
  const auto put = [&] {
    Measurement m = measurement_of(gains.n_legs(), 0);
    const Measurement taken = card.next();
    m.seq = taken.seq;
    m.received_ns = now = taken.received_ns;
    io.put(m);
  };
  for (int i = 0; i < 30; ++i) put();
  loop.period(now + 1000);
  for (int i = 0; i < 10; ++i) {
    put();
    loop.period(loop.next_ns() + 1000);
  }
  EXPECT_EQ(loop.counters().n_lost, 0);
  EXPECT_EQ(loop.counters().n_answered, 11);
  EXPECT_EQ(loop.last_seq(), 10);
}

}  // namespace
}  // namespace stillframe::controller

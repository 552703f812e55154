#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "msgs/identity.hpp"
#include "msgs/peer_clocks.hpp"

// How clocks of other hosts are read.
namespace stillframe {
namespace {

using stillframe_msgs::clock_exchange_t;

std::int64_t on_clock(std::int64_t clock, std::int64_t number) {
  return clock << bits_below_clock | number;
}

/// A host whose clock began at another time and runs at another rate, both by a true time in ns.
struct Host {
  std::int64_t instance;
  double ahead_ns = 0, ppm = 0;
  PeerClocks clocks{instance};

  std::int64_t reads(double true_ns) const {
    return std::llround(ahead_ns + true_ns * (1 + 1e-6 * ppm));
  }
};

/// Two hosts, and a network with two ways that are as unequal as they like.
struct Pair {
  std::mt19937_64 random;
  Host here{on_clock(1, 5)}, there{on_clock(2, 7)};
  double now_ns = 0, slowest_ns = 1e6, lost = 0;

  explicit Pair(std::uint64_t seed) : random(seed) {
    here.ahead_ns = uniform(1e9, 1e16);
    there.ahead_ns = uniform(1e9, 1e16);
    here.ppm = uniform(-200, 200);
    there.ppm = uniform(-200, 200);
  }
  double uniform(double from, double to) {
    return std::uniform_real_distribution<double>(from, to)(random);
  }
  /// A way of a message; most are quick, as on a network.
  double way_ns() { return slowest_ns * std::pow(uniform(0, 1), 4); }
  std::optional<PeerClocks::Instant> reading_of(double true_ns) {
    return here.clocks.instant(there.instance, there.reads(true_ns), here.reads(now_ns));
  }
  /// All questions that are due, with their answers.
  void exchange() {
    while (const auto question = here.clocks.question(here.reads(now_ns))) {
      if (uniform(0, 1) < lost) continue;
      now_ns += way_ns();
      const auto answer = there.clocks.take(*question, there.reads(now_ns));
      ASSERT_TRUE(answer);
      now_ns += way_ns();
      EXPECT_FALSE(here.clocks.take(*answer, here.reads(now_ns)));
    }
  }
};

TEST(PeerClocks, OfTheOwnClockAReadingIsWhatItSays) {
  PeerClocks clocks(on_clock(3, 1));
  for (const std::int64_t peer : {on_clock(3, 2), std::int64_t{99}}) {
    const auto instant = clocks.instant(peer, 1'000, 2'000);
    ASSERT_TRUE(instant);
    EXPECT_EQ(instant->earliest_ns, 1'000);
    EXPECT_EQ(instant->latest_ns, 1'000);
    EXPECT_TRUE(clocks.is_fresh(peer, 1'000, 2'000));
    EXPECT_FALSE(clocks.is_fresh(peer, 2'001, 2'000));
    EXPECT_FALSE(clocks.is_fresh(peer, 2'000 - fresh_ns, 2'000));
  }
  EXPECT_FALSE(clocks.question(2'000));
  EXPECT_EQ(clocks.unanswered(), "");
}

/// The relation: whatever the clocks and the network, the true instant lies in what is said of it.
TEST(PeerClocks, TheTrueInstantLiesWithin) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Pair pair(seed);
    pair.slowest_ns = std::pow(10, pair.uniform(4, 8.5));
    pair.lost = pair.uniform(0, 0.5);
    int n_known = 0;
    double narrowest = 1e18;
    for (int i = 0; i < 400; ++i) {
      const double sent_ns = pair.now_ns;
      pair.now_ns += pair.way_ns();
      if (const auto instant = pair.reading_of(sent_ns)) {
        ++n_known;
        // A double has 2 ns of these clocks.
        ASSERT_LE(instant->earliest_ns, pair.here.reads(sent_ns) + 4) << seed << " " << i;
        ASSERT_GE(instant->latest_ns, pair.here.reads(sent_ns) - 4) << seed << " " << i;
        narrowest =
            std::min(narrowest, static_cast<double>(instant->latest_ns - instant->earliest_ns));
      }
      pair.exchange();
      pair.now_ns += pair.uniform(0, 3e8);
    }
    EXPECT_GT(n_known, 380) << seed;
    // Some exchange met two quick ways; between two of them 400 ppm of 5 s are 2 ms, and 500 are
    // allowed for on both sides.
    EXPECT_LT(narrowest, pair.slowest_ns + 2 * 2.5e6) << seed;
  }
}

TEST(PeerClocks, ARecordingIsNeverFresh) {
  Pair pair(1);
  // Nobody answers for whoever was recorded, and until somebody does nothing is fresh.
  const std::int64_t sent = pair.there.reads(0);
  EXPECT_FALSE(pair.here.clocks.is_fresh(pair.there.instance, sent, pair.here.reads(0)));
  const auto question = pair.here.clocks.question(pair.here.reads(0));
  ASSERT_TRUE(question);
  EXPECT_NE(pair.here.clocks.unanswered(), "");
  // An answer that was recorded: to another asker, to a question of before, or to none.
  clock_exchange_t answer = *question;
  answer.heard_ns = answer.answered_ns = sent;
  for (const auto& [asker, asked_ns] :
       {std::pair{on_clock(1, 6), answer.asked_ns}, {answer.asker, answer.asked_ns - 1}}) {
    clock_exchange_t other = answer;
    other.asker = asker;
    other.asked_ns = asked_ns;
    pair.here.clocks.take(other, pair.here.reads(1e5));
    EXPECT_FALSE(pair.here.clocks.is_fresh(pair.there.instance, sent, pair.here.reads(1e5)));
  }
  pair.here.clocks.take(answer, pair.here.reads(1e5));
  EXPECT_TRUE(pair.here.clocks.is_fresh(pair.there.instance, sent, pair.here.reads(1e5)));
  EXPECT_EQ(pair.here.clocks.unanswered(), "");
  // And once it is known, what is replayed is old, though its host lives.
  for (double later = 1e8; later < 60e9; later += 1e8) {
    pair.now_ns = later;
    pair.exchange();
    const bool fresh = pair.here.clocks.is_fresh(pair.there.instance, sent, pair.here.reads(later));
    if (later < 1.9e9) EXPECT_TRUE(fresh) << later;
    if (later > 2e9) EXPECT_FALSE(fresh) << later;
  }
}

TEST(PeerClocks, AnAnswerTwiceOrLateIsNone) {
  Pair pair(2);
  pair.reading_of(0);
  const auto question = pair.here.clocks.question(pair.here.reads(0));
  const auto answer = pair.there.clocks.take(*question, pair.there.reads(1e5));
  ASSERT_TRUE(answer);
  EXPECT_FALSE(pair.here.clocks.question(pair.here.reads(1e8)))
      << "asked twice within half a second";
  pair.here.clocks.take(*answer, pair.here.reads(3e9));
  EXPECT_FALSE(pair.here.clocks.instant(pair.there.instance, 1, pair.here.reads(3e9)));
  // Nobody else answers, nor does whoever asks himself.
  EXPECT_FALSE(pair.here.clocks.take(*question, 5));
  EXPECT_FALSE(PeerClocks(on_clock(2, 8)).take(*question, 5));
}

/// A host that was suspended: its clock stood still meanwhile.
TEST(PeerClocks, AClockThatSteppedIsFoundAgain) {
  Pair pair(3);
  const auto is_right = [&] {
    const auto instant = pair.reading_of(pair.now_ns);
    return instant && instant->earliest_ns <= pair.here.reads(pair.now_ns) &&
           instant->latest_ns >= pair.here.reads(pair.now_ns);
  };
  pair.reading_of(0);
  pair.exchange();
  ASSERT_TRUE(is_right());
  for (const double step : {-30e9, 7e9, -5e7}) {
    pair.there.ahead_ns += step;
    EXPECT_FALSE(is_right());
    // It is asked again within 5 s, or half a second after something that cannot be.
    const bool seen = step < -1e9;
    if (seen)
      pair.here.clocks.is_fresh(pair.there.instance, pair.there.reads(pair.now_ns),
                                pair.here.reads(pair.now_ns));
    pair.now_ns += seen ? 0.6e9 : 5.1e9;
    is_right();
    pair.exchange();
    EXPECT_TRUE(is_right()) << step;
  }
}

/// What nobody sends: no reading of it, and no arithmetic beyond an int64 (the sanitizers look).
TEST(PeerClocks, NoNumberIsBelieved) {
  const std::int64_t values[] = {INT64_MIN,     INT64_MIN + 1, -1,       0, 1, fresh_ns,
                                 INT64_MAX / 2, INT64_MAX - 1, INT64_MAX};
  for (const std::int64_t heard : values) {
    for (const std::int64_t answered : values) {
      PeerClocks clocks(on_clock(1, 1));
      const std::int64_t peer = on_clock(2, 2);
      clocks.is_fresh(peer, heard, 1'000'000);
      auto question = clocks.question(1'000'000);
      ASSERT_TRUE(question);
      question->heard_ns = heard;
      question->answered_ns = answered;
      clocks.take(*question, 2'000'000);
      for (const std::int64_t reading : values) {
        const auto instant = clocks.instant(peer, reading, 3'000'000);
        if (instant) EXPECT_LE(instant->earliest_ns, instant->latest_ns);
      }
    }
  }
}

/// More peers than are remembered: the one that was heard last is.
TEST(PeerClocks, AFloodForgetsOnlyWhoIsSilent) {
  Pair pair(4);
  pair.reading_of(0);
  pair.exchange();
  for (std::int64_t i = 0; i < 1000; ++i) {
    pair.now_ns += 1e5;
    pair.here.clocks.is_fresh(on_clock(9, 100 + i), 5, pair.here.reads(pair.now_ns));
    ASSERT_TRUE(pair.reading_of(pair.now_ns)) << i;
  }
}

/// Live peers, more than there are places, that all say something ten times a second: those that
/// are known stay so, and another one gets the place of one that is silent, or answers no more.
TEST(PeerClocks, MorePeersThanPlacesDoNotPushEachOtherOut) {
  constexpr std::int64_t places = 16, n_peers = 40, ahead = 5'000'000'000'000;
  PeerClocks here(on_clock(1, 1));
  std::int64_t now = 1'000'000'000;
  std::int64_t first_that_answers = 0;
  std::array<std::int64_t, n_peers> n_fresh{};
  const auto run = [&](std::int64_t from, std::int64_t to, std::int64_t duration_ns) {
    n_fresh.fill(0);
    for (const std::int64_t end = now + duration_ns; now < end;) {
      for (std::int64_t i = from; i < to; ++i) {
        now += 100'000'000 / (to - from);
        n_fresh[static_cast<std::size_t>(i)] += here.is_fresh(on_clock(2 + i, 7), now + ahead, now);
        while (auto question = here.question(now)) {
          if ((question->asked >> bits_below_clock) - 2 < first_that_answers) continue;
          question->heard_ns = question->answered_ns = now + ahead;
          now += 100'000;
          here.take(*question, now);
        }
      }
    }
    return std::ranges::count_if(n_fresh, [](std::int64_t n) { return n > 0; });
  };
  EXPECT_EQ(run(0, n_peers, 10'000'000'000), places);
  const std::int64_t most = *std::ranges::max_element(n_fresh);
  for (const std::int64_t n : n_fresh) EXPECT_TRUE(n == 0 || n > most - 2) << n;
  EXPECT_NE(here.unanswered().find("more than 16"), std::string::npos);
  // Those of before are silent.
  EXPECT_EQ(run(20, 30, 4'000'000'000), 10);
  first_that_answers = 30;
  run(20, 36, 20'000'000'000);
  run(20, 40, 10'000'000'000);
  for (std::int64_t i = 30; i < 40; ++i) EXPECT_GT(n_fresh[static_cast<std::size_t>(i)], 60) << i;
}

/// Who answers no question keeps no place, however often he is heard: a recording, at a higher rate
/// than all others.
TEST(PeerClocks, WhoDoesNotAnswerMakesRoom) {
  constexpr std::int64_t ahead = 5'000'000'000'000;
  PeerClocks here(on_clock(1, 1));
  const auto hear = [&](std::int64_t peer, std::int64_t now) {
    const bool fresh = here.is_fresh(on_clock(peer, 7), now + ahead, now);
    while (auto question = here.question(now)) {
      if (question->asked == on_clock(99, 7)) continue;
      question->heard_ns = question->answered_ns = now + ahead;
      here.take(*question, now + 1000);
    }
    return fresh;
  };
  int n_fresh = 0;
  for (std::int64_t now = 1'000'000'000; now < 11'000'000'000; now += 10'000'000) {
    hear(99, now);
    const std::int64_t part = now % 100'000'000;
    for (std::int64_t peer = 2; part == 0 && peer < 17; ++peer) hear(peer, now + 1);
    if (part == 50'000'000 && now > 5'000'000'000) n_fresh += hear(17, now + 1);
  }
  EXPECT_GT(n_fresh, 50);
}

/// Both sides come to the same, and who is older by more than what the network blurs stays.
TEST(Identity, WhoBeganFirstIsOneOfTheTwo) {
  std::mt19937_64 random(8);
  const auto uniform = [&](double from, double to) {
    return std::uniform_real_distribution<double>(from, to)(random);
  };
  for (int trial = 0; trial < 20'000; ++trial) {
    const bool one_clock = trial % 4 == 0;
    Host a{on_clock(1, 1 + static_cast<std::int64_t>(random() % 100)), uniform(0, 1e16),
           uniform(-200, 200)};
    Host b{on_clock(one_clock ? 1 : 2, 200), uniform(0, 1e16), uniform(-200, 200)};
    if (trial % 2 == 0) std::swap(a.instance, b.instance);
    if (one_clock) b.ahead_ns = a.ahead_ns, b.ppm = a.ppm;
    const double now = std::pow(10, uniform(9, 15));
    const double a_began = uniform(0, now);
    const double b_began =
        trial % 3 == 0 ? std::clamp(a_began + uniform(-5e9, 5e9), 0.0, now) : uniform(0, now);
    // What each has last said is up to 0.3 s old.
    const auto said = [&](const Host& host, double began, double ago) {
      return Beginning{host.instance, host.reads(began), host.reads(std::max(began, now - ago))};
    };
    const bool by_a = began_first(said(a, a_began, 0), said(b, b_began, uniform(0, 3e8)));
    const bool by_b = began_first(said(b, b_began, 0), said(a, a_began, uniform(0, 3e8)));
    const double apart = std::abs(a_began - b_began),
                 within = 2e9 + 1e-3 * (now - std::min(a_began, b_began));
    // But for the edge, where the plant decides which of two it obeys.
    const bool edge = !one_clock && std::abs(apart - within) < 3e8 + 2e-3 * within + 4e-4 * now;
    if (!edge) EXPECT_NE(by_a, by_b) << trial;
    if (apart > 3.5e9 + 2e-3 * now) EXPECT_EQ(by_a, a_began < b_began) << trial;
  }
}

/// Where the difference of two ages is as large as the bound to what the network takes, the sides
/// may differ: then both stay, which the plant decides, until the bound has grown by as much. Never
/// do both leave, whenever each of them judges.
TEST(Identity, AtTheEdgeNeverDoBothLeaveAndBothStayForAWhile) {
  std::mt19937_64 random(11);
  const auto uniform = [&](double from, double to) {
    return std::uniform_real_distribution<double>(from, to)(random);
  };
  int n_both = 0;
  for (int trial = 0; trial < 20'000; ++trial) {
    const bool smaller_is_older = trial % 2 == 0;
    const Host older{on_clock(smaller_is_older ? 1 : 2, 5), uniform(0, 1e16), uniform(-200, 200)};
    const Host younger{on_clock(smaller_is_older ? 2 : 1, 5), uniform(0, 1e16), uniform(-200, 200)};
    // Of a status, which counts for 2 s.
    const double older_way = uniform(0, 2e9), younger_way = uniform(0, 2e9);
    const double age = std::pow(10, uniform(10, 14));
    // To the bound itself, and what ways and drifts make of it.
    const double apart = 2e9 + 1e-3 * age + uniform(-1, 1) * (1e9 + 1e-3 * age);
    const auto stay = [&](double after) {
      const double now = age + after;
      const auto said = [&](const Host& host, double began, double ago) {
        return Beginning{host.instance, host.reads(began), host.reads(now - ago)};
      };
      return std::pair(began_first(said(older, 0, 0), said(younger, apart, younger_way)),
                       began_first(said(younger, apart, 0), said(older, 0, older_way)));
    };
    const auto [older_stays, younger_stays] = stay(0);
    EXPECT_TRUE(older_stays || younger_stays) << trial;
    if (!older_stays || !younger_stays) continue;
    ++n_both;
    const auto [later_older, later_younger] = stay((older_way + younger_way) / 5e-4);
    EXPECT_NE(later_older, later_younger) << trial;
  }
  EXPECT_GT(n_both, 100);
}

TEST(Identity, NamesTheClockThatItsProcessReads) {
  const std::int64_t one = new_instance(), other = new_instance();
  EXPECT_NE(one, other);
  EXPECT_TRUE(on_one_clock(one, other));
  EXPECT_GT(one >> bits_below_clock, 0);
  EXPECT_LT(one, std::int64_t{1} << 53);
  EXPECT_TRUE(on_one_clock(one, 17)) << "a number that names no clock";
  EXPECT_FALSE(on_one_clock(one, one ^ std::int64_t{1} << 40));
}

}  // namespace
}  // namespace stillframe

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <string>
#include <vector>

#include "controller/request_queue.hpp"

namespace stillframe::controller {
namespace {

std::string allowed(Request) { return ""; }

/// What a loop does with its slot, and no more: it obeys one request a period.
class FakeLoop {
 public:
  void period() {
    const RequestSlot::Asked asked = slot.take();
    if (asked.request == Request::start) wanted = true;
    if (asked.request == Request::stop) wanted = false;
    if (asked.request != Request::none) obeyed.push_back(asked.request);
    slot.done(asked);
  }
  RequestSlot slot;
  bool wanted = false;
  std::vector<Request> obeyed;
};

TEST(RequestSlot, AStopTakesThePlaceOfAStartAndKeepsIt) {
  RequestSlot slot;
  const std::int64_t start = slot.ask(Request::start), stop = slot.ask(Request::stop);
  EXPECT_GT(stop, start);
  EXPECT_EQ(slot.ask(Request::start), 0);
  EXPECT_EQ(slot.ask(Request::reset), 0);
  EXPECT_FALSE(slot.is_done(start));
  const auto taken = slot.take();
  EXPECT_EQ(taken.request, Request::stop);
  EXPECT_FALSE(slot.is_done(stop));
  slot.done(taken);
  EXPECT_TRUE(slot.is_done(stop));
  EXPECT_EQ(slot.take().request, Request::none);
}

TEST(RequestQueue, AResetThatAStopOvertakesIsObeyedAllTheSame) {
  FakeLoop loop;
  RequestQueue requests;
  requests.hear(Request::reset, 1);
  requests.serve(loop.slot, allowed);
  requests.hear(Request::stop, 2);
  for (int i = 0; i < 5; ++i) {
    requests.serve(loop.slot, allowed);
    loop.period();
  }
  EXPECT_EQ(loop.obeyed, (std::vector{Request::stop, Request::reset}));
}

// Random requests at random times, with a loop that sleeps now and then.
TEST(RequestQueue, AfterAStopOnlyALaterStartStarts) {
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    std::mt19937_64 random(seed);
    FakeLoop loop;
    RequestQueue requests;
    std::map<std::int64_t, int> answers;
    std::int64_t nonce = 0;
    Request last = Request::none;
    bool stop_pending = false;
    for (int step = 0; step < 60; ++step) {
      if (random() % 3 == 0 && nonce < 12) {
        const auto request = static_cast<Request>(1 + random() % 3);
        requests.hear(request, ++nonce);
        if (request != Request::reset) last = request;
        stop_pending |= request == Request::stop;
      }
      requests.serve(loop.slot, allowed);
      if (random() % 4 != 0) {
        // A stop that was heard is the next thing that is obeyed.
        const std::size_t before = loop.obeyed.size();
        loop.period();
        if (stop_pending && loop.obeyed.size() > before) {
          ASSERT_EQ(loop.obeyed.back(), Request::stop) << "seed " << seed;
          stop_pending = false;
        }
      }
      while (const auto answer = requests.answer()) ++answers[answer->nonce];
    }
    for (int i = 0; i < 100; ++i) {
      requests.serve(loop.slot, allowed);
      loop.period();
      while (const auto answer = requests.answer()) ++answers[answer->nonce];
    }
    EXPECT_EQ(loop.wanted, last == Request::start) << "seed " << seed;
    EXPECT_EQ(answers.size(), static_cast<std::size_t>(nonce)) << "seed " << seed;
    for (const auto& [n, times] : answers) EXPECT_EQ(times, 1) << "seed " << seed << ", " << n;
  }
}

TEST(RequestQueue, AStopFindsRoomHoweverManyAreHeardAndNoneIsLostInSilence) {
  FakeLoop loop;
  RequestQueue requests;
  std::map<std::int64_t, std::string> answers;
  const auto take_answers = [&] {
    while (const auto answer = requests.answer()) {
      EXPECT_EQ(answers.count(answer->nonce), 0U);
      answers[answer->nonce] = answer->answer;
    }
  };
  const auto flood = [&](std::int64_t from) {
    for (std::int64_t n = from; n < from + 100; ++n) requests.hear(Request::reset, n);
    take_answers();
  };
  flood(1);
  requests.hear(Request::stop, 5000);
  flood(10'000);
  requests.serve(loop.slot, allowed);
  loop.period();
  EXPECT_EQ(loop.obeyed, std::vector{Request::stop});
  for (int i = 0; i < 100; ++i) {
    requests.serve(loop.slot, allowed);
    loop.period();
    take_answers();
  }
  EXPECT_EQ(answers.size(), 201U);
  EXPECT_EQ(answers.at(5000), "");
  EXPECT_EQ(answers.at(1), "");
  EXPECT_EQ(answers.at(100), "too many requests wait");
}

}  // namespace
}  // namespace stillframe::controller

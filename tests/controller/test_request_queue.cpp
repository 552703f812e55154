#include <gtest/gtest.h>

#include <map>
#include <random>
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

TEST(RequestQueue, EachIsObeyedOnceHoweverOftenItIsHeard) {
  FakeLoop loop;
  RequestQueue requests;
  // The asker of the start repeats it after a stop was obeyed; that is no new start.
  for (const auto& [request, nonce] : std::vector<std::pair<Request, std::int64_t>>{
           {Request::start, 1}, {Request::start, 1}, {Request::stop, 2}, {Request::start, 1}}) {
    requests.hear(request, nonce);
    for (int i = 0; i < 3; ++i) {
      requests.serve(loop.slot, allowed);
      loop.period();
    }
  }
  EXPECT_EQ(loop.obeyed, (std::vector{Request::start, Request::stop}));
  EXPECT_FALSE(loop.wanted);
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

// Random requests at random times, heard again and again until their answer is told, with a loop
// that sleeps now and then.
TEST(RequestQueue, AfterAStopOnlyALaterStartStarts) {
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    std::mt19937_64 random(seed);
    FakeLoop loop;
    RequestQueue requests;
    std::vector<std::pair<Request, std::int64_t>> repeated;
    std::map<std::int64_t, int> answers;
    std::int64_t nonce = 0;
    Request last = Request::none;
    bool stop_pending = false;
    const auto hear = [&](Request request, std::int64_t n) {
      requests.hear(request, n);
      if (n <= nonce) return;
      nonce = n;
    };
    for (int step = 0; step < 60; ++step) {
      if (random() % 3 == 0 && repeated.size() < 12) {
        const auto request = static_cast<Request>(1 + random() % 3);
        repeated.emplace_back(request, nonce + 1);
        hear(request, nonce + 1);
        if (request != Request::reset) last = request;
        stop_pending |= request == Request::stop;
      }
      if (!repeated.empty()) {
        const auto& [request, n] = repeated[random() % repeated.size()];
        hear(request, n);
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
    EXPECT_EQ(answers.size(), repeated.size()) << "seed " << seed;
    for (const auto& [n, times] : answers) EXPECT_EQ(times, 1) << "seed " << seed << ", " << n;
  }
}

TEST(RequestQueue, AStopFindsRoomHoweverManyAreHeard) {
  FakeLoop loop;
  RequestQueue requests;
  const auto flood = [&](std::int64_t from) {
    for (std::int64_t n = from; n < from + 1000; ++n) requests.hear(Request::reset, n);
  };
  flood(1);
  requests.hear(Request::stop, 5000);
  flood(10'000);
  requests.serve(loop.slot, allowed);
  loop.period();
  EXPECT_EQ(loop.obeyed, std::vector{Request::stop});
}

}  // namespace
}  // namespace stillframe::controller

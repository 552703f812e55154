#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <random>

#include "controller/requests.hpp"
#include "msgs/peer_clocks.hpp"

namespace stillframe::controller {
namespace {

using stillframe_msgs::control_request_t;

constexpr std::int64_t ms = 1'000'000;

control_request_t request(std::int64_t nonce, std::int64_t asked_ns, std::int64_t sent_ns,
                          std::int32_t what) {
  control_request_t message{};
  message.nonce = nonce;
  message.asked_ns = asked_ns;
  message.sent_ns = sent_ns;
  message.request = what;
  return message;
}

TEST(Requests, AStartThatIsHeardAgainDoesNotUndoAStop) {
  Requests requests;
  const std::int64_t now = 1000 * ns_per_s;
  const auto start = request(1, now - 20 * ms, now - 20 * ms, control_request_t::START);
  EXPECT_TRUE(requests.admits(start, now));
  EXPECT_TRUE(
      requests.admits(request(2, now - 10 * ms, now - 10 * ms, control_request_t::STOP), now));
  EXPECT_FALSE(requests.admits(start, now));
  // Nor one that was asked before the stop and comes only now, though it is repeated.
  EXPECT_FALSE(requests.admits(request(3, now - 15 * ms, now, control_request_t::START), now));
  EXPECT_TRUE(requests.admits(request(4, now - 5 * ms, now, control_request_t::START), now));
  // A stop is always taken.
  EXPECT_TRUE(requests.admits(request(5, now - 30 * ms, now, control_request_t::STOP), now));
}

TEST(Requests, NothingIsObeyedThatWasNotSentJustNow) {
  Requests requests;
  const std::int64_t now = 1000 * ns_per_s;
  std::int64_t nonce = 0;
  for (const std::int64_t sent :
       {now - fresh_ns, now + 1, std::int64_t{0}, std::int64_t{-1},
        std::numeric_limits<std::int64_t>::min(), std::numeric_limits<std::int64_t>::max()}) {
    for (std::int32_t what = control_request_t::START; what <= control_request_t::RESET; ++what) {
      EXPECT_FALSE(requests.admits(request(++nonce, sent, sent, what), now)) << sent;
      EXPECT_FALSE(requests.admits(request(++nonce, 1, sent, what), now)) << sent;
    }
  }
  EXPECT_FALSE(requests.admits(request(0, now, now, control_request_t::STOP), now));
  EXPECT_FALSE(requests.admits(request(++nonce, now + 1, now, control_request_t::START), now));
  EXPECT_TRUE(requests.admits(request(++nonce, now, now, control_request_t::STOP), now));
}

// A bus that loses, repeats, delays and replays what several askers say: each is obeyed once at
// most, no start or reset after a request that was asked later, and every stop that is heard fresh.
TEST(Requests, OrderAndOnceWhateverTheBusDoes) {
  std::mt19937_64 random(7);
  for (int trial = 0; trial < 300; ++trial) {
    Requests requests;
    std::vector<control_request_t> said;
    std::map<std::int64_t, int> obeyed;
    std::int64_t now = static_cast<std::int64_t>(random() % 1'000'000) * ns_per_s + ns_per_s;
    std::int64_t newest = 0;
    for (int step = 0; step < 200; ++step) {
      now += static_cast<std::int64_t>(random() % 400) * ms;
      control_request_t next;
      if (said.empty() || random() % 3 == 0) {
        const auto what = static_cast<std::int32_t>(1 + random() % 3);
        next = request(static_cast<std::int64_t>(1 + said.size()), now, now, what);
        said.push_back(next);
        if (random() % 3 == 0) continue;  // lost
      } else {
        next = said[random() % said.size()];        // as it was recorded
        if (random() % 2 == 0) next.sent_ns = now;  // or by its asker
      }
      const bool fresh = now - next.sent_ns < fresh_ns,
                 stop = next.request == control_request_t::STOP;
      const bool expected = fresh && obeyed[next.nonce] == 0 && (stop || next.asked_ns > newest);
      ASSERT_EQ(requests.admits(next, now), expected) << trial << " " << step;
      if (!expected) continue;
      ++obeyed[next.nonce];
      newest = std::max(newest, next.asked_ns);
    }
  }
}

}  // namespace
}  // namespace stillframe::controller

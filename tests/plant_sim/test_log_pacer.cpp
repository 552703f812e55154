#include <gtest/gtest.h>

#include <atomic>
#include <fstream>
#include <optional>
#include <thread>

#include "msgs/clock.hpp"
#include "plant_sim/log_pacer.hpp"

namespace stillframe {
namespace {

class LogPacerTest : public testing::Test {
 protected:
  void grow(size_t bytes) { std::ofstream(log_, std::ios::app) << std::string(bytes, 'x'); }
  // A name of its own: tests run side by side.
  std::filesystem::path log_ =
      std::filesystem::path(testing::TempDir()) /
      (std::string(testing::UnitTest::GetInstance()->current_test_info()->name()) + ".lcm");
  void SetUp() override { std::ofstream(log_, std::ios::trunc) << "header"; }
  void TearDown() override { std::filesystem::remove(log_); }
};

constexpr size_t nudge_bytes = 28 + 15;  // event header, "SF_LOGGER_CHECK", no payload

TEST_F(LogPacerTest, WaitsOnlyWhileMoreThanSixteenSmallMessagesAreMissing) {
  int nudges = 0;
  std::optional<LogPacer> pacer;
  // A logger that writes every nudge at once, and with the tenth what it held besides.
  pacer.emplace(log_, [&] {
    pacer->sent(0, 15);
    grow(nudge_bytes + (++nudges == 10 ? 4000 : 0));
  });
  EXPECT_TRUE(pacer->begin());
  EXPECT_EQ(nudges, 1);
  for (int i = 0; i < 16; ++i) pacer->sent(58, 14);  // 100 bytes each in the log
  EXPECT_TRUE(pacer->wait());
  EXPECT_EQ(nudges, 1);  // sixteen may be missing without a wait
  for (int i = 0; i < 20; ++i) pacer->sent(58, 14);
  EXPECT_TRUE(pacer->wait());
  EXPECT_EQ(nudges, 10);
}

// As lcm-logger does with messages of a frame: what does not fill a block is not seen.
TEST_F(LogPacerTest, ALoggerThatKeepsUpByBlocksNeedsNoNudgeAndNeverHasThirtyToTake) {
  for (const size_t bytes : {250u, 300u, 444u, 1000u, 5000u}) {
    SetUp();
    std::atomic<int> nudges = 0;
    std::optional<LogPacer> pacer;
    pacer.emplace(log_, [&] {
      pacer->sent(0, 15);
      grow(nudge_bytes);
      ++nudges;
    });
    ASSERT_TRUE(pacer->begin());
    size_t sent = 0, written = 0;
    const auto send = [&] {
      pacer->sent(bytes - 28 - 14, 14);
      sent += bytes;
    };
    for (int i = 0; i < 100; ++i) {
      send();
      const size_t blocks = sent / 4096 * 4096;
      grow(blocks - written);
      written = blocks;
      ASSERT_TRUE(pacer->wait());
    }
    EXPECT_EQ(nudges.load(), 1) << bytes;
    // And of one that does not, it is the pacer who waits, and nudges, before thirty are missing.
    int missing = 0;
    for (; missing < 30 && nudges == 1; ++missing) {
      send();
      // Late, and however late the pacer is on a machine that is busy.
      std::atomic<bool> done = false;
      std::thread late([&] {
        do {
          sleep_until(monotonic_ns() + 3'000'000);
        } while (!done && nudges == 1);
        grow(nudges > 1 ? sent - written : 0);
      });
      EXPECT_TRUE(pacer->wait());
      done = true;
      late.join();
    }
    EXPECT_LE(missing, 25) << bytes;
  }
}

TEST_F(LogPacerTest, BeginsOnlyWhenOlderMessagesAreWritten) {
  int nudges = 0;
  std::optional<LogPacer> pacer;
  // Two messages of before come out with the first two nudges.
  pacer.emplace(log_, [&] {
    pacer->sent(0, 15);
    grow(nudge_bytes + (++nudges <= 2 ? 100 : 0));
  });
  EXPECT_TRUE(pacer->begin());
  EXPECT_EQ(nudges, 3);
}

}  // namespace
}  // namespace stillframe

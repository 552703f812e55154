#include <gtest/gtest.h>

#include <fstream>

#include "plant_sim/log_pacer.hpp"

namespace stillframe {
namespace {

class LogPacerTest : public testing::Test {
 protected:
  void grow(size_t bytes) { std::ofstream(log_, std::ios::app) << std::string(bytes, 'x'); }
  std::filesystem::path log_ = std::filesystem::path(testing::TempDir()) / "pacer.lcm";
  void SetUp() override { std::ofstream(log_, std::ios::trunc) << "header"; }
  void TearDown() override { std::filesystem::remove(log_); }
};

TEST_F(LogPacerTest, WaitsOnlyWhileMoreThanTwentyMessagesAreMissing) {
  int nudges = 0;
  // The tenth nudge stands for a logger that then writes out what it held.
  LogPacer pacer(log_, [&] {
    if (++nudges == 10) grow(4000);
  });
  pacer.begin();
  EXPECT_EQ(nudges, 1);
  for (int i = 0; i < 20; ++i) pacer.sent(58, 14);  // 100 bytes each in the log
  EXPECT_TRUE(pacer.wait());
  EXPECT_EQ(nudges, 1);  // twenty may be missing without a wait
  for (int i = 0; i < 20; ++i) pacer.sent(58, 14);
  EXPECT_TRUE(pacer.wait());
  EXPECT_EQ(nudges, 10);
}

}  // namespace
}  // namespace stillframe

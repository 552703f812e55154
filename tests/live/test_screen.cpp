#include <sstream>

#include "report/live/screen.hpp"
#include "report/live/styled_text.hpp"
#include "tests/live/watched.hpp"

namespace stillframe::live {
namespace {

class ScreenTest : public Watched {
 protected:
  std::string text(int width = 120, int height = 0, bool colours = false) const {
    return to_text(view(), {.width = width, .height = height}, colours);
  }
  void hear_run(std::int64_t last) {
    hear_info(7);
    hear(channels::run_state, sample::state(7, "plant", stillframe_msgs::run_state_t::RUNNING));
    hear_samples(7, 0, last);
    hear(channels::status, sample::status(7));
    hear(channels::loop, sample::records(7, {sample::record(now, 90'000, 7000)}));
  }
  static std::vector<std::string> lines(const std::string& text) {
    std::vector<std::string> list;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) list.push_back(line);
    return list;
  }
  static std::string line_with(const std::string& text, const std::string& part) {
    for (const std::string& line : lines(text)) {
      if (line.find(part) != std::string::npos) return line;
    }
    return "";
  }
};

TEST_F(ScreenTest, HasEveryNumber) {
  hear_run(20'000);
  const std::string all = text();
  for (const char* part :
       {"A sample", "run 7", "active, wall_clock, 1000 Hz", "running, 20.0 s of 60.0 s",
        "1001: 1002 late, 1003 lost, 1004 without a measurement, 1005 limited",
        "1006, 1007 rejoined, 1008 messages dropped", "wake-up 187.2 us, compute 30.4 us",
        "last 10 s 90.0 us, 7.0 us", "over the last 16.0 s"}) {
    EXPECT_NE(all.find(part), std::string::npos) << part << " in\n" << all;
  }
  // Amplitudes of 2 and 0.5 mm/s^2 at 10 Hz: rms, peak, velocity 22.51 and 5.627 um/s.
  EXPECT_NE(line_with(all, "x     floor").find("1.414         2     22.51        10        VC-B"),
            std::string::npos)
      << all;
  EXPECT_NE(line_with(all, "frame  ").find("0.3536       0.5     5.627        10        VC-D"),
            std::string::npos)
      << all;
  EXPECT_NE(line_with(all, "ratio").find("0.2500"), std::string::npos) << all;
  EXPECT_NE(line_with(all, "leg_2").find("50        50    25.0 %"), std::string::npos) << all;
  EXPECT_NE(line_with(all, "SF_MEASUREMENT").find("1000.0       20001       0"), std::string::npos)
      << all;
}

/// The bar of a velocity that is exactly a criterion's ends at its letter, and a louder one is
/// longer.
TEST_F(ScreenTest, BarsReachTheirCriterion) {
  hear_run(20'000);
  const std::string all = text(140);
  const std::string head = line_with(all, "rms mm/s^2"), bar = line_with(all, "x     floor");
  const auto end = bar.rfind('=') + 1;
  // 22.5 um/s lies between VC-C, 12.5, and VC-B, 25.
  EXPECT_GT(end, head.rfind('C'));
  EXPECT_LE(end, head.rfind('B') + 1);
  EXPECT_LT(line_with(all, "frame  ").rfind('='), end - 4);
}

TEST_F(ScreenTest, NoLineIsWiderThanTheTerminal) {
  hear_run(5'000);
  hear_samples(7, 5100, 5101);
  for (int width = 20; width <= 200; ++width) {
    for (const std::string& line : lines(text(width))) EXPECT_LE(width_of(line), width) << line;
  }
}

TEST_F(ScreenTest, ALowTerminalGetsTheTop) {
  hear_run(5'000);
  const auto whole = lines(text(100));
  for (const int height : {1, 5, 10}) {
    const auto some = lines(text(100, height));
    ASSERT_EQ(some.size(), static_cast<std::size_t>(height));
    EXPECT_TRUE(std::equal(some.begin(), some.end(), whole.begin()));
  }
}

TEST_F(ScreenTest, ColoursAreOnlyThereIfAskedFor) {
  hear_run(5'000);
  EXPECT_EQ(text(100, 0, false).find('\033'), std::string::npos);
  const std::string coloured = text(100, 0, true);
  EXPECT_NE(coloured.find("\033[32mactive\033[0m"), std::string::npos) << coloured;
}

/// Names come from the bus; on a terminal a control character is a command.
TEST_F(ScreenTest, NamesCannotCommandTheTerminal) {
  auto info = sample::info(7);
  info.scene_name =
      "evil\033]0;title\007\x9b"
      "31m\xc2\x9b\r\n\ttail \xe2\x82\xac";
  info.leg_names = {"\033[2J", "leg\xff"};
  hear(channels::run_info, info);
  hear_samples(7, 0, 3000);
  auto status = sample::status(7);
  status.text = "active\033[31m";
  hear(channels::status, status);
  const std::string all = text();
  for (const char c : all) {
    EXPECT_TRUE(c == '\n' || static_cast<unsigned char>(c) >= 0x20) << static_cast<int>(c);
  }
  EXPECT_NE(all.find("evil\\x1b]0;title\\x07\\x9b31m\\xc2\\x9b\\x0d\\x0a\\x09tail \xe2\x82\xac"),
            std::string::npos)
      << all;
  EXPECT_NE(all.find("leg\\xff"), std::string::npos);
}

TEST_F(ScreenTest, NothingHeardIsSaid) {
  now += 7 * sample::second;
  EXPECT_EQ(text(200),
            "stillframe watch\n! nothing heard for 7 s on udpm://a.bus; is a run going on, and in "
            "the same network (scripts/private_network)?\n");
}

TEST(StyledText, PadsAndCutsByCharacters) {
  EXPECT_EQ(padded("ab", 4), "ab  ");
  EXPECT_EQ(padded("ab", 4, false), "  ab");
  EXPECT_EQ(padded("abcdef", 4), "abcd");
  EXPECT_EQ(padded("\xc2\xb5m", 4), "\xc2\xb5m  ");
  EXPECT_EQ(padded("\xc2\xb5m/s", 2), "\xc2\xb5m");
  EXPECT_EQ(padded("x", 0), "");
}

}  // namespace
}  // namespace stillframe::live

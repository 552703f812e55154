#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "tests/live/bus_plant.hpp"
#include "tests/tools/verb.hpp"

namespace stillframe::live {
namespace {

/// `stillframe watch` on a terminal of its own.
class OnATerminal : public testing::Test {
 protected:
  void start(std::uint16_t columns, std::uint16_t rows) {
    const winsize size{.ws_row = rows, .ws_col = columns, .ws_xpixel = 0, .ws_ypixel = 0};
    pid_ = forkpty(&terminal_, nullptr, nullptr, &size);
    ASSERT_GE(pid_, 0);
    if (pid_ > 0) return;
    const std::string program = std::string(STILLFRAME_BIN_DIR) + "/stillframe";
    execl(program.c_str(), "stillframe", "watch", nullptr);
    _exit(127);
  }

  void TearDown() override {
    if (pid_ > 0) {
      kill(pid_, SIGKILL);
      waitpid(pid_, nullptr, 0);
    }
    if (terminal_ >= 0) close(terminal_);
  }

  /// Reads until a text has come so many times, or the terminal is closed.
  bool read_until(const std::string& text, int times = 1) {
    char buffer[4096];
    for (;;) {
      int n = 0;
      for (std::size_t at = 0; (at = screen_.find(text, at)) != std::string::npos; ++at) ++n;
      if (n >= times) return true;
      const ssize_t size = read(terminal_, buffer, sizeof buffer);
      if (size <= 0) return false;
      screen_.append(buffer, static_cast<std::size_t>(size));
    }
  }

  int wait() {
    read_until("\x01 never");
    int status = 0;
    waitpid(pid_, &status, 0);
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

  static constexpr const char* enter = "\033[?1049h\033[?25l";
  static constexpr const char* leave = "\033[?25h\033[?1049l";

  pid_t pid_ = -1;
  int terminal_ = -1;
  std::string screen_;
};

/// Ctrl-C is a character that the terminal makes a signal of.
TEST_F(OnATerminal, CtrlCGivesTheTerminalBack) {
  sample::BusPlant plant(7, 0, true);
  start(100, 40);
  ASSERT_TRUE(read_until("\033[H\033[1mstillframe watch   A sample", 3));
  ASSERT_EQ(write(terminal_, "\x03", 1), 1);
  EXPECT_EQ(wait(), 0);
  EXPECT_TRUE(screen_.starts_with(enter));
  const auto end = screen_.find(leave);
  ASSERT_NE(end, std::string::npos);
  EXPECT_EQ(end + std::string(leave).size(), screen_.size()) << "something came after it";
}

TEST_F(OnATerminal, FollowsTheSizeOfTheTerminal) {
  sample::BusPlant plant(7, 0, true);
  start(100, 40);
  ASSERT_TRUE(read_until("SF_MEASUREMENT"));
  const winsize small{.ws_row = 4, .ws_col = 30, .ws_xpixel = 0, .ws_ypixel = 0};
  ASSERT_EQ(ioctl(terminal_, TIOCSWINSZ, &small), 0);
  screen_.clear();
  ASSERT_TRUE(read_until("\033[H", 4));
  const auto first = screen_.find("\033[H", screen_.find("\033[H") + 1);
  const std::string frame = screen_.substr(first, screen_.find("\033[H", first + 1) - first);
  EXPECT_EQ(std::count(frame.begin(), frame.end(), '\n'), 3) << frame;  // four lines
  EXPECT_EQ(frame.find("SF_MEASUREMENT"), std::string::npos);
}

/// Ctrl-Z leaves the shell a terminal that is as it was, and fg comes back to the screen.
TEST_F(OnATerminal, CtrlZGivesTheTerminalBackForAsLong) {
  sample::BusPlant plant(7, 0, true);
  start(100, 40);
  ASSERT_TRUE(read_until("\033[H\033[1mstillframe watch", 2));
  kill(pid_, SIGTSTP);
  int status = 0;
  ASSERT_EQ(waitpid(pid_, &status, WUNTRACED), pid_);
  ASSERT_TRUE(WIFSTOPPED(status));
  ASSERT_TRUE(read_until(leave));
  EXPECT_TRUE(screen_.ends_with(leave));
  kill(pid_, SIGCONT);
  EXPECT_TRUE(read_until(enter, 2));
  EXPECT_TRUE(read_until("stillframe watch", 3));
  kill(pid_, SIGTERM);
  EXPECT_EQ(wait(), 0);
  EXPECT_TRUE(screen_.ends_with(leave));
}

}  // namespace
}  // namespace stillframe::live
